// The frames of a run: base64, deflate, and differences in time (bench/page/page_frames.h).

const WALL = 2 ** 30;  // j of a contact with wall w is WALL + w

/** Bytes of a text in base64. */
async function inflate(text) {
  const letters = atob(text.trim());
  const packed = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; ++k) packed[k] = letters.charCodeAt(k);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Reads arrays that stand in planes: all lowest bytes first. */
class PlaneReader {
  constructor(bytes) {
    this.bytes = bytes;
    this.next = 0;
  }
  bytes8(count) {
    const values = this.bytes.subarray(this.next, this.next + count);
    this.next += count;
    return values;
  }
  words(count) {
    const values = new Uint16Array(count), {bytes, next} = this;
    for (let k = 0; k < count; ++k) values[k] = bytes[next + k] | bytes[next + count + k] << 8;
    this.next += 2 * count;
    return values;
  }
  longs(count) {
    const values = new Int32Array(count), {bytes, next} = this;
    for (let k = 0; k < count; ++k) {
      values[k] = bytes[next + k] | bytes[next + count + k] << 8 |
          bytes[next + 2 * count + k] << 16 | bytes[next + 3 * count + k] << 24;
    }
    this.next += 4 * count;
    return values;
  }
  floats(count) {
    return new Float32Array(this.longs(count).buffer);
  }
}

/** Adds folded differences to the values before. `places`: of each item before, -1: none. */
function addDifferences(values, before, places, width) {
  const count = places.length, countBefore = before ? before.length / width : 0;
  for (let c = 0; c < width; ++c) {
    for (let k = 0; k < count; ++k) {
      const folded = values[c * count + k];
      const difference = (folded >>> 1) ^ -(folded & 1);
      const place = places[k];
      values[c * count + k] = difference + (place >= 0 ? before[c * countBefore + place] : 0);
    }
  }
  return values;
}

/** Places of numbers in an earlier list; both increase. */
function placesBefore(before, now) {
  const places = new Int32Array(now.length);
  for (let k = 0, b = 0; k < now.length; ++k) {
    while (b < before.length && before[b] < now[k]) ++b;
    places[k] = b < before.length && before[b] === now[k] ? b : -1;
  }
  return places;
}

/** Contacts of a frame: those that stay and the new ones, sorted by (i, j). */
function mergedContacts(reader, before, count) {
  const kept = reader.bytes8(before.i.length), fresh = reader.longs(1)[0];
  const newI = reader.longs(fresh), newJ = reader.longs(fresh);
  for (let k = 1; k < fresh; ++k) newI[k] += newI[k - 1];
  const i = new Int32Array(count), j = new Int32Array(count), places = new Int32Array(count);
  for (let k = 0, b = 0, f = 0; k < count; ++k) {
    while (b < kept.length && !kept[b]) ++b;
    const old = b < kept.length &&
        (f >= fresh || before.i[b] < newI[f] || (before.i[b] === newI[f] && before.j[b] < newJ[f]));
    i[k] = old ? before.i[b] : newI[f];
    j[k] = old ? before.j[b] : newJ[f];
    places[k] = old ? b++ : -1;
    if (!old) ++f;
  }
  return {i, j, places};
}

/** All frames. Components of vectors stand one after the other: x of all bodies, then y. */
async function readRun(about, text, progress) {
  const reader = new PlaneReader(await inflate(text));
  const D = about.dim, S = D === 2 ? 1 : 3, N = about.bodies;
  const run = {
    about, dim: D, quantum: about.quantum,
    radius: reader.floats(N), mass: reader.floats(N), material: reader.bytes8(N),
    glued: reader.bytes8(N), cluster: reader.longs(N), frames: []
  };
  const all = Int32Array.from({length: about.gates || !about.frames.length ? 0 : about.frames[0][2]}, (_, k) => k);
  let before = {number: [], i: [], j: []}, walls = [], pause = performance.now() + 60;
  for (let f = 0; f < about.frames.length; ++f) {
    const [step, time, count, contacts] = about.frames[f];
    let number = all;
    if (about.gates) {
      number = reader.longs(count);
      for (let k = 1; k < count; ++k) number[k] += number[k - 1];
    }
    const places = f && !about.gates ? all : placesBefore(before.number, number);
    walls = about.wall_places[f] || walls;
    const frame = {step, time, count, contacts, number, walls, turns: about.wall_turns?.[f].map(code => code * 2 * Math.PI / 65536), cell: about.cells && about.cells[f]};
    frame.x = addDifferences(reader.longs(D * count), before.x, places, D);
    frame.turn = addDifferences(reader.words(S * count), before.turn, places, S);
    frame.v = addDifferences(reader.words(D * count), before.v, places, D);
    frame.spin = addDifferences(reader.words(S * count), before.spin, places, S);
    const {i, j, places: at} = mergedContacts(reader, before, contacts);
    Object.assign(frame, {i, j});
    frame.n = addDifferences(reader.words((D - 1) * contacts), before.n, at, D - 1);
    frame.gap = addDifferences(reader.words(contacts), before.gap, at, 1);
    frame.fn = addDifferences(reader.words(contacts), before.fn, at, 1);
    frame.ft = addDifferences(reader.words(S * contacts), before.ft, at, S);
    frame.status = addDifferences(Uint8Array.from(reader.bytes8(contacts)), before.status, at, 1);
    run.frames.push(frame);
    before = frame;
    if (progress && performance.now() > pause) {
      progress(f / about.frames.length);
      await new Promise(go => setTimeout(go));
      pause = performance.now() + 60;
    }
  }
  measureRadii(run);
  return run;
}
function measureRadii(run) {
  run.smallest = run.radius.reduce((a, r) => r > 0 ? Math.min(a, r) : a, Infinity);
  run.meanRadius = run.radius.reduce((a, r) => a + r, 0) / Math.max(1, run.radius.length);
}

