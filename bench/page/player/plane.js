// Disks on a canvas: walls, periodic images, bodies, force chains, arrows, paths.

class PlaneView {
  constructor(canvas, run) {
    this.canvas = canvas;
    this.run = run;
    this.pen = canvas.getContext('2d');
    this.raster = new Raster();
    this.middle = [0, 0];
    this.scale = 1;  // pixels of the screen per metre
    this.box = this.wholeBox();
  }

  /** Box that shows what happens: bodies of all times but strays, segments, circles. */
  wholeBox() {
    const {run} = this, left = [], right = [], below = [], above = [], box = [Infinity, Infinity, -Infinity, -Infinity];
    const include = (x, y) => {
      box[0] = Math.min(box[0], x), box[1] = Math.min(box[1], y);
      box[2] = Math.max(box[2], x), box[3] = Math.max(box[3], y);
    };
    const stride = Math.max(1, Math.floor(run.frames.length / 50));
    run.frames.forEach((frame, f) => {
      if (f % stride) return;
      for (let k = 0; k < frame.count; ++k) {
        const [x, y] = placeOf(run, frame, k), r = run.radius[frame.number[k]];
        left.push(x - r), right.push(x + r), below.push(y - r), above.push(y + r);
      }
    });
    for (const frame of [run.frames[0], run.frames.at(-1)]) {
      run.about.joints.flatMap(joint => jointLines(run, frame, joint)).forEach(line => include(...line[1]));
    }
    if (left.length) {
      const stray = left.length > 5000 ? 0.002 : 0;
      include(quantile(left, stray), quantile(below, stray));
      include(quantile(right, 1 - stray), quantile(above, 1 - stray));
    }
    for (const frame of [run.frames[0], run.frames.at(-1)]) {
      run.about.walls.forEach((wall, w) => {
        const [ax, ay, bx, by, present] = frame.walls.slice(5 * w, 5 * w + 5);
        if (!present) return;
        if (wall.shape === 'segment') include(ax, ay), include(bx, by);
        if (wall.radius > 0) include(ax - wall.radius, ay - wall.radius), include(ax + wall.radius, ay + wall.radius);
        if (wall.shape === 'plane' && left.length) {  // the foot of the box on the wall, if it is near
          const [nx, ny] = wall.normal, cx = (box[0] + box[2]) / 2, cy = (box[1] + box[3]) / 2;
          const away = (cx - ax) * nx + (cy - ay) * ny;
          if (Math.abs(away) < Math.max(box[2] - box[0], box[3] - box[1])) include(cx - away * nx, cy - away * ny);
        }
      });
      if (frame.cell) {
        const [w, h] = frame.cell, edge = 0.12 * w;  // images are shown so far around
        include(-edge, h ? -edge : box[1]), include(w + edge, h ? h + edge : box[3]);
      }
    }
    for (const {lower, upper} of run.about.openings) if (lower) include(...lower), include(...upper);
    if (!(box[2] > box[0])) return [-1, -1, 1, 1];
    return box;
  }

  fit() {
    const {width, height} = this.size(), [x0, y0, x1, y1] = this.box;
    const edge = Math.min(26, width / 4, height / 4);
    this.moved = false;
    this.middle = [(x0 + x1) / 2, (y0 + y1) / 2];
    this.scale = Math.min((width - 2 * edge) / (x1 - x0 || 1e-9), (height - 2 * edge) / (y1 - y0 || 1e-9));
    this.fitted = this.scale;
  }
  size() {
    return {width: this.canvas.clientWidth, height: this.canvas.clientHeight};
  }
  resize() {
    const ratio = this.ratio = Math.min(window.devicePixelRatio || 1, 2);
    const {width, height} = this.size();
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
  }
  toScreen(x, y) {
    const {width, height} = this.size();
    return [width / 2 + (x - this.middle[0]) * this.scale, height / 2 - (y - this.middle[1]) * this.scale];
  }
  toScene(px, py) {
    const {width, height} = this.size();
    return [this.middle[0] + (px - width / 2) / this.scale, this.middle[1] - (py - height / 2) / this.scale];
  }
  zoom(factor, px, py) {
    this.moved = true;
    const {width, height} = this.size();
    const before = this.toScene(px ?? width / 2, py ?? height / 2);
    this.scale = Math.min(this.fitted * 2000, Math.max(this.fitted / 20, this.scale * factor));
    const after = this.toScene(px ?? width / 2, py ?? height / 2);
    this.middle[0] += before[0] - after[0];
    this.middle[1] += before[1] - after[1];
  }
  drag(dx, dy) {
    this.moved = true;
    this.middle[0] -= dx / this.scale;
    this.middle[1] += dy / this.scale;
  }
  turn(dx, dy) { this.drag(dx, dy); }

