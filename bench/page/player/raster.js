// Disks and thick lines as pixels. A canvas takes several times as long for thousands of them.

/** A layer of pixels with smooth edges; colours are 0xBBGGRR, places and sizes in pixels. */
class Raster {
  constructor() {
    this.canvas = document.createElement('canvas');
    this.pen = this.canvas.getContext('2d');
  }

  /** Begins an empty layer. */
  begin(width, height) {
    if (this.width !== width || this.height !== height) {
      Object.assign(this, {width, height});
      Object.assign(this.canvas, {width, height});
      this.image = this.pen.createImageData(width, height);
      this.pixels = new Uint32Array(this.image.data.buffer);
    }
    this.pixels.fill(0);
  }
  /** Lays it over another canvas. */
  end(pen) {
    this.pen.putImageData(this.image, 0, 0);
    pen.drawImage(this.canvas, 0, 0);
  }

  /** A colour over a pixel; `share`: how much of it, 0 to 256. */
  cover(at, colour, share) {
    const {pixels} = this, below = pixels[at], under = below >>> 24;
    if (under === 0) {
      pixels[at] = colour | Math.min(255, share) << 24;
      return;
    }
    // Where the pixel below is half empty, its colour counts less.
    const a = under === 255 ? share : Math.round(65536 * share / (256 * share + under * (256 - share)));
    const r = below & 255, g = below >> 8 & 255, b = below >> 16 & 255;
    const whole = under === 255 ? 255 : Math.min(255, under + ((255 - under) * share >> 8));
    pixels[at] = whole << 24 | b + (((colour >> 16 & 255) - b) * a >> 8) << 16 |
        g + (((colour >> 8 & 255) - g) * a >> 8) << 8 | r + (((colour & 255) - r) * a >> 8);
  }

  /** A disk of the colour look[0], whose edge of the width `line` has the colour look[1]. */
  disk(x, y, r, look, line, opacity = 1) {
    const {width, height, pixels} = this, outer = r + line / 2 + 0.5, inner = r - line / 2 - 0.5;
    if (!(x > -outer && x < width + outer && y > -outer && y < height + outer)) return;
    const [fill, edge] = look, share = 256 * opacity, solid = fill | Math.min(255, share) << 24;
    const bottom = Math.min(height - 1, Math.floor(y + outer)), outer2 = outer * outer, inner2 = inner > 0 ? inner * inner : -1;
    for (let row = Math.max(0, Math.floor(y - outer)); row <= bottom; ++row) {
      const dy = row + 0.5 - y, wide = outer2 - dy * dy;
      if (wide <= 0) continue;
      const half = Math.sqrt(wide), begin = Math.max(0, Math.floor(x - half)), end = Math.min(width, Math.ceil(x + half));
      let at = row * width + begin;
      for (let column = begin; column < end; ++column, ++at) {
        const dx = column + 0.5 - x, away2 = dx * dx + dy * dy;
        if (away2 < inner2) {  // to the other side at once
          const stop = Math.min(end, Math.floor(x + Math.sqrt(inner2 - dy * dy) + 0.5));
          do pixels[at++] = solid; while (++column < stop);
          --column, --at;
          continue;
        }
        const away = outer - Math.sqrt(away2);
        if (away > 0) this.cover(at, line && away < line + 0.5 ? edge : fill, away < 1 ? away * share : share);
      }
    }
  }

  /** A line with round ends. */
  line(x0, y0, x1, y1, thick, colour, opacity = 1) {
    const {width, height, pixels} = this, reach = thick / 2 + 0.5, whole = 256 * opacity;
    const left = Math.min(x0, x1) - reach, right = Math.max(x0, x1) + reach;
    const top = Math.max(0, Math.floor(Math.min(y0, y1) - reach)), bottom = Math.min(height - 1, Math.floor(Math.max(y0, y1) + reach));
    if (!(right > 0 && left < width) || top > bottom) return;
    const dx = x1 - x0, dy = y1 - y0, scale = 1 / (dx * dx + dy * dy || 1e-12), full = 0xff000000 | colour;
    const reach2 = reach * reach, inside2 = opacity === 1 && reach > 1 ? (reach - 1) * (reach - 1) : -1;
    // Along a row the distance to the endless line grows by |dy| / length with each pixel.
    const steep = Math.abs(dy) > 1e-6, slope = steep ? dx / dy : 0, span = steep ? reach / (Math.abs(dy) * Math.sqrt(scale)) : Infinity;
    for (let row = top; row <= bottom; ++row) {
      const py = row + 0.5 - y0, middle = x0 + py * slope;
      const begin = Math.max(0, Math.floor(Math.max(left, middle - span))), end = Math.min(width, Math.ceil(Math.min(right, middle + span)));
      for (let column = begin, at = row * width + begin; column < end; ++column, ++at) {
        const px = column + 0.5 - x0, t = (px * dx + py * dy) * scale, along = t < 0 ? 0 : t > 1 ? 1 : t;
        const ex = px - along * dx, ey = py - along * dy, away2 = ex * ex + ey * ey;
        if (away2 >= reach2) continue;
        if (away2 < inside2) pixels[at] = full;
        else this.cover(at, colour, Math.min(1, reach - Math.sqrt(away2)) * whole);
      }
    }
  }
  /** Dots along a line. */
  dots(x0, y0, x1, y1, thick, apart, colour) {
    const count = Math.max(1, Math.round(Math.hypot(x1 - x0, y1 - y0) / apart));
    for (let k = 0; k < count; ++k) {
      const at = (k + 0.5) / count;
      this.disk(x0 + at * (x1 - x0), y0 + at * (y1 - y0), thick / 2, [colour, colour], 0);
    }
  }
}

/** "rgb(r g b / share)" or "#rrggbb" as [0xBBGGRR, share]. */
function pixelColour(css) {
  if (css[0] === '#') return [parseInt(css.slice(5, 7) + css.slice(3, 5) + css.slice(1, 3), 16), 1];
  const [r, g, b, share = 1] = css.match(/[\d.]+/g).map(Number);
  return [b << 16 | g << 8 | r, share];
}
/** Part `share` of one colour in another. */
function mixed(colour, other, share) {
  const part = shift => Math.round((colour >> shift & 255) * (1 - share) + (other >> shift & 255) * share) << shift;
  return part(16) | part(8) | part(0);
}
