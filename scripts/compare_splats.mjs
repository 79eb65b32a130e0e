// SPDX-License-Identifier: MIT
//
// Compares the Gaussians that another program read from a file with the Gaussians that were written
// to it.
//   node scripts/compare_splats.mjs REFERENCE.ply READ.ply FORMAT WRITTEN
// REFERENCE.ply holds the Gaussians before writing. WRITTEN is the file in FORMAT (a name of `quadsplat
// --list-formats`), READ.ply its content as the other program read it. Each Gaussian needs exactly one counterpart, in
// any order, whose position, covariance (scale and rotation), opacity and SH differ by no more than the format's steps.
// Prints the largest errors in percent of the allowed errors. Exit code 1: a Gaussian has no
// counterpart.
import { readFileSync } from 'node:fs';

const C0 = 0.28209479177387814;
const ROUNDING = 2e-6;  // of floats, of exp and log
const radians = (degrees) => degrees * Math.PI / 180;
const clamp = (value, limit) => Math.max(-limit, Math.min(limit, value));

// The largest rounding errors of each format: positions in world units, logarithms of scales,
// angles of rotations, opacities, DC and other SH coefficients; `range`: the range to which the
// last two are clamped. SH of .spz are rounded twice, to 1/128 and then to 1/16 or 1/8.
// splat-transform decodes the bytes of .splat rotations up to 0.9 degrees differently from
// antimatter15's viewer.
const EXACT = { position: 0, scale: 0, angle: 0, opacity: 0, dc: 0, sh: 0 };
const BYTE = 0.5 / 255;
const SPZ = { position: 2 ** -13, scale: 1 / 32, angle: radians(0.25), opacity: BYTE, dc: BYTE / 0.15, sh: 1 / 16 + 1 / 256,
              range: { dc: 0.5 / 0.15, sh: 1 } };
const FORMATS = {
  ply: EXACT, glb: EXACT, spz: SPZ, 'spz-v4': SPZ,
  splat: { ...EXACT, angle: radians(1 + 0.9), opacity: BYTE, dc: BYTE / C0, sh: Infinity,
           range: { dc: 0.5 / C0, sh: Infinity } },
  // The precision in which Spark keeps what it read: halves, 10 bits of an axis, and 7, 8 and 6 bits of SH of degrees 1 to 3.
  rad: { position: 0, scale: 2 ** -8, angle: radians(0.3), opacity: 2 ** -11, dc: 2 ** -11 / C0, sh: 0.5 / 31 },
  // Positions are 16 bits of a logarithm. A table has 256 values for the scales, colours or SH of the scene; the palette
  // of SH is exact, because the scene has fewer Gaussians than it has entries.
  sog: { position: 2e-4, scale: 0.03, angle: radians(1), opacity: BYTE, dc: 0.02, sh: 0.02 },
  // Positions, scales and colours are steps of the box of 256 Gaussians.
  'compressed.ply': { angle: radians(0.25), opacity: BYTE, sh: 1 / 64, range: { dc: Infinity, sh: 4 } },
};

// The first element of a binary .ply, all of whose properties must be floats.
function readRows(path) {
  const bytes = readFileSync(path), mark = 'end_header\n';
  const begin = bytes.indexOf(mark) + mark.length;
  const header = bytes.subarray(0, begin).toString('latin1').split(/^element /m);
  const names = [...header[1].matchAll(/^property (\w+) (\w+)$/gm)];
  if (!/binary_little_endian/.test(header[0]) || names.some(([, type]) => type !== 'float')) {
    throw new Error(`${path}: not a binary .ply of floats`);
  }
  const columns = new Map(names.map(([, , name], i) => [name, i]));
  return {
    count: Number(header[1].split(/\s/)[1]),
    has: (name) => columns.has(name),
    value: (row, name) => bytes.readFloatLE(begin + 4 * (row * names.length + columns.get(name))),
  };
}

function covariance(scale, [w, x, y, z]) {
  const length = Math.hypot(w, x, y, z);
  [w, x, y, z] = [w / length, x / length, y / length, z / length];
  const r = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
             [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
             [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]];
  const s = scale.map((value) => Math.exp(2 * value));
  return r.flatMap((a) => r.map((b) => a[0] * b[0] * s[0] + a[1] * b[1] * s[1] + a[2] * b[2] * s[2]));
}

function readGaussians(path) {
  const rows = readRows(path);
  const rest = [...Array(45).keys()].map((i) => `f_rest_${i}`).filter(rows.has);
  return Array.from({ length: rows.count }, (_, i) => {
    const values = (...names) => names.map((name) => rows.value(i, name));
    return {
      position: values('x', 'y', 'z'),
      covariance: covariance(values('scale_0', 'scale_1', 'scale_2'), values('rot_0', 'rot_1', 'rot_2', 'rot_3')),
      opacity: [1 / (1 + Math.exp(-rows.value(i, 'opacity')))],
      dc: values('f_dc_0', 'f_dc_1', 'f_dc_2'),
      sh: values(...rest),
    };
  });
}

