// SPDX-License-Identifier: MIT
//
// scripts/check_formats: opens files in viewers for browsers, in Chromium, and compares what they read.
//   BROWSER=chromium node open_in_viewers.mjs REFERENCE.ply FILE...
// Runs in the folder with node_modules. A viewer must read the Gaussians of every file that it can open: as many as REFERENCE.ply
// has, with the same mean position (of .spz with y and z turned); of a tree all nodes of the .rad file, or all Gaussians of the finest
// level of a streamed SOG. Exit code 1: a file was refused or read otherwise.
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { extname } from "node:path";
import { argv, cwd, env, exit } from "node:process";

const puppeteer = createRequire(cwd() + "/")("puppeteer-core");
const [reference, ...files] = argv.slice(2);
const LONGEST = 60_000;     // ms for a file
const MOST_APART = 2e-3;    // world units, between mean positions: positions of .spz are steps of 1/4096

// The endings of files that each viewer opens. Spark 2.2 has no reader for version 4 of .spz and for .glb; PlayCanvas 2.23 none for .spz, .splat and .glb.
const OPENS = { Spark: [".ply", "v3.spz", ".splat", ".sog", ".rad"], PlayCanvas: [".ply", ".sog", "lod-meta.json"] };

const TYPES = { ".js": "text/javascript", ".mjs": "text/javascript", ".wasm": "application/wasm" };
const PAGE = `<!doctype html><script type="importmap">{"imports": {
  "three": "/node_modules/three/build/three.module.js", "three/addons/": "/node_modules/three/examples/jsm/",
  "spark": "/node_modules/@sparkjsdev/spark/dist/spark.module.js", "playcanvas": "/node_modules/playcanvas/build/playcanvas.mjs"
}}</script><canvas width="64" height="64"></canvas>`;

const server = createServer((request, response) => {
  const path = decodeURIComponent(new URL(request.url, "http://here").pathname);
  response.setHeader("content-type", path === "/" ? "text/html" : TYPES[extname(path)] ?? "application/octet-stream");
  try {
    response.end(path === "/" ? PAGE : readFileSync("." + path));
  } catch {
    response.statusCode = 404;
    response.end();
  }
}).listen(0, "127.0.0.1");
await new Promise((done) => server.on("listening", done));

// Both run in the page, and return the number and the mean position of the Gaussians of a file.
const VIEWERS = {
  Spark: async (file) => {
    const { SplatMesh } = await import("spark");
    const mesh = new SplatMesh({ url: "/" + file });
    await mesh.initialized;
    const tree = mesh.packedSplats.lodSplats;
    if (tree) return { count: tree.numSplats };
    const sum = [0, 0, 0];
    let count = 0;
    mesh.forEachSplat((_, center) => {
      ++count;
      ["x", "y", "z"].forEach((axis, i) => { sum[i] += center[axis]; });
    });
    return { count, mean: sum.map((value) => value / count) };
  },
  PlayCanvas: async (file) => {
    const pc = await import("playcanvas");
    if (!globalThis.app) {
      const canvas = document.querySelector("canvas"), options = new pc.AppOptions();
      options.graphicsDevice = await pc.createGraphicsDevice(canvas, { deviceTypes: ["webgl2"] });
      options.componentSystems = [pc.CameraComponentSystem, pc.GSplatComponentSystem];
      options.resourceHandlers = [pc.GSplatHandler, pc.TextureHandler];
      globalThis.app = new pc.AppBase(canvas);
      globalThis.app.init(options);
    }
    const asset = new pc.Asset(file, "gsplat", { url: "/" + file, filename: file });
    await new Promise((done, failed) => {
      asset.on("load", done);
      asset.on("error", (message) => failed(new Error(message)));
      globalThis.app.assets.add(asset);
      globalThis.app.assets.load(asset);
    });
    const tree = asset.resource.octree;
    if (tree) return { count: tree.nodes.reduce((sum, node) => sum + node.lods[0].count, 0) };
    const { centers } = asset.resource, count = centers.length / 3, sum = [0, 0, 0];
    centers.forEach((value, i) => { sum[i % 3] += value; });
    return { count, mean: sum.map((value) => value / count) };
  },
};

const browser = await puppeteer.launch({
  executablePath: env.BROWSER, headless: true, args: ["--no-sandbox", "--enable-unsafe-swiftshader", "--use-angle=swiftshader"],
});
const page = await browser.newPage();
await page.goto(`http://127.0.0.1:${server.address().port}/`);
const read = (viewer, file) => Promise.race([
  page.evaluate(VIEWERS[viewer], file),
  new Promise((_, late) => setTimeout(() => late(new Error("no answer within a minute")), LONGEST)),
]);

// The number of nodes in the description of a .rad file.
const nodes = (file) => {
  const content = readFileSync(file);
  return JSON.parse(content.subarray(8, 8 + content.readUInt32LE(4))).count;
};

let status = 0;
for (const viewer of Object.keys(VIEWERS)) {
  const expected = await read(viewer, reference);
  for (const file of files.filter((name) => OPENS[viewer].some((end) => name.endsWith(end)))) {
    const turned = file.endsWith(".spz") ? [1, -1, -1] : [1, 1, 1];
    const result = await read(viewer, file).catch((error) => ({ error: String(error?.message ?? error) }));
    const apart = Math.max(0, ...(result.mean ?? []).map((value, i) => Math.abs(turned[i] * value - expected.mean[i])));
    const count = file.endsWith(".rad") ? nodes(file) : expected.count;
    const right = result.count === count && apart < MOST_APART;
    status ||= right ? 0 : 1;
    console.error(`check_formats: ${file}: ${viewer}: ` + (result.error ?? `${result.count} of ${count} Gaussians`
      + (result.mean ? `, mean position off by ${apart.toExponential(1)}` : "")) + (right ? "" : ": WRONG"));
  }
}
await browser.close();
server.close();
exit(status);