  draw(frame, look) {
    if (!this.canvas.width || !this.canvas.height) return;
    const {pen, run} = this, {colours} = look;
    const ratio = this.ratio, {width, height} = this.size();
    if (look.centred && look.picked?.body !== undefined) {
      const k = indexOf(frame, look.picked.body);
      if (k >= 0) this.middle = placeOf(run, frame, k);
    }
    this.pxRadius = run.meanRadius * this.scale;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.fillStyle = colours.stage;
    pen.fillRect(0, 0, this.canvas.width, this.canvas.height);
    // Scene to screen: y goes up.
    const s = this.scale * ratio;
    this.s = s;
    this.ox = width / 2 * ratio - this.middle[0] * s;
    this.oy = height / 2 * ratio + this.middle[1] * s;
    if (look.walls) this.drawWalls(frame, colours);
    this.drawOpenings(colours);
    const paint = coloured(run, frame, look.colour, colours);
    this.raster.begin(this.canvas.width, this.canvas.height);
    if (frame.cell) this.drawImages(frame, paint, colours);
    this.drawBodies(frame, paint, colours, 0, 0, 1);
    if (look.spokes || look.colour === 'plain') this.drawSpokes(frame, colours);
    if (look.chains) this.drawChains(frame, look, colours);
    this.raster.end(pen);
    if (frame.cell) this.drawCell(frame, colours);
    if (look.walls) this.drawJoints(frame, colours);
    if (look.arrows) this.drawArrows(frame, colours);
    if (look.picked) this.drawPicked(frame, look, colours);
  }

  X(x) { return this.ox + x * this.s; }
  Y(y) { return this.oy - y * this.s; }

  hatch(colours) {
    const step = Math.round(7 * this.ratio);
    if (this.hatched?.colours === colours && this.hatched.step === step) return this.hatched.pattern;
    const tile = document.createElement('canvas');
    tile.width = tile.height = step;
    const pen = tile.getContext('2d');
    pen.fillStyle = colours.solid;
    pen.fillRect(0, 0, step, step);
    pen.strokeStyle = colours.hatch;
    pen.lineWidth = 1.1 * this.ratio;
    for (const shift of [-step, 0, step]) {
      pen.beginPath();
      pen.moveTo(shift - 1, step + 1);
      pen.lineTo(shift + step + 1, -1);
      pen.stroke();
    }
    this.hatched = {colours, step, pattern: this.pen.createPattern(tile, 'repeat')};
    return this.hatched.pattern;
  }

  drawWalls(frame, colours) {
    const {pen, run, ratio} = this, pattern = this.hatch(colours);
    const W = this.canvas.width, H = this.canvas.height, far = 2 * (W + H);
    const walls = run.about.walls.map((wall, w) => {
      const [ax, ay, bx, by, present] = frame.walls.slice(5 * w, 5 * w + 5);
      return {...wall, a: [this.X(ax), this.Y(ay)], b: [this.X(bx), this.Y(by)], present, turned: frame.turns?.[w]};
    }).filter(wall => wall.present);
    const planes = walls.filter(wall => wall.shape === 'plane');
    // The line of a half-plane through the foot of the canvas' middle, so that it covers the canvas.
    const lines = planes.map(({a, normal: [nx, ny]}) => {
      const along = [-ny, -nx];  // on the screen, where y goes down
      const shift = (W / 2 - a[0]) * along[0] + (H / 2 - a[1]) * along[1];
      const foot = [a[0] + shift * along[0], a[1] + shift * along[1]];
      return {foot, along, out: [nx, -ny]};
    });
    pen.strokeStyle = colours.wall;
    pen.lineWidth = 3 * ratio;
    pen.beginPath();
    for (const {foot, along} of lines) {
      pen.moveTo(foot[0] - far * along[0], foot[1] - far * along[1]);
      pen.lineTo(foot[0] + far * along[0], foot[1] + far * along[1]);
    }
    pen.stroke();
    // A hatched strip along the line; what lies deeper covers strips and lines of other walls.
    const fillBehind = (begin, end) => {
      for (const {foot, along, out} of lines) {
        pen.beginPath();
        for (const [side, depth] of [[-far, begin], [far, begin], [far, end], [-far, end]]) {
          pen.lineTo(foot[0] + side * along[0] - depth * out[0], foot[1] + side * along[1] - depth * out[1]);
        }
        pen.fill();
      }
    };
    const strip = 16 * ratio;
    pen.fillStyle = pattern;
    fillBehind(0, strip);
    pen.fillStyle = colours.stage;
    fillBehind(strip, far);
    for (const wall of walls) {
      if (wall.radius > 0 && wall.shape !== 'segment' && wall.shape !== 'plane') this.drawCircle(frame, wall, pattern, colours);
    }
    pen.strokeStyle = colours.wall;
    pen.lineWidth = 3 * ratio;
    pen.lineCap = 'round';
    pen.beginPath();
    for (const wall of walls) {
      if (wall.shape === 'segment') pen.moveTo(...wall.a), pen.lineTo(...wall.b);
    }
    pen.stroke();
  }

