// Spheres in space: WebGL2. A sphere is a square on which each pixel meets the exact sphere.

const SPHERE_VERTEX = `#version 300 es
layout(location=0) in vec2 corner;
layout(location=1) in vec4 sphere;   // centre, radius
layout(location=2) in vec4 colour;
layout(location=3) in vec4 turn;     // unit quaternion
uniform mat4 view, projection;
out vec3 at; flat out vec3 centre; flat out float radius; flat out vec4 tint; flat out vec4 turned;
void main() {
  vec3 c = (view * vec4(sphere.xyz, 1)).xyz;
  float r = sphere.w, d = max(length(c), 1.001 * r);
  vec3 to = c / d;                                     // from the eye
  vec3 side = normalize(cross(to, abs(to.y) < 0.9 ? vec3(0,1,0) : vec3(1,0,0)));
  float wide = r * d / sqrt(d * d - r * r) * 1.02;     // silhouette in perspective
  at = c + wide * (corner.x * side + corner.y * cross(side, to));
  centre = c; radius = r; tint = colour; turned = turn;
  gl_Position = projection * vec4(at, 1);
}`;
const SPHERE_FRAGMENT = `#version 300 es
precision highp float;
in vec3 at; flat in vec3 centre; flat in float radius; flat in vec4 tint; flat in vec4 turned;
uniform mat4 projection, view; uniform float glass, pattern;
out vec4 result;
vec3 back(vec4 q, vec3 v) {  // inverse rotation
  vec3 t = 2.0 * cross(-q.xyz, v);
  return v + q.w * t + cross(-q.xyz, t);
}
void main() {
  vec3 ray = normalize(at);
  float b = dot(ray, centre), h = b * b - dot(centre, centre) + radius * radius;
  if (h < 0.0) discard;
  vec3 hit = (b - sqrt(h)) * ray, n = (hit - centre) / radius;
  vec4 clip = projection * vec4(hit, 1);
  gl_FragDepth = 0.5 * clip.z / clip.w + 0.5;
  float facing = max(0.0, -dot(n, ray));
  float light = 0.46 + 0.56 * max(0.0, dot(n, normalize(vec3(-0.35, 0.65, 0.7))));
  vec3 rgb = tint.rgb * (light + 0.1 * facing) + 0.1 * pow(max(0.0, dot(n, normalize(vec3(-0.25, 0.5, 1)))), 30.0);
  if (pattern > 0.5) {
    vec3 own = back(turned, transpose(mat3(view)) * n);
    float w = fwidth(own.x * own.y * own.z) + 1e-4;
    if (own.x * own.y * own.z > 0.0) rgb *= 0.8;
    if (min(min(abs(own.x), abs(own.y)), abs(own.z)) < 0.03) rgb *= 0.7;
  }
  rgb *= mix(0.72, 1.0, smoothstep(0.0, 0.32, facing));
  result = vec4(rgb, tint.a);
  if (glass > 0.5) result = vec4(tint.rgb * 0.8, 0.1 + 0.6 * pow(1.0 - facing, 2.5));
}`;
const TUBE_VERTEX = `#version 300 es
layout(location=0) in vec3 corner;   // cosine, sine, 0 or 1 along
layout(location=1) in vec4 from;     // and radius
layout(location=2) in vec3 to;
layout(location=3) in vec4 colour;
uniform mat4 view, projection;
out vec3 normal; out vec4 tint;
void main() {
  vec3 axis = normalize(to - from.xyz + vec3(0, 0, 1e-12));
  vec3 u = normalize(cross(axis, abs(axis.z) < 0.9 ? vec3(0,0,1) : vec3(1,0,0))), v = cross(axis, u);
  vec3 n = corner.x * u + corner.y * v;
  normal = mat3(view) * n; tint = colour;
  gl_Position = projection * view * vec4(mix(from.xyz, to, corner.z) + from.w * n, 1);
}`;
const TUBE_FRAGMENT = `#version 300 es
precision highp float;
in vec3 normal; in vec4 tint; out vec4 result;
void main() {
  vec3 n = normalize(normal);
  result = vec4(tint.rgb * (0.62 + 0.38 * max(0.0, dot(n, normalize(vec3(-0.35, 0.65, 0.7))))), tint.a);
}`;
const FLAT_VERTEX = `#version 300 es
layout(location=0) in vec3 place; layout(location=1) in vec4 colour;
uniform mat4 view, projection; out vec4 tint;
void main() { tint = colour; gl_Position = projection * view * vec4(place, 1); }`;
const FLAT_FRAGMENT = `#version 300 es
precision highp float; in vec4 tint; out vec4 result;
void main() { result = tint; }`;