// The largest error of each value of the Gaussian at index `i` of the file.
function allowed(format, chunks, i) {
  const steps = { ...FORMATS[format] };
  if (chunks) {
    const extent = (name) => chunks.value(i >> 8, `max_${name}`) - chunks.value(i >> 8, `min_${name}`);
    steps.position = ['x', 'y', 'z'].map((axis) => extent(axis) / 2 / (axis === 'y' ? 1023 : 2047));
    steps.scale = Math.max(...['x', 'y', 'z'].map((axis) => extent(`scale_${axis}`) / 2 / (axis === 'y' ? 1023 : 2047)));
    steps.dc = ['r', 'g', 'b'].map((channel) => extent(channel) * BYTE / C0);
  }
  const three = (value) => Array.isArray(value) ? value : [value, value, value];
  return {
    ...steps, position: three(steps.position), dc: three(steps.dc),
    // Of the norm: scales have factors e^error; turning by a small angle moves a covariance by less than twice that.
    covariance: Math.expm1(2 * steps.scale) + 2 * steps.angle,
  };
}

// Largest error of each kind, relative to the allowed error.
function errors(written, read, limits) {
  const range = limits.range ?? { dc: Infinity, sh: Infinity };
  const part = (difference, limit, size) => Math.abs(difference) / (limit + ROUNDING * (1 + Math.abs(size)));
  const largest = (name, limit, bound = Infinity) => Math.max(0, ...read[name].map((value, k) => {
    const expected = clamp(written[name][k] ?? 0, bound);
    return part(value - expected, Array.isArray(limit) ? limit[k] : limit, expected);
  }));
  const norm = (matrix) => Math.hypot(...matrix);
  const difference = written.covariance.map((value, k) => value - read.covariance[k]);
  return {
    position: largest('position', limits.position),
    covariance: norm(difference) / norm(written.covariance) / (limits.covariance + 10 * ROUNDING),
    opacity: largest('opacity', limits.opacity),
    dc: largest('dc', limits.dc, range.dc),
    sh: largest('sh', limits.sh, range.sh),
  };
}

// Rotates by 180 degrees about x, from RUB to RDF: some versions of splat-transform do not convert the axes of .spz.
function turned(gaussian) {
  const axis = [1, -1, -1], sh = [-1, -1, 1, -1, 1, 1, -1, 1, -1, 1, -1, -1, 1, -1, 1], rest = gaussian.sh.length / 3;
  return {
    ...gaussian,
    position: gaussian.position.map((value, k) => value * axis[k]),
    covariance: gaussian.covariance.map((value, k) => value * axis[k % 3] * axis[Math.floor(k / 3)]),
    sh: gaussian.sh.map((value, k) => value * sh[k % rest]),
  };
}

// Pairs each Gaussian of `read` with the nearest unpaired Gaussian of `written`.
function match(written, read, limitsOf) {
  const free = [...written].sort((a, b) => a.position[0] - b.position[0]);  // candidates lie side by side
  const taken = new Set();
  const firstFrom = (x) => {
    let low = 0, high = free.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (free[middle].position[0] < x) low = middle + 1; else high = middle;
    }
    return low;
  };
  const result = { agreeing: 0, worst: { position: 0, covariance: 0, opacity: 0, dc: 0, sh: 0 }, others: [] };
  read.forEach((gaussian, i) => {
    const limits = limitsOf(i), x = gaussian.position[0];
    const reach = 2 * (limits.position[0] + ROUNDING * (1 + Math.abs(x)));
    let best = { index: -1, error: Infinity, errors: 'none is near' };
    for (let k = firstFrom(x - reach); k < free.length && free[k].position[0] <= x + reach; ++k) {
      if (taken.has(k)) continue;
      const found = errors(free[k], gaussian, limits), error = Math.max(...Object.values(found));
      if (error < best.error) best = { index: k, error, errors: found };
    }
    if (!(best.error <= 1)) {
      result.others.push({ gaussian: i, nearest: best.errors });
      return;
    }
    ++result.agreeing;
    taken.add(best.index);
    for (const name of Object.keys(result.worst)) {
      result.worst[name] = Math.max(result.worst[name], best.errors[name]);
    }
  });
  return result;
}

const [reference, other, format, file] = process.argv.slice(2);
if (!FORMATS[format]) throw new Error(`no steps are known for format '${format}'`);
const written = readGaussians(reference), read = readGaussians(other);
if (written.length !== read.length || (format !== 'splat' && written[0].sh.length !== read[0].sh.length)) {
  console.log(`${read.length} Gaussians with ${read[0].sh.length} SH values instead of ` +
              `${written.length} with ${written[0].sh.length}`);
  process.exit(1);
}
const chunks = format === 'compressed.ply' ? readRows(file) : null;
const limitsOf = (i) => allowed(format, chunks, i);
let result = match(written, read, limitsOf), note = '';
if (result.agreeing === 0 && format.startsWith('spz')) {
  result = match(written, read.map(turned), limitsOf);
  note = ' (in the file\'s axes, RUB)';
}
for (const { gaussian, nearest } of result.others.slice(0, 3)) console.log(`Gaussian ${gaussian} differs:`, nearest);
const percent = Object.entries(result.worst).map(([name, value]) => `${name} ${Math.round(100 * value)} %`).join(', ');
console.log(`${result.agreeing} of ${read.length} Gaussians agree${note}; largest errors of those allowed: ${percent}`);
process.exit(result.others.length > 0 ? 1 : 0);