  /** A circle, hatched where it is solid; ticks turn with it. */
  drawCircle(frame, wall, pattern, colours) {
    const {pen, ratio} = this, r = wall.radius * this.s, band = 14 * ratio;
    const hollow = wall.shape === 'hollow';
    pen.fillStyle = pattern;
    pen.beginPath();
    pen.arc(...wall.a, hollow ? r + band : r, 0, 2 * Math.PI);
    if (hollow) pen.arc(...wall.a, r, 0, 2 * Math.PI, true);
    pen.fill();
    pen.strokeStyle = colours.wall;
    pen.lineWidth = 2.5 * ratio;
    pen.beginPath();
    pen.arc(...wall.a, r, 0, 2 * Math.PI);
    if (wall.turns && wall.turned !== undefined) {
      const out = hollow ? 1 : -1;
      for (let k = 0; k < 12; ++k) {
        const at = -wall.turned + k * Math.PI / 6, c = Math.cos(at), s = Math.sin(at);
        pen.moveTo(wall.a[0] + r * c, wall.a[1] + r * s);
        pen.lineTo(wall.a[0] + (r + out * band) * c, wall.a[1] + (r + out * band) * s);
      }
    }
    pen.stroke();
  }

  /** Ropes, and pins with their point. */
  drawJoints(frame, colours) {
    const {pen, run, ratio} = this;
    pen.strokeStyle = pen.fillStyle = colours.wall;
    pen.lineWidth = 2 * ratio;
    for (const joint of run.about.joints) {
      for (const [from, to] of jointLines(run, frame, joint)) {
        pen.beginPath();
        pen.moveTo(this.X(from[0]), this.Y(from[1]));
        pen.lineTo(this.X(to[0]), this.Y(to[1]));
        pen.stroke();
        pen.beginPath();
        pen.arc(this.X(to[0]), this.Y(to[1]), 3.5 * ratio, 0, 2 * Math.PI);
        pen.fill();
      }
    }
  }

  drawOpenings(colours) {
    const {pen, ratio} = this;
    pen.lineWidth = 1.6 * ratio;
    pen.setLineDash([6 * ratio, 4 * ratio]);
    pen.font = `${12 * ratio}px system-ui, sans-serif`;
    pen.textAlign = 'right';
    for (const opening of this.run.about.openings) {
      pen.strokeStyle = pen.fillStyle = opening.kind === 'outlet' ? colours.outlet : colours.inlet;
      pen.beginPath();
      let label;
      if (opening.point) {
        const along = [-opening.normal[1], opening.normal[0]], far = 1e3 * (this.box[2] - this.box[0]);
        const [x, y] = opening.point;
        pen.moveTo(this.X(x - far * along[0]), this.Y(y - far * along[1]));
        pen.lineTo(this.X(x + far * along[0]), this.Y(y + far * along[1]));
        label = [this.canvas.width - 8 * ratio, Math.min(this.canvas.height, this.Y(y)) - 7 * ratio];
      } else {
        const [x0, y0] = opening.lower, [x1, y1] = opening.upper;
        pen.rect(this.X(x0), this.Y(y1), (x1 - x0) * this.s, (y1 - y0) * this.s);
        label = [this.X(x1) - 6 * ratio, this.Y(y1) + 15 * ratio];
      }
      pen.stroke();
      pen.fillText(opening.kind === opening.name || !opening.name ? opening.kind : `${opening.kind} ${opening.name}`, ...label);
    }
    pen.setLineDash([]);
  }

