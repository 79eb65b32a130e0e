// SPDX-License-Identifier: MIT
// Draws the scenes of the conformance kit with viewers that others wrote, in headless Chromium with software WebGL.
//   node render_kit.mjs VIEWER KIT OUT     VIEWER: one of the names below; run in a folder with node_modules
// Writes OUT/NAME.png for every scene. scripts/check_viewers installs the packages and calls this.
import fs from "fs";
import http from "http";
import path from "path";
import puppeteer from "puppeteer-core";

const [viewer, kit, out] = process.argv.slice(2);
const chromium = process.env.CHROMIUM ?? "/usr/bin/chromium";

// Code of a page. It defines async function draw(scene), which leaves the picture in `renderer`'s canvas.
const start = `
  import * as THREE from "three";
  const renderer = new THREE.WebGLRenderer({ antialias: false, alpha: false, preserveDrawingBuffer: true });
  document.body.appendChild(renderer.domElement);
  // Three's view axes are x right, y up, z backward; the kit's view axes are x right, y down, z
  // forward.
  function camera_of(s) {
    const camera = new THREE.PerspectiveCamera(2 * Math.atan(s.height / 2 / s.fy) * 180 / Math.PI, s.width / s.height, 0.05, 200);
    const m = s.view_from_world, signs = [1, -1, -1];
    const view = new THREE.Matrix4().set(...m.flatMap((row, i) => row.map((v) => signs[i] * v)), 0, 0, 0, 1);
    view.invert().decompose(camera.position, camera.quaternion, camera.scale);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld(true);
    camera.projectionMatrix.elements[0] = 2 * s.fx / s.width;
    camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
    return camera;
  }
  function prepare(s) {
    renderer.setPixelRatio(1);
    renderer.setSize(s.width, s.height, true);
    renderer.setClearColor(new THREE.Color().setRGB(...s.background, THREE.SRGBColorSpace), 1);
  }
  const wait = (ms) => new Promise((done) => setTimeout(done, ms));
`;
const spark = (options, mesh) => `${start}
  import { SparkRenderer, SplatMesh } from "@sparkjsdev/spark";
  window.draw = async (s) => {
    prepare(s);
    const scene = new THREE.Scene(), camera = camera_of(s);
    scene.add(new SparkRenderer({ renderer, ${options} }));
    const splats = new SplatMesh({ url: "/kit/" + s.scene, ${mesh} });
    await splats.initialized;
    scene.add(splats);
    for (let i = 0; i < 12; ++i) {  // splats are sorted in the background
      renderer.render(scene, camera);
      await wait(40);
    }
    renderer.render(scene, camera);
  };`;
const mkkellogg = (options) => `${start}
  import * as GaussianSplats3D from "@mkkellogg/gaussian-splats-3d";
  window.draw = async (s) => {
    prepare(s);
    const camera = camera_of(s);
    const viewer = new GaussianSplats3D.Viewer({ selfDrivenMode: false, renderer, camera, useBuiltInControls: false,
      rootElement: document.body, sharedMemoryForWorkers: false, gpuAcceleratedSort: false, sphericalHarmonicsDegree: 2,
      sceneRevealMode: GaussianSplats3D.SceneRevealMode.Instant, antialiased: s.antialiased, ${options} });
    await viewer.addSplatScene("/kit/" + s.scene, { showLoadingUI: false, splatAlphaRemovalThreshold: 0, progressiveLoad: false });
    for (let i = 0; i < 12; ++i) {
      viewer.update();
      viewer.render();
      await wait(40);
    }
    viewer.update();
    viewer.render();
  };`;
const viewers = {
  "spark": spark("", ""),
  "spark-3dgs": spark("sortRadial: false, preBlurAmount: s.antialiased ? 0 : 0.3, blurAmount: s.antialiased ? 0.3 : 0, " +
    "maxStdDev: 3.4, minAlpha: 1 / 255, maxPixelRadius: 8192, clipXY: 4, accumExtSplats: true", "extSplats: true"),
  "mkkellogg": mkkellogg(""),
  "mkkellogg-float": mkkellogg("halfPrecisionCovariancesOnGPU: false, integerBasedSort: false"),
};
// With few Gaussians mkkellogg's viewer does not draw the first Gaussians, or deforms them. So it
// gets some more Gaussians, far away and invisible.
const padding = viewer.startsWith("mkkellogg") ? 32 : 0;
if (!(viewer in viewers)) throw new Error(`unknown viewer: ${Object.keys(viewers).join(", ")}`);

