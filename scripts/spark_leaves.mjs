// SPDX-License-Identifier: MIT
//
// Reads a .rad file with the decoder of Spark (npm's @sparkjsdev/spark, Node 20 or newer) and writes the leaves of its tree as a .ply.
//   node scripts/spark_leaves.mjs node_modules/@sparkjsdev/spark IN.rad OUT.ply
// The decoder is WebAssembly in a worker, whose text Spark's module holds as a string. It runs here with a `self` that only passes
// messages. Spark keeps SH in 6 to 8 bits and other values as halves, so the .ply has these roundings.
import { readFileSync, writeFileSync } from 'node:fs';

const [folder, input, output] = process.argv.slice(2);
const module = readFileSync(`${folder}/dist/spark.module.js`, 'utf8');
const wasm = Buffer.from(/AGFzbQ[A-Za-z0-9+/=]*/.exec(module)[0], 'base64');
const worker = new Function(`return ${/^const jsContent = ('.*');$/m.exec(module)[1]}`)();

const listeners = new Set(), waiting = new Map();
globalThis.self = {
  addEventListener: (_, listener) => listeners.add(listener),
  removeEventListener: (_, listener) => listeners.delete(listener),
  postMessage: (message) => ('result' in message || 'error' in message) && waiting.get(message.id)(message),
};
(0, eval)(worker);
const post = (data) => [...listeners].forEach((listener) => listener({ data }));
post({ name: 'init-wasm', module: await WebAssembly.compile(wasm) });

async function decode(id, name) {
  const answer = new Promise((resolve) => waiting.set(id, resolve));
  post({ id, name, args: { fileBytes: new Uint8Array(readFileSync(input)), fileType: 'rad', pathName: input } });
  const { result, error } = await answer;
  if (error) throw error;
  return result.lodSplats;
}
const exact = await decode(1, 'loadExtSplats'), packed = await decode(2, 'loadPackedSplats');

function half(bits) {
  const sign = bits & 0x8000 ? -1 : 1, exponent = bits >> 10 & 31, fraction = bits & 1023;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return exponent === 0 ? sign * fraction * 2 ** -24 : sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
}

// An octahedral axis in 10 + 10 bits and an angle in 12, as w, x, y, z.
function rotation(bits) {
  let x = (bits & 1023) / 511.5 - 1, y = (bits >>> 10 & 1023) / 511.5 - 1;
  const z = 1 - Math.abs(x) - Math.abs(y), fold = Math.max(-z, 0);
  x += x >= 0 ? -fold : fold;
  y += y >= 0 ? -fold : fold;
  const angle = (bits >>> 20) / 4095 * Math.PI / 2, factor = Math.sin(angle) / Math.hypot(x, y, z);
  return [Math.cos(angle), x * factor, y * factor, z * factor];
}

// `count` signed numbers of `bits` bits from word `at` on.
function signed(words, at, count, bits, max) {
  let all = 0n;
  for (let i = 3; i >= 0; --i) all = all << 32n | BigInt(i * 32 < count * bits ? words[at + i] : 0);
  return Array.from({ length: count }, (_, i) => Number(BigInt.asIntN(bits, all >> BigInt(i * bits))) * max / (2 ** (bits - 1) - 1));
}

const C0 = 0.28209479177387814;
const [first, second] = exact.extArrays, floats = new Float32Array(first.buffer, first.byteOffset, first.length);
const { sh1, sh2, sh3, lodTree } = { ...packed.extra, lodTree: exact.extra.lodTree };
const limits = packed.splatEncoding;
const rows = [];
for (let i = 0; i < exact.numSplats; ++i) {
  if ((lodTree[4 * i + 2] & 0xffff) !== 0) continue;  // it has children
  const alpha = half(first[4 * i + 3] & 0xffff), b = second.subarray(4 * i, 4 * i + 4);
  const [red, green, blue, ...scales] = [b[0], b[0] >>> 16, b[1], b[1] >>> 16, b[2], b[2] >>> 16].map((v) => half(v & 0xffff));
  const sh = [...signed(sh1, 2 * i, 9, 7, limits.sh1Max), ...signed(sh2, 4 * i, 15, 8, limits.sh2Max), ...signed(sh3, 4 * i, 21, 6, limits.sh3Max)];
  const rest = [0, 1, 2].flatMap((channel) => sh.filter((_, k) => k % 3 === channel));
  rows.push(...floats.subarray(4 * i, 4 * i + 3), ...[red, green, blue].map((v) => (v - 0.5) / C0), ...rest, Math.log(alpha / (1 - alpha)),
            ...scales, ...rotation(b[3]));
}
const names = ['x', 'y', 'z', ...[0, 1, 2].map((i) => `f_dc_${i}`), ...Array.from({ length: 45 }, (_, i) => `f_rest_${i}`), 'opacity',
               ...[0, 1, 2].map((i) => `scale_${i}`), ...[0, 1, 2, 3].map((i) => `rot_${i}`)];
const header = `ply\nformat binary_little_endian 1.0\nelement vertex ${rows.length / names.length}\n` +
    names.map((name) => `property float ${name}\n`).join('') + 'end_header\n';
writeFileSync(output, Buffer.concat([Buffer.from(header), Buffer.from(new Float32Array(rows).buffer)]));