  /** Images of bodies beside the cell, pale. */
  drawImages(frame, paint, colours) {
    const [w, h, offset] = frame.cell;
    const o = offset - Math.round(offset / w) * w;  // images repeat along x
    for (let ky = h ? -1 : 0; ky <= (h ? 1 : 0); ++ky) {
      for (let kx = -2; kx <= 2; ++kx) {
        if (kx || ky) this.drawBodies(frame, paint, colours, kx * w + ky * o, ky * h, 0.28);
      }
    }
  }
  drawCell(frame, colours) {
    const {pen, ratio} = this, [w, h] = frame.cell;
    pen.strokeStyle = colours.wall;
    pen.lineWidth = 1.4 * ratio;
    pen.setLineDash([7 * ratio, 5 * ratio]);
    pen.beginPath();
    if (h) {
      pen.rect(this.X(0), this.Y(h), w * this.s, h * this.s);
    } else {
      for (const x of [0, w]) pen.moveTo(this.X(x), 0), pen.lineTo(this.X(x), this.canvas.height);
    }
    pen.stroke();
    pen.setLineDash([]);
  }

  drawBodies(frame, {index, list}, colours, dx, dy, opacity) {
    const {run, ratio, s, raster} = this, n = frame.count, q = run.quantum;
    const [edge, share] = pixelColour(colours.edge);
    const looks = list.map(([r, g, b]) => b << 16 | g << 8 | r).map(fill => [fill, mixed(fill, edge, share)]);
    const line = this.pxRadius > 2.2 ? Math.min(1.2, 0.25 + this.pxRadius / 14) * ratio : 0;
    for (let k = 0; k < n; ++k) {
      raster.disk(this.X(frame.x[k] * q + dx), this.Y(frame.x[n + k] * q + dy), run.radius[frame.number[k]] * s,
        looks[index[k]], line, opacity);
    }
  }

  drawSpokes(frame, colours) {
    const {run, ratio, s, raster} = this, n = frame.count, q = run.quantum, [edge, share] = pixelColour(colours.edge);
    const thick = Math.min(1.8, 0.5 + this.pxRadius / 12) * ratio;
    for (let k = 0; k < n; ++k) {
      const x = this.X(frame.x[k] * q), y = this.Y(frame.x[n + k] * q), r = run.radius[frame.number[k]] * s;
      raster.line(x, y, x + r * COS[frame.turn[k]], y - r * SIN[frame.turn[k]], thick, edge, share);
    }
  }

  /** Lines from centre to centre, the strongest last; of a pair across the border of a cell from both. */
  drawChains(frame, look, colours) {
    const {run, ratio, raster, s} = this, n = frame.count, q = run.quantum, full = fullForce(run);
    const thick = Math.min(11, Math.max(2.5, 0.75 * this.pxRadius)) * ratio;
    const [open] = pixelColour(colours.open), [stick] = pixelColour(colours.stick), [slip] = pixelColour(colours.slip);
    const [tension] = pixelColour(colours.tension);
    const trace = (k, draw) => {
      const i = indexOf(frame, frame.i[k]), wall = frame.j[k] >= WALL;
      const x = this.X(frame.x[i] * q), y = this.Y(frame.x[n + i] * q);
      const length = (run.radius[frame.i[k]] + LOG[frame.gap[k]] + (wall ? 0 : run.radius[frame.j[k]])) * s;
      const ex = x - length * COS[frame.n[k]], ey = y + length * SIN[frame.n[k]];
      draw(x, y, ex, ey);
      if (!frame.cell || wall) return;
      const j = indexOf(frame, frame.j[k]), jx = this.X(frame.x[j] * q), jy = this.Y(frame.x[n + j] * q);
      if (Math.hypot(jx - ex, jy - ey) >= run.radius[frame.j[k]] * s) draw(x + jx - ex, y + jy - ey, jx, jy);
    };
    const pushing = [];
    for (let k = 0; k < frame.contacts; ++k) {
      if (carries(frame, k)) pushing.push(k);
      else if (look.open && frame.status[k] === 0) {
        trace(k, (x0, y0, x1, y1) => raster.dots(x0, y0, x1, y1, 1.4 * ratio, 3.6 * ratio, open));
      }
    }
    pushing.sort((a, b) => Math.abs(LOG[frame.fn[a]]) - Math.abs(LOG[frame.fn[b]]));
    for (const k of pushing) {
      const width = Math.max(0.5 * ratio, Math.min(1.25, Math.abs(LOG[frame.fn[k]]) / full) * thick);
      trace(k, (x0, y0, x1, y1) => raster.line(x0, y0, x1, y1, width, forceColour(frame, k, {stick, slip, tension})));
    }
  }