const IMAGE_SHARE = 0.12;  // of the width of a cell, by which images stand beyond its faces
const sub3 = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const add3 = (a, b, t = 1) => [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]];
const dot3 = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross3 = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit3 = a => { const s = Math.hypot(...a) || 1; return a.map(x => x / s); };
/** Numbers 0 to 1 of "#rrggbb". */
const rgbOf = hex => [1, 3, 5].map(k => parseInt(hex.slice(k, k + 2), 16) / 255);

class SpaceView {
  constructor(canvas, run) {
    this.canvas = canvas;
    this.run = run;
    const gl = this.gl = canvas.getContext('webgl2', {antialias: true});
    if (!gl) throw new Error('This browser has no WebGL2, which the picture in space needs.');
    this.spheres = this.program(SPHERE_VERTEX, SPHERE_FRAGMENT);
    this.tubes = this.program(TUBE_VERTEX, TUBE_FRAGMENT);
    this.flat = this.program(FLAT_VERTEX, FLAT_FRAGMENT);
    this.square = this.buffer(new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]));
    const rim = [];
    for (let k = 0; k <= 10; ++k) {
      const angle = k * Math.PI / 5;
      for (const end of [0, 1]) rim.push(Math.cos(angle), Math.sin(angle), end);
    }
    this.rim = this.buffer(new Float32Array(rim));
    this.rimPoints = rim.length / 3;
    this.scratch = [0, 1, 2].map(() => gl.createBuffer());
    const g = run.about.gravity, size = Math.hypot(...g);
    this.up = size > 0 ? unit3(g.map(x => -x)) : [0, 0, 1];
    this.ahead = unit3(cross3(this.up, Math.abs(this.up[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]));  // azimuth 90°
    this.aside = cross3(this.ahead, this.up);
    this.box = this.wholeBox();
    this.azimuth = -1.05;
    this.height = 0.38;
  }

  program(vertex, fragment) {
    const {gl} = this, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    const places = {};
    for (const name of ['view', 'projection', 'glass', 'pattern']) places[name] = gl.getUniformLocation(program, name);
    return {program, places};
  }
  buffer(data) {
    const {gl} = this, buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    return buffer;
  }

  wholeBox() {
    const {run} = this, box = {lower: [], upper: []}, margin = largest(run.radius);
    const stride = Math.max(1, Math.floor(run.frames.length / 40));
    for (let c = 0; c < 3; ++c) {
      const values = [];
      run.frames.forEach((frame, f) => {
        if (f % stride) return;
        for (let k = 0; k < frame.count; ++k) values.push(frame.x[c * frame.count + k] * run.quantum);
      });
      const stray = values.length > 5000 ? 0.002 : 0;
      box.lower.push(values.length ? quantile(values, stray) - margin : -1);
      box.upper.push(values.length ? quantile(values, 1 - stray) + margin : 1);
    }
    const cell = run.frames[0].cell;
    if (cell) {
      const edge = IMAGE_SHARE * cell[0];
      box.lower[0] = -edge, box.upper[0] = cell[0] + edge;
      if (cell[1]) box.lower[1] = -edge, box.upper[1] = cell[1] + edge;
    }
    return box;
  }

  fit() {
    const {lower, upper} = this.box;
    this.moved = false;
    this.middle = lower.map((x, c) => (x + upper[c]) / 2);
    this.reach = Math.hypot(...sub3(upper, lower)) / 2;
    this.angle = 0.5;  // of view, in the shorter direction
    this.distance = this.reach / Math.sin(this.angle / 2) * 1.02;
    this.fitted = this.distance;
  }
  size() { return {width: this.canvas.clientWidth, height: this.canvas.clientHeight}; }
  resize() {
    const ratio = this.ratio = Math.min(window.devicePixelRatio || 1, 2), {width, height} = this.size();
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
  }
  zoom(factor) {
    this.moved = true;
    this.distance = Math.min(this.fitted * 8, Math.max(this.fitted / 200, this.distance / factor));
  }
  /** Pixels along the screen move the middle; pixels turn the eye. */
  drag(dx, dy) {
    this.moved = true;
    const {right, above} = this.camera(), step = 1 / this.lengthScale();
    this.middle = add3(add3(this.middle, right, -dx * step), above, dy * step);
  }
  turn(dx, dy) {
    this.azimuth -= 0.008 * dx;
    this.height = Math.min(1.55, Math.max(-1.55, this.height + 0.008 * dy));
  }
  lengthScale() {
    const {width, height} = this.size();
    return Math.min(width, height) / (2 * this.distance * Math.tan(this.angle / 2));
  }

  camera() {
    const ca = Math.cos(this.azimuth), sa = Math.sin(this.azimuth), ch = Math.cos(this.height), sh = Math.sin(this.height);
    const from = unit3(add3(add3(this.aside.map(x => x * ca * ch), this.ahead, sa * ch), this.up, sh));
    const right = unit3(cross3(this.up, from)), above = cross3(from, right);
    const eye = add3(this.middle, from, this.distance);
    const view = new Float32Array([right[0], above[0], from[0], 0, right[1], above[1], from[1], 0,
      right[2], above[2], from[2], 0, -dot3(right, eye), -dot3(above, eye), -dot3(from, eye), 1]);
    const {width, height} = this.size(), t = Math.tan(this.angle / 2) / Math.min(1, width / height);
    const far = this.distance + 6 * this.reach, near = Math.max(0.005 * this.distance, this.distance - 4 * this.reach);
    const projection = new Float32Array([height / width / t, 0, 0, 0, 0, 1 / t, 0, 0,
      0, 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0]);
    return {eye, right, above, from, view, projection, t};
  }

  use({program, places}, camera) {
    const {gl} = this;
    gl.useProgram(program);
    gl.uniformMatrix4fv(places.view, false, camera.view);
    gl.uniformMatrix4fv(places.projection, false, camera.projection);
  }
  attribute(place, buffer, size, stride, offset, divisor) {
    const {gl} = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, gl.FLOAT, false, 4 * stride, 4 * offset);
    gl.vertexAttribDivisor(place, divisor);
  }
  fill(k, numbers) {
    const {gl} = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.scratch[k]);
    gl.bufferData(gl.ARRAY_BUFFER, numbers instanceof Float32Array ? numbers : new Float32Array(numbers), gl.DYNAMIC_DRAW);
  }

  /** True if the cutting plane hides a place. */
  hidden(look, x) {
    return look.cutAxis >= 0 && x[look.cutAxis] > look.cutAt;
  }

  draw(frame, look) {
    const {gl, run} = this, {colours} = look;
    if (look.centred && look.picked?.body !== undefined) {
      const k = indexOf(frame, look.picked.body);
      if (k >= 0) this.middle = placeOf(run, frame, k);
    }
    const camera = this.camera();
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(...rgbOf(colours.stage), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
    gl.depthMask(true);
    gl.bindVertexArray(null);
    const paint = coloured(run, frame, look.colour, colours);
    const visible = [];
    for (let k = 0; k < frame.count; ++k) {
      if (!this.hidden(look, placeOf(run, frame, k))) visible.push(k);
    }
    const images = look.spheres === 'none' ? [] : this.images(frame, look);
    if (look.spheres === 'solid') this.drawSpheres(frame, [...visible, ...images], paint, camera, look, false);
    if (look.chains || look.arrows || look.picked || run.about.joints.length) this.drawTubes(frame, look, colours, camera);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    if (look.spheres === 'glass') {
      const all = [...visible, ...images];
      const depth = all.map(item => dot3(camera.from, item.length === 3
        ? add3(placeOf(run, frame, item[0]), [item[1], item[2], 0]) : placeOf(run, frame, item)));
      const order = all.map((_, k) => k).sort((a, b) => depth[a] - depth[b]).map(k => all[k]);
      this.drawSpheres(frame, order, paint, camera, look, true);
    }
    if (look.walls) this.drawWalls(frame, look, colours, camera);
    gl.depthMask(true);
  }

  /** Bodies again where a cell repeats, a little beyond its faces: [body, dx, dy]. */
  images(frame, look) {
    const found = [];
    if (!frame.cell) return found;
    const {run} = this, [w, h, offset] = frame.cell, edge = IMAGE_SHARE * w;
    for (let k = 0; k < frame.count; ++k) {
      const x = placeOf(run, frame, k);
      for (let ky = h ? -1 : 0; ky <= (h ? 1 : 0); ++ky) {
        for (let kx = -2; kx <= 2; ++kx) {
          const dx = kx * w + ky * offset, dy = ky * h, ix = x[0] + dx, iy = x[1] + dy;
          const near = ix > -edge && ix < w + edge && (!h || (iy > -edge && iy < h + edge));
          if ((kx || ky) && near && !this.hidden(look, [ix, iy, x[2]])) found.push([k, dx, dy]);
        }
      }
    }
    return found;
  }

  /** `visible`: bodies, or their images [body, dx, dy], which are pale. */
  drawSpheres(frame, visible, {index, list}, camera, look, glass) {
    const {gl, run} = this, n = frame.count, q = run.quantum, data = new Float32Array(12 * visible.length);
    const stage = rgbOf(look.colours.stage);
    visible.forEach((item, at) => {
      const image = item.length === 3, [k, dx, dy] = image ? item : [item, 0, 0];
      const number = frame.number[k], rgb = image ? list[index[k]].map((x, c) => 0.35 * x + 0.65 * 255 * stage[c]) : list[index[k]];
      const dim = look.picked?.body === number ? 1 : 0;
      const x = frame.turn[k] / 32767 - 1, y = frame.turn[n + k] / 32767 - 1, z = frame.turn[2 * n + k] / 32767 - 1;
      const pick = rgbOf(look.colours.path);
      data.set([frame.x[k] * q + dx, frame.x[n + k] * q + dy, frame.x[2 * n + k] * q, run.radius[number],
        dim ? pick[0] : rgb[0] / 255, dim ? pick[1] : rgb[1] / 255, dim ? pick[2] : rgb[2] / 255, 1,
        x, y, z, Math.sqrt(Math.max(0, 1 - x * x - y * y - z * z))], 12 * at);
    });
    this.fill(0, data);
    this.use(this.spheres, camera);
    gl.uniform1f(this.spheres.places.glass, glass ? 1 : 0);
    gl.uniform1f(this.spheres.places.pattern, !glass && (look.colour === 'plain' || look.spokes) ? 1 : 0);
    this.attribute(0, this.square, 2, 2, 0, 0);
    this.attribute(1, this.scratch[0], 4, 12, 0, 1);
    this.attribute(2, this.scratch[0], 4, 12, 4, 1);
    this.attribute(3, this.scratch[0], 4, 12, 8, 1);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, visible.length);
  }

  /** Force chains, arrows and paths as tubes: from, radius, to, colour. */
  drawTubes(frame, look, colours, camera) {
    const {gl, run} = this, full = fullForce(run), tubes = [];
    const thick = 0.34 * run.meanRadius;
    const add = (a, b, radius, rgb) => tubes.push(...a, radius, ...b, ...rgb, 1);
    const stick = rgbOf(colours.stick), slip = rgbOf(colours.slip), open = rgbOf(colours.open);
    const tension = rgbOf(colours.tension);
    if (look.chains) {
      for (let k = 0; k < frame.contacts; ++k) {
        const force = carries(frame, k) ? Math.abs(LOG[frame.fn[k]]) : 0;
        if (!(force > 0) && !look.open) continue;
        const a = placeOf(run, frame, indexOf(frame, frame.i[k])), n = normalOf(run, frame, k);
        const wall = frame.j[k] >= WALL;
        const length = run.radius[frame.i[k]] + LOG[frame.gap[k]] + (wall ? 0 : run.radius[frame.j[k]]);
        const b = add3(a, n, -length);
        if (this.hidden(look, a) && this.hidden(look, b)) continue;
        if (!(force > 0)) {  // dotted
          for (let p = 0; p < 5; ++p) add(add3(a, n, -length * (p + 0.3) / 5), add3(a, n, -length * (p + 0.7) / 5), 0.025 * run.meanRadius, open);
          continue;
        }
        const width = Math.min(1, force / full) * thick;
        add(a, b, Math.max(width, 0.015 * run.meanRadius), forceColour(frame, k, {stick, slip, tension}));
      }
    }
    if (look.walls) {
      for (const [from, to] of run.about.joints.flatMap(joint => jointLines(run, frame, joint))) {
        add(from, to, 0.08 * run.meanRadius, rgbOf(colours.wall));
      }
    }
    if (look.arrows) {
      const rgb = rgbOf(colours.arrow), length = 2.6 * run.meanRadius / (rangeOf(run, 'speed')[1] || 1);
      for (let k = 0; k < frame.count; ++k) {
        const x = placeOf(run, frame, k), v = logsOf(frame.v, frame.count, k);
        if (this.hidden(look, x)) continue;
        add(x, add3(x, v, length), 0.07 * run.meanRadius, rgb);
      }
    }
    if (look.picked?.body !== undefined) {
      let last = null;
      for (const f of run.frames) {
        const k = indexOf(f, look.picked.body);
        const x = k < 0 ? null : placeOf(run, f, k);
        if (x && last && Math.hypot(...sub3(x, last)) < 20 * run.meanRadius) {
          add(last, x, 0.09 * run.meanRadius, rgbOf(colours.path));
        }
        last = x;
      }
    }
    const count = tubes.length / 11;
    if (!count) return;
    this.fill(1, tubes);
    this.use(this.tubes, camera);
    this.attribute(0, this.rim, 3, 3, 0, 0);
    this.attribute(1, this.scratch[1], 4, 11, 0, 1);
    this.attribute(2, this.scratch[1], 3, 11, 4, 1);
    this.attribute(3, this.scratch[1], 4, 11, 7, 1);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, this.rimPoints, count);
  }

  /** Planes and surfaces as faint faces, cylinders, openings and cells as outlines. */
  drawWalls(frame, look, colours, camera) {
    const {gl, run} = this, faces = [], lines = [];
    const ink = rgbOf(colours.wall), widen = 0.04 * this.reach;
    const lower = this.box.lower.map(x => x - widen), upper = this.box.upper.map(x => x + widen);
    const line = (a, b, rgb = ink, alpha = 0.75) => lines.push(...a, ...rgb, alpha, ...b, ...rgb, alpha);
    run.about.walls.forEach((wall, w) => {
      const place = frame.walls.slice(7 * w, 7 * w + 7);
      if (!place[6]) return;
      const a = place.slice(0, 3);
      if (wall.pieces) {
        for (let k = 0; k < wall.pieces.length; k += 12) {
          const corners = [0, 3, 6, 9].map(m => add3(a, wall.pieces.slice(k + m, k + m + 3), 1));
          for (const m of [0, 1, 2, 0, 2, 3]) faces.push(...corners[m], ...ink, 0.06);
          corners.forEach((corner, m) => line(corner, corners[(m + 1) % 4], ink, 0.3));
        }
        return;
      }
      if (wall.radius > 0 && wall.shape !== 'plane') {
        this.cylinder(wall, a, frame.turns?.[w] || 0, lower, upper, line);
        return;
      }
      const corners = planeInBox(a, wall.normal, lower, upper);
      // A face between the eye and the spheres would dim them.
      const before = dot3(sub3(camera.eye, a), wall.normal) < 0;
      for (let k = 1; k + 1 < corners.length; ++k) {
        for (const corner of [corners[0], corners[k], corners[k + 1]]) faces.push(...corner, ...ink, before ? 0.03 : 0.13);
      }
      corners.forEach((corner, k) => line(corner, corners[(k + 1) % corners.length], ink, before ? 0.3 : 0.75));
    });
    const frameOf = (low, high, rgb) => {
      for (let k = 0; k < 8; ++k) {
        for (let c = 0; c < 3; ++c) {
          if (k >> c & 1) continue;
          const corner = m => [0, 1, 2].map(d => m >> d & 1 ? high[d] : low[d]);
          line(corner(k), corner(k | 1 << c), rgb);
        }
      }
    };
    for (const opening of run.about.openings) {
      const rgb = rgbOf(opening.kind === 'outlet' ? colours.outlet : colours.inlet);
      if (opening.lower) frameOf(opening.lower, opening.upper, rgb);
      else {
        const corners = planeInBox(opening.point, opening.normal, lower, upper);
        corners.forEach((corner, k) => line(corner, corners[(k + 1) % corners.length], rgb));
      }
    }
    if (frame.cell) {
      const [w, h] = frame.cell;
      frameOf([0, h ? 0 : lower[1], lower[2]], [w, h || upper[1], upper[2]], ink);
    }
    if (look.cutAxis >= 0) {
      const normal = [0, 1, 2].map(c => c === look.cutAxis ? 1 : 0), at = normal.map(x => x * look.cutAt);
      const corners = planeInBox(at, normal, lower, upper);
      corners.forEach((corner, k) => line(corner, corners[(k + 1) % corners.length], rgbOf(colours.path)));
    }
    this.use(this.flat, camera);
    for (const [numbers, mode] of [[faces, gl.TRIANGLES], [lines, gl.LINES]]) {
      if (!numbers.length) continue;
      this.fill(2, numbers);
      gl.disableVertexAttribArray(2);
      gl.disableVertexAttribArray(3);
      this.attribute(0, this.scratch[2], 3, 7, 0, 0);
      this.attribute(1, this.scratch[2], 4, 7, 3, 0);
      gl.drawArrays(mode, 0, numbers.length / 7);
    }
  }

  cylinder(wall, a, turned, lower, upper, line) {
    const axis = unit3(wall.normal), u = unit3(cross3(axis, Math.abs(axis[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0])), v = cross3(axis, u);
    // Ends: where the box ends along the axis.
    let low = Infinity, high = -Infinity;
    for (let k = 0; k < 8; ++k) {
      const along = dot3(sub3([0, 1, 2].map(c => k >> c & 1 ? upper[c] : lower[c]), a), axis);
      low = Math.min(low, along), high = Math.max(high, along);
    }
    const point = (angle, along) => add3(add3(add3(a, axis, along), u, wall.radius * Math.cos(angle)), v, wall.radius * Math.sin(angle));
    const parts = 64;
    for (const [along, alpha] of [[low, 0.8], [high, 0.8], [(low + high) / 2, 0.25]]) {
      for (let k = 0; k < parts; ++k) line(point(2 * Math.PI * k / parts, along), point(2 * Math.PI * (k + 1) / parts, along), undefined, alpha);
    }
    for (let k = 0; k < 12; ++k) {
      const angle = 2 * Math.PI * k / 12 + turned;
      line(point(angle, low), point(angle, high), undefined, 0.3);
    }
  }

  pick(frame, look, px, py) {
    const {run} = this, camera = this.camera(), {width, height} = this.size();
    const x = (2 * px / width - 1) * camera.t * width / height, y = (1 - 2 * py / height) * camera.t;
    const ray = unit3(add3(add3(camera.from.map(c => -c), camera.right, x), camera.above, y));
    let best = null, nearest = Infinity;
    if (look.spheres !== 'none') {
      for (let k = 0; k < frame.count; ++k) {
        const centre = placeOf(run, frame, k);
        if (this.hidden(look, centre)) continue;
        const to = sub3(centre, camera.eye), b = dot3(to, ray), r = run.radius[frame.number[k]];
        const h = b * b - dot3(to, to) + r * r;
        if (h < 0 || b - Math.sqrt(h) > nearest) continue;
        nearest = b - Math.sqrt(h);
        best = {body: frame.number[k]};
      }
    }
    if (!look.chains || look.spheres === 'solid') return best;
    // Chains are seen through glass: the nearest contact point within a few pixels.
    let close = 6 / this.lengthScale(), contact = null;
    for (let k = 0; k < frame.contacts; ++k) {
      if (!frame.fn[k]) continue;
      const a = placeOf(run, frame, indexOf(frame, frame.i[k]));
      const point = add3(a, normalOf(run, frame, k), -run.radius[frame.i[k]]);
      if (this.hidden(look, point)) continue;
      const to = sub3(point, camera.eye), away = Math.hypot(...cross3(to, ray));
      if (away < close) close = away, contact = {i: frame.i[k], j: frame.j[k]};
    }
    return contact || best;
  }
}

/** Corners of the part of a plane that lies in a box. */
function planeInBox(a, normal, lower, upper) {
  const u = unit3(cross3(normal, Math.abs(normal[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0])), v = cross3(normal, u);
  const middle = lower.map((x, c) => (x + upper[c]) / 2), size = 2 * Math.hypot(...sub3(upper, lower));
  const foot = add3(middle, normal, -dot3(sub3(middle, a), normal) / dot3(normal, normal));
  let corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, y]) => add3(add3(foot, u, x * size), v, y * size));
  const slack = 1e-6 * size;
  for (let c = 0; c < 3; ++c) {
    for (const [sign, bound] of [[1, upper[c] + slack], [-1, -(lower[c] - slack)]]) {
      const kept = [];
      corners.forEach((p, k) => {
        const q = corners[(k + 1) % corners.length], dp = sign * p[c] - bound, dq = sign * q[c] - bound;
        if (dp <= 0) kept.push(p);
        if ((dp < 0 && dq > 0) || (dp > 0 && dq < 0)) kept.push(add3(p, sub3(q, p), dp / (dp - dq)));
      });
      corners = kept;
    }
  }
  return corners;
}
