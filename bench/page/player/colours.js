// What colours mean: quantities of bodies, their ranges over the whole run, and colour maps.

const RAMP_STEPS = 64;

/** Linear part of an OKLab colour in sRGB, 0 to 255. */
function oklab(L, a, b) {
  const l = (L + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (L - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (L - 0.0894841775 * a - 1.2914855480 * b) ** 3;
  return [4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s].map(x => {
    const c = Math.min(1, Math.max(0, x));
    return Math.round(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055));
  });
}
function ramp(corners) {
  return Array.from({length: RAMP_STEPS}, (_, k) => {
    const at = k / (RAMP_STEPS - 1) * (corners.length - 1);
    const p = Math.min(Math.floor(at), corners.length - 2), t = at - p;
    return oklab(...corners[p].map((x, c) => x + t * (corners[p + 1][c] - x)));
  });
}
const cssOf = rgb => `rgb(${rgb.join(' ')})`;

/** Colours of a theme. */
function palette(dark) {
  const hue = (L, chroma) => Array.from({length: RAMP_STEPS}, (_, k) => {
    const angle = 2 * Math.PI * k / RAMP_STEPS;
    return oklab(L, chroma * Math.cos(angle), chroma * Math.sin(angle));
  });
  const kinds = [[0.72, 0.3], [0.72, 3.9], [0.78, 1.6], [0.68, 5.1], [0.8, 2.5], [0.65, 4.6], [0.82, 0.95], [0.7, 5.8]]
      .map(([L, h]) => oklab(dark ? L - 0.12 : L, 0.105 * Math.cos(h), 0.105 * Math.sin(h)));
  return {
    dark, kinds, cyclic: hue(dark ? 0.62 : 0.78, 0.11),
    rising: dark ? ramp([[0.33, -0.005, -0.035], [0.58, -0.07, -0.055], [0.93, -0.035, 0.09]])
                 : ramp([[0.965, -0.012, 0.035], [0.72, -0.08, -0.03], [0.4, 0, -0.13]]),
    both: dark ? ramp([[0.72, -0.03, -0.13], [0.36, 0, -0.005], [0.72, 0.13, 0.09]])
               : ramp([[0.5, -0.02, -0.15], [0.96, 0, 0.004], [0.56, 0.16, 0.1]]),
    plain: dark ? [70, 82, 91] : [214, 222, 228],
    stage: dark ? '#14181a' : '#fcfdfd', ink: dark ? '#e4e8ea' : '#1c2328',
    edge: dark ? 'rgb(200 212 220 / .34)' : 'rgb(40 55 66 / .42)',
    // As in the pictures (core/pictures/force_picture.cc).
    stick: dark ? '#7db8ea' : '#05457a', slip: '#f29e0a', tension: dark ? '#f07fc0' : '#b01770',
    open: dark ? '#8a98a2' : '#84919b', wall: dark ? '#7d8a93' : '#5d6a73',
    solid: dark ? '#1b2023' : '#f1f3f5', hatch: dark ? '#333c42' : '#cfd6db',
    glued: dark ? [86, 95, 102] : [176, 185, 191], arrow: dark ? '#7fd0a6' : '#0b7a4b',
    path: dark ? '#ff9ecf' : '#b0176f', outlet: dark ? '#e0a14f' : '#b26a00',
    inlet: dark ? '#74b6f5' : '#0b62b0'
  };
}

function magnitudes(codes, count, width) {
  const values = new Float32Array(count);
  for (let k = 0; k < count; ++k) {
    let sum = 0;
    for (let c = 0; c < width; ++c) sum += LOG[codes[c * count + k]] ** 2;
    values[k] = Math.sqrt(sum);
  }
  return values;
}
/** A sum over the contacts of each body. */
function contactSums(run, frame, term) {
  const sums = new Float32Array(frame.count);
  for (let k = 0; k < frame.contacts; ++k) {
    if (!frame.fn[k]) continue;
    const i = indexOf(frame, frame.i[k]);
    sums[i] += term(k, run.radius[frame.i[k]]);
    if (frame.j[k] >= WALL) continue;
    const j = indexOf(frame, frame.j[k]);
    sums[j] += term(k, run.radius[frame.j[k]]);
  }
  return sums;
}

/** Quantities by which bodies are coloured: `of` gives a value for each body of a frame. */
const QUANTITIES = {
  speed: {unit: 'm/s', of: (run, f) => magnitudes(f.v, f.count, run.dim)},
  // Trace of the stress of contact forces on a body: a Σ f_n over D times its area or volume.
  pressure: {label: 'contact pressure', unit: 'Pa', of: (run, f) => contactSums(run, f, run.dim === 2
    ? (k, a) => LOG[f.fn[k]] / (2 * Math.PI * a) : (k, a) => LOG[f.fn[k]] / (4 * Math.PI * a * a))},
  'force': {label: 'largest force', unit: 'N', of: (run, f) => {
    const most = new Float32Array(f.count);
    for (let k = 0; k < f.contacts; ++k) {
      for (const number of [f.i[k], f.j[k]]) {
        if (number >= WALL) continue;
        const at = indexOf(f, number);
        most[at] = Math.max(most[at], LOG[f.fn[k]]);
      }
    }
    return most;
  }},
  rotation: {unit: '°', cyclic: true, flat: true,
    of: (run, f) => Float32Array.from(f.turn, code => code * 360 / 65536)},
  spin: {unit: 'rad/s', both: true, of: (run, f) => run.dim === 2
    ? Float32Array.from(f.spin, code => LOG[code]) : magnitudes(f.spin, f.count, 3)},
  coordination: {unit: 'contacts', whole: true, of: (run, f) => contactSums(run, f, () => 1)},
  mass: {unit: 'kg', of: (run, f) => Float32Array.from(f.number, b => run.mass[b])},
  material: {kinds: true, of: (run, f) => Float32Array.from(f.number, b => run.material[b])},
  cluster: {kinds: true, of: (run, f) => Float32Array.from(f.number, b => run.cluster[b])},
  plain: {plain: true, of: (run, f) => new Float32Array(f.count)}
};

/** Names of the quantities that say something about this run. */
function usefulQuantities(run) {
  const several = values => values.some(x => x !== values[0]);
  return Object.keys(QUANTITIES).filter(name =>
    name === 'rotation' ? run.dim === 2 : name === 'mass' ? several(run.mass)
    : name === 'material' ? several(run.material) : name === 'cluster' ? run.cluster.some(c => c >= 0) : true);
}

/** Range of a quantity, the same for all times: 99 of 100 values lie within. */
function rangeOf(run, name) {
  run.ranges ||= {};
  if (run.ranges[name]) return run.ranges[name];
  const quantity = QUANTITIES[name], values = [];
  const stride = Math.max(1, Math.floor(run.frames.length / 60));
  for (let f = 0; f < run.frames.length; f += stride) {
    const of = quantity.of(run, run.frames[f]);
    const skip = Math.max(1, Math.floor(of.length / 1000));
    for (let k = 0; k < of.length; k += skip) values.push(Math.abs(of[k]));
  }
  let high = quantity.cyclic ? 360 : quantile(values, name === 'mass' ? 1 : 0.99);
  let low = 0;
  if (name === 'mass') low = run.mass.reduce((least, m) => m > 0 ? Math.min(least, m) : least, Infinity);
  if (!(high > low)) high = largest(values, low) || 1;
  if (quantity.whole) high = Math.max(1, Math.round(high));
  if (quantity.both && run.dim === 2) low = -high;
  return run.ranges[name] = [low, high];
}

/** Neighbours with numbers in a row get different colours. */
function kindOf(name, value) {
  return name === 'cluster' ? Math.imul(value, 2654435761) >>> 29 : value;
}

/** Colour number of each body of a frame, and the list of colours. */
function coloured(run, frame, name, colours) {
  const quantity = QUANTITIES[name], values = quantity.of(run, frame);
  const index = new Uint8Array(frame.count);
  let list = quantity.cyclic ? colours.cyclic : quantity.both && run.dim === 2 ? colours.both : colours.rising;
  if (quantity.plain) list = [colours.plain];
  if (quantity.kinds) list = [colours.plain, ...colours.kinds];
  const [low, high] = rangeOf(run, name), last = list.length - 1;
  for (let k = 0; k < values.length; ++k) {
    index[k] = quantity.plain ? 0
      : quantity.kinds ? (values[k] < 0 ? 0 : 1 + kindOf(name, values[k]) % colours.kinds.length)
      : quantity.cyclic ? Math.floor(values[k] / 360 * RAMP_STEPS) % RAMP_STEPS
      : Math.round(Math.min(1, Math.max(0, (values[k] - low) / (high - low))) * last);
  }
  const glued = list.length;
  for (let k = 0; k < frame.count; ++k) if (run.glued[frame.number[k]]) index[k] = glued;
  return {index, list: [...list, colours.glued], values};
}

/** Whether a contact pushes, or cohesion holds it in tension. */
const carries = (frame, k) => LOG[frame.fn[k]] > 0 || (frame.fn[k] && frame.status[k] !== 0);
/** Colour of its force among those of pushing contacts and of tension. */
const forceColour = (frame, k, {stick, slip, tension}) =>
  LOG[frame.fn[k]] < 0 ? tension : frame.status[k] === 2 ? slip : stick;

/** Normal force that has the full width: 99 of 100 forces of most frames are smaller, shocks aside. */
function fullForce(run) {
  if (run.fullForce) return run.fullForce;
  const strong = [], stride = Math.max(1, Math.floor(run.frames.length / 80));
  for (let f = run.frames.length - 1; f >= 0; f -= stride) {
    const codes = run.frames[f].fn, skip = Math.max(1, Math.floor(codes.length / 1500)), forces = [];
    for (let k = 0; k < codes.length; k += skip) if (codes[k]) forces.push(Math.abs(LOG[codes[k]]));
    if (forces.length) strong.push(quantile(forces, 0.99));
  }
  return run.fullForce = quantile(strong, 0.6) || 1;
}