  drawArrows(frame, colours) {
    const {pen, run, ratio} = this, n = frame.count, q = run.quantum;
    const length = 3.2 * run.meanRadius / (rangeOf(run, 'speed')[1] || 1);
    pen.strokeStyle = colours.arrow;
    pen.lineWidth = 1.5 * ratio;
    pen.beginPath();
    for (let k = 0; k < n; ++k) {
      const vx = LOG[frame.v[k]] * length, vy = LOG[frame.v[n + k]] * length, size = Math.hypot(vx, vy) * this.s;
      if (size < 2 * ratio) continue;
      const x = this.X(frame.x[k] * q), y = this.Y(frame.x[n + k] * q);
      const tx = x + vx * this.s, ty = y - vy * this.s, head = Math.min(6 * ratio, 0.4 * size);
      const ux = (tx - x) / size, uy = (ty - y) / size;
      pen.moveTo(x, y);
      pen.lineTo(tx, ty);
      pen.moveTo(tx - head * (ux + 0.5 * uy), ty - head * (uy - 0.5 * ux));
      pen.lineTo(tx, ty);
      pen.lineTo(tx - head * (ux - 0.5 * uy), ty - head * (uy + 0.5 * ux));
    }
    pen.stroke();
  }

  /** The body that is followed with its path, or the contact. */
  drawPicked(frame, look, colours) {
    const {pen, run, ratio} = this;
    pen.strokeStyle = colours.path;
    if (look.picked.body === undefined) {
      const k = contactIndex(frame, look.picked);
      if (k < 0) return;
      pen.lineWidth = 3 * ratio;
      const [x, y] = placeOf(run, frame, indexOf(frame, frame.i[k])), a = run.radius[frame.i[k]];
      pen.beginPath();
      pen.arc(this.X(x - a * COS[frame.n[k]]), this.Y(y - a * SIN[frame.n[k]]), 6 * ratio, 0, 2 * Math.PI);
      pen.stroke();
      return;
    }
    const number = look.picked.body;
    const path = later => {
      pen.beginPath();
      let last = null;
      for (const f of run.frames) {
        if (later ? f.step < frame.step : f.step > frame.step) continue;
        const k = indexOf(f, number);
        if (k < 0) continue;
        const [x, y] = placeOf(run, f, k);
        const jump = f.cell && last && Math.hypot(x - last[0], y - last[1]) > 0.4 * f.cell[0];
        if (last && !jump) pen.lineTo(this.X(x), this.Y(y)); else pen.moveTo(this.X(x), this.Y(y));
        last = [x, y];
      }
      pen.stroke();
    };
    pen.lineWidth = 1.8 * ratio;
    pen.lineJoin = 'round';
    pen.globalAlpha = 0.35;
    path(true);
    pen.globalAlpha = 1;
    path(false);
    const k = indexOf(frame, number);
    if (k < 0) return;
    const [x, y] = placeOf(run, frame, k);
    pen.lineWidth = 2.6 * ratio;
    pen.beginPath();
    pen.arc(this.X(x), this.Y(y), run.radius[number] * this.s + 1.5 * ratio, 0, 2 * Math.PI);
    pen.stroke();
  }

  /** What stands at a place of the screen: {body} or {i, j}, or null. */
  pick(frame, look, px, py) {
    const {run} = this, [x, y] = this.toScene(px, py), near = 5 / this.scale;
    if (look.chains) {
      for (let k = 0; k < frame.contacts; ++k) {
        if (!frame.fn[k] && !look.open) continue;
        const at = indexOf(frame, frame.i[k]), a = run.radius[frame.i[k]];
        const cx = frame.x[at] * run.quantum - a * COS[frame.n[k]];
        const cy = frame.x[frame.count + at] * run.quantum - a * SIN[frame.n[k]];
        if (Math.hypot(cx - x, cy - y) < Math.min(near, 0.35 * a)) return {i: frame.i[k], j: frame.j[k]};
      }
    }
    for (let k = 0; k < frame.count; ++k) {
      const a = run.radius[frame.number[k]];
      const dx = frame.x[k] * run.quantum - x, dy = frame.x[frame.count + k] * run.quantum - y;
      if (dx * dx + dy * dy < a * a) return {body: frame.number[k]};
    }
    return null;
  }
  lengthScale() { return this.scale; }
}

/** Index of a contact {i, j} in a frame, -1: it is not there. */
function contactIndex(frame, {i, j}) {
  for (let k = 0; k < frame.contacts; ++k) if (frame.i[k] === i && frame.j[k] === j) return k;
  return -1;
}