/** Adds the frames that follow and the bodies that came; keeps the frames of these steps. */
function extendRun(run, more, steps) {
  const kept = new Set(steps), known = run.radius, news = more.radius;
  run.frames = [...run.frames, ...more.frames].filter(frame => kept.has(frame.step));
  for (const name of ['mass', 'material', 'glued', 'cluster', 'radius']) {
    const old = run[name], all = new old.constructor(Math.max(known.length, news.length));
    for (let k = 0; k < all.length; ++k) all[k] = news[k] > 0 ? more[name][k] : old[k];
    run[name] = all;
  }
  measureRadii(run);
}

/** Index of a body's number in a frame, -1: it is not there. */
function indexOf(frame, number) {
  if (frame.number[number] === number) return number;
  let low = 0, high = frame.count - 1;
  while (low <= high) {
    const middle = (low + high) >> 1;
    if (frame.number[middle] === number) return middle;
    if (frame.number[middle] < number) low = middle + 1; else high = middle - 1;
  }
  return -1;
}

/** Place of a body, from the origin of the run on. */
function placeOf(run, frame, k) {
  const x = [];
  for (let c = 0; c < run.dim; ++c) x.push(frame.x[c * frame.count + k] * run.quantum);
  return x;
}
/** A vector that turns with a body. */
function turnedWith(run, frame, k, x) {
  const n = frame.count;
  if (run.dim === 2) {
    const c = COS[frame.turn[k]], s = SIN[frame.turn[k]];
    return [c * x[0] - s * x[1], s * x[0] + c * x[1]];
  }
  const q = [0, 1, 2].map(c => frame.turn[c * n + k] / 32767 - 1), w = Math.sqrt(Math.max(0, 1 - q[0] ** 2 - q[1] ** 2 - q[2] ** 2));
  const t = cross3(q, x).map(part => 2 * part), u = cross3(q, t);
  return x.map((part, c) => part + w * t[c] + u[c]);
}
/** Lines that show a joint: a rope between its ends, a pin from the centres to its point. */
function jointLines(run, frame, {i, j, at_i, at_j, rope}) {
  const end = (body, arm) => body < 0 ? arm : placeOf(run, frame, body).map((x, c) => x + turnedWith(run, frame, body, arm)[c]);
  const from = end(i, at_i), to = end(j, at_j);
  if (rope) return [[from, to]];
  return [i, j].filter(body => body >= 0).map(body => [placeOf(run, frame, body), from]);
}
function logsOf(codes, count, k) {
  const x = [];
  for (let at = k; at < codes.length; at += count) x.push(LOG[codes[at]]);
  return x;
}
function normalOf(run, frame, k) {
  if (run.dim === 2) return [COS[frame.n[k]], SIN[frame.n[k]]];
  return direction(frame.n[k], frame.n[frame.contacts + k]);
}
/** Force on body i: along n, and the tangential part as a vector. */
function forceOf(run, frame, k) {
  const n = normalOf(run, frame, k), fn = LOG[frame.fn[k]], t = logsOf(frame.ft, frame.contacts, k);
  if (run.dim === 2) return [fn * n[0] - t[0] * n[1], fn * n[1] + t[0] * n[0]];
  return n.map((x, c) => fn * x + t[c]);
}
/** Sum of the contact forces on a body. */
function resultant(run, frame, number) {
  const sum = new Array(run.dim).fill(0);
  for (let k = 0; k < frame.contacts; ++k) {
    const sign = frame.i[k] === number ? 1 : frame.j[k] === number ? -1 : 0;
    if (sign) forceOf(run, frame, k).forEach((x, c) => sum[c] += sign * x);
  }
  return sum;
}
