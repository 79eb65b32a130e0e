// SPDX-License-Identifier: MIT
//
// scripts/check_serve lines: the page's figures over loopback, 20 Mbit/s and 5 Mbit/s with 60 ms there and back.
//   node check_serve_lines.mjs SCENE CAMERAS
// Turns the scene for six seconds, and rests five times after a short drag. The figures depend on the machine and on its load, so they are printed,
// not judged; that pictures come, follow the input, and end with the exact picture is checked.
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { argv, env, exit } from "node:process";
import puppeteer from "puppeteer-core";
import { check, exitCode, slowLine, startServer, through, wait } from "./serve_kit.mjs";

const [scene, cameras] = argv.slice(2);
const kSize = { width: 1280, height: 720 };
const kSeconds = Number(env.SECONDS_OF_ORBIT || 6);
const kSamples = 6, kRests = 5;
const lines = [["loopback", 0, 0], ["20 Mbit/s, 60 ms", 20, 60], ["5 Mbit/s, 60 ms", 5, 60]];

const server = await startServer(scene, "--cameras", cameras, "--backend", "cpu");
const browser = await puppeteer.launch({
  executablePath: env.BROWSER, headless: true, args: ["--no-sandbox", "--disable-gpu"],
});

// Records drawn pictures, bytes, and the time of the last input in the page.
function record() {
  const facts = { pictures: [], bytes: 0, lastInput: 0, samples: 0, sampled: [], cameras: new Map() };
  window.record = facts;
  const oldDraw = draw, oldSend = send, oldTake = takePart;
  window.send = (message, isInput = true) => {
    if (isInput) facts.lastInput = performance.now();
    oldSend(message, isInput);
  };
  window.takePart = (data) => {
    facts.bytes += data.byteLength;
    const head = new DataView(data);
    const numbers = [];
    for (let at = 32; at < 88; at += 8) numbers.push(head.getFloat64(at, true));
    facts.cameras.set(head.getUint32(4, true), [...numbers, head.getFloat32(88, true), head.getFloat32(92, true)]);
    return oldTake(data);
  };
  window.draw = (image, picture) => {
    oldDraw(image, picture);
    facts.pictures.push({
      at: performance.now(), delay: line.delay, codec: picture.codec, width: picture.width,
      lossless: picture.lossless, sinceInput: performance.now() - facts.lastInput,
      camera: facts.cameras.get(picture.number).join(),
    });
    if (facts.samples > facts.sampled.length && !picture.lossless) {
      const data = context.getImageData(0, 0, canvas.width, canvas.height).data;
      let text = "";
      for (let i = 0; i < data.length; i += 8192) text += String.fromCharCode(...data.subarray(i, i + 8192));
      facts.sampled.push({ data: btoa(text), camera: facts.cameras.get(picture.number), divisor: picture.divisor });
    }
  };
}

// A rotation matrix, world from view, of the quaternion view from world.
function worldFromView([x, y, z, w]) {
  const m = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
             [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
             [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]];
  return [0, 1, 2].map((row) => [0, 1, 2].map((column) => m[column][row]));
}

// PSNR in dB of a picture on the canvas and the picture that `render` draws of its camera.
function psnr({ data, camera, divisor }) {
  const [width, height] = [kSize.width, kSize.height];
  writeFileSync("sample.json", JSON.stringify([{
    id: 0, img_name: "sample", width, height, position: camera.slice(0, 3), rotation: worldFromView(camera.slice(3, 7)),
    fx: camera[7] * divisor, fy: camera[8] * divisor,
  }]));
  execFileSync(env.QUADSPLAT, ["render", scene, "--cameras", "sample.json", "--backend", "cpu", "--camera-index", "0",
    "--size", `${width}x${height}`, "--output", "sample.ppm", "--overwrite"], { stdio: "ignore" });
  const file = readFileSync("sample.ppm"), drawn = Buffer.from(data, "base64");
  const bytes = file.subarray(file.length - 3 * width * height);
  let sum = 0;
  for (let i = 0; i < bytes.length; ++i) sum += (bytes[i] - drawn[4 * Math.floor(i / 3) + i % 3]) ** 2;
  return 10 * Math.log10(255 * 255 * bytes.length / Math.max(sum, 1e-9));
}

