// Numbers of the packed frames (core/run_files/film_frame.h), and numbers as text.

const OCTAVE = 327, LOWEST = -50;
/** Value of every 16-bit logarithm. */
const LOG = new Float32Array(65536);
for (let code = 1; code < 32768; ++code) {
  LOG[code] = 2 ** ((code - 1) / OCTAVE + LOWEST);
  LOG[code | 32768] = -LOG[code];
}
/** Cosine and sine of every 16-bit angle. */
const COS = new Float32Array(65536), SIN = new Float32Array(65536);
for (let code = 0; code < 65536; ++code) {
  COS[code] = Math.cos(2 * Math.PI * code / 65536);
  SIN[code] = Math.sin(2 * Math.PI * code / 65536);
}

/** A unit vector of two codes, in space. */
function direction(first, second) {
  let x = first / 32767 - 1, y = second / 32767 - 1;
  const z = 1 - Math.abs(x) - Math.abs(y);
  if (z < 0) {
    const folded = (1 - Math.abs(y)) * (x < 0 ? -1 : 1);
    y = (1 - Math.abs(x)) * (y < 0 ? -1 : 1);
    x = folded;
  }
  const size = Math.hypot(x, y, z);
  return [x / size, y / size, z / size];
}

/** A power of ten. */
function power(exponent) {
  return '10' + [...String(exponent)].map(c => c === '-' ? '⁻' : '⁰¹²³⁴⁵⁶⁷⁸⁹'[c]).join('');
}
/** A number as a physicist writes it: three digits, powers of ten where they are shorter. */
function textOf(x, digits = 3) {
  if (x === undefined || x === null || Number.isNaN(x)) return '–';
  if (x === 0) return '0';
  const size = Math.abs(x);
  if (size >= 1e-3 && size < 1e5) {
    const text = x.toPrecision(digits);
    return (text.includes('e') ? String(Math.round(x)) : text).replace('-', '−');
  }
  const [mantissa, exponent] = x.toExponential(digits - 1).split('e');
  return mantissa.replace('-', '−') + '·' + power(Number(exponent));
}

/** "speed [m/s]" as its name and its unit, which may be missing. */
function nameAndUnit(column) {
  const found = /^(.*?)(?: \[(.*)\])?$/.exec(column);
  return [found[1].replaceAll('_', ' '), (found[2] || '').replace(/([a-z])2\b/g, '$1²').replace(/([a-z])3\b/g, '$1³')];
}

/** The largest of any number of values, and at least the other. */
function largest(values, least = 0) {
  return values.reduce((most, x) => Math.max(most, x), least);
}

/** The value that a share of the numbers does not exceed. */
function quantile(values, share) {
  if (!values.length) return 0;
  const sorted = Float64Array.from(values).sort();
  return sorted[Math.floor(share * (sorted.length - 1))];
}