const files = {
  "/three": "node_modules/three",
  "/spark": "node_modules/@sparkjsdev/spark/dist",
  "/mkkellogg": "node_modules/@mkkellogg/gaussian-splats-3d/build",
};
const page_text = `<!DOCTYPE html><html><body style="margin:0"><script type="importmap">{"imports": {
  "three": "/three/build/three.module.js", "three/addons/": "/three/examples/jsm/",
  "@sparkjsdev/spark": "/spark/spark.module.js", "@mkkellogg/gaussian-splats-3d": "/mkkellogg/gaussian-splats-3d.module.js"}}
  </script><script type="module">${viewers[viewer]} window.ready = true;</script></body></html>`;
const types = { ".js": "text/javascript", ".html": "text/html", ".wasm": "application/wasm" };
// The bytes of a scene's .ply with `padding` further Gaussians.
function padded(scene) {
  const bytes = fs.readFileSync(path.join(kit, scene.scene));
  const body = bytes.indexOf("end_header\n") + "end_header\n".length;
  const header = bytes.toString("latin1", 0, body);
  const count = Number(/element vertex (\d+)/.exec(header)[1]);
  const columns = [...header.matchAll(/property float (\w+)/g)].map((m) => m[1]);
  const m = scene.view_from_world;
  const added = Buffer.alloc(padding * columns.length * 4);
  for (let i = 0; i < padding; ++i) {
    const view = [0.1 * i, 0, 50 + 0.1 * i].map((v, row) => v - m[row][3]);
    const world = [0, 1, 2].map((j) => m[0][j] * view[0] + m[1][j] * view[1] + m[2][j] * view[2]);
    const values = { x: world[0], y: world[1], z: world[2], opacity: -5.2, scale_0: -6, scale_1: -6, scale_2: -6, rot_0: 1,
      f_dc_0: -1.77, f_dc_1: -1.77, f_dc_2: -1.77 };
    columns.forEach((name, j) => added.writeFloatLE(values[name] ?? 0, (i * columns.length + j) * 4));
  }
  const text = header.replace(/element vertex \d+/, `element vertex ${count + padding}`);
  return Buffer.concat([Buffer.from(text, "latin1"), bytes.subarray(body), added]);
}
const scenes = JSON.parse(fs.readFileSync(path.join(kit, "kit.json"))).scenes;
const server = http.createServer((request, response) => {
  const url = new URL(request.url, "http://localhost").pathname;
  if (url === "/") return response.writeHead(200, { "Content-Type": "text/html" }).end(page_text);
  const scene = scenes.find((s) => url === "/kit/" + s.scene);
  if (scene) return response.writeHead(200, { "Content-Type": "application/octet-stream" }).end(padded(scene));
  const prefix = Object.keys(files).find((p) => url.startsWith(p + "/"));
  const file = prefix && path.join(files[prefix], path.normalize(url.slice(prefix.length)));
  if (!file || !fs.existsSync(file)) return response.writeHead(404).end();
  response.writeHead(200, { "Content-Type": types[path.extname(file)] ?? "application/octet-stream" });
  fs.createReadStream(file).pipe(response);
}).listen(0);

fs.mkdirSync(out, { recursive: true });
const browser = await puppeteer.launch({ executablePath: chromium, headless: true,
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"] });
let failures = 0;
for (const scene of scenes) {
  const page = await browser.newPage();  // a fresh page: viewers keep state
  const messages = [];
  page.on("pageerror", (error) => messages.push(error.message));
  page.on("console", (message) => { if (message.type() === "error") messages.push(message.text()); });
  try {
    await page.setViewport({ width: scene.width, height: scene.height });
    await page.goto(`http://localhost:${server.address().port}/`);
    await page.waitForFunction("window.ready", { timeout: 60000 });
    const picture = await page.evaluate(async (s) => {
      await window.draw(s);
      return document.querySelector("canvas").toDataURL("image/png");
    }, scene);
    fs.writeFileSync(path.join(out, scene.name + ".png"), Buffer.from(picture.split(",")[1], "base64"));
  } catch (error) {
    ++failures;
    console.error(`${scene.name}: ${error.message} ${messages.slice(0, 3).join("; ")}`);
  }
  await page.close();
}
await browser.close();
server.close();
process.exit(failures > 0 ? 1 : 0);