async function orbit(page, box, seconds) {
  const began = performance.now();
  let x = 0;
  for (let step = 0; performance.now() - began < 1000 * seconds; ++step) {
    x = 300 * (1 - Math.cos((performance.now() - began) / 1500));  // there and back
    await page.mouse.move(box.x + 200 + x, box.y + 200);
    await wait(Math.max(0, 16 * (step + 1) - (performance.now() - began)));
  }
}

const middle = (values, share = 0.5) => [...values].sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(share * values.length))];

for (const [name, megabits, trip] of lines) {
  const line = megabits > 0 ? await slowLine(server.port, megabits, trip) : { port: server.port, end() {} };
  const page = await browser.newPage();
  try {
    await page.setViewport({ width: kSize.width, height: 2 * kSize.height });
    await page.goto(through(server.address, line.port));
    const bars = 2 * kSize.height - await page.$eval("canvas", (canvas) => canvas.clientHeight);
    await page.setViewport({ width: kSize.width, height: kSize.height + bars });
    await page.waitForFunction((height) => {
      const canvas = document.querySelector("canvas");
      return canvas.dataset.exact === "true" && canvas.height === height;
    }, { timeout: 60000 }, kSize.height);
    await page.evaluate(record);
    const box = await (await page.$("canvas")).boundingBox();
    await page.mouse.move(box.x + 200, box.y + 200);
    await page.mouse.down();
    await orbit(page, box, 2);  // the rate becomes known
    await page.evaluate(() => { window.record.pictures.length = 0; window.record.bytes = 0; });
    const began = performance.now();
    await orbit(page, box, kSeconds);
    const seconds = (performance.now() - began) / 1000;
    const moving = await page.evaluate(() => ({ pictures: window.record.pictures.slice(), bytes: window.record.bytes }));
    await page.evaluate((samples) => { window.record.samples = samples; }, kSamples);
    await orbit(page, box, 1.5);
    const sampled = await page.evaluate(() => { window.record.samples = 0; return window.record.sampled; });
    const rests = [];
    for (let i = 0; i < kRests; ++i) {  // sampling would delay them
      await orbit(page, box, 0.7);
      await page.mouse.up();
      await page.waitForFunction(() => {
        const last = window.record.pictures.at(-1);
        return last && last.lossless && Number(canvas.dataset.input) === input;
      }, { timeout: 60000 });
      rests.push(await page.evaluate(() => window.record.pictures.at(-1).sinceInput));
      await page.mouse.down();
    }
    await page.mouse.up();
    const pictures = moving.pictures.filter((picture) => !picture.lossless);
    const distinct = new Set(pictures.map((picture) => picture.camera)).size;
    const delays = pictures.map((picture) => picture.delay);
    const share = (codec) => `${Math.round(100 * pictures.filter((picture) => picture.codec === codec).length / pictures.length)} % `;
    const codecs = [[1, "JPEG"], [3, "VP9"]].filter(([codec]) => !share(codec).startsWith("0 ")).map(([codec, name]) => share(codec) + name).join(", ");
    const widths = [...new Set(pictures.map((picture) => picture.width))].join("+");
    const qualities = sampled.map(psnr);
    console.log(`        ${name}: ${codecs} ${widths} wide, ${(distinct / seconds).toFixed(1)} pictures a second, ` +
      `input to picture ${middle(delays).toFixed(0)} ms (most ${Math.max(...delays).toFixed(0)}), ` +
      `${(8 * moving.bytes / seconds / 1e6).toFixed(2)} Mbit/s, ` +
      `PSNR ${(qualities.reduce((a, b) => a + b, 0) / qualities.length).toFixed(1)} dB ` +
      `(least ${Math.min(...qualities).toFixed(1)}), exact ${middle(rests).toFixed(0)} ms after the last input ` +
      `(${Math.min(...rests).toFixed(0)} to ${Math.max(...rests).toFixed(0)})`);
    check(`${name}: pictures follow the input`, distinct > kSeconds && Math.max(...delays) < 10000, distinct);
    check(`${name}: samples show the scene`, qualities.length > 0 && Math.min(...qualities) > 20, qualities);
    if (megabits > 0) check(`${name}: no more than the line carries`, 8 * moving.bytes / seconds < 1.1e6 * megabits, moving.bytes);
  } catch (error) {
    check(`${name}: all steps were possible`, false, error);
    await page.screenshot({ path: "failed_line.png" }).catch(() => {});
  }
  await page.close();
  line.end();
}
await browser.close();
check("Ctrl+C ends the server with 130", (await server.end()) === 130);
exit(exitCode());
