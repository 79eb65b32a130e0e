// SPDX-License-Identifier: MIT
//
// scripts/check_serve page: starts the server, opens its page in Chromium or Firefox, and checks what a visitor sees.
//   node check_serve.mjs SCENE CAMERAS chrome|firefox
// Prints a line per check and leaves screenshots in the current folder. Exit code 1: a check failed. Firefox cannot
// emulate phones, media and names of hosts, so these checks are Chromium's.
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { argv, env, exit } from "node:process";
import puppeteer from "puppeteer-core";
import { check, exitCode, slowLine, startServer, through } from "./serve_kit.mjs";

const [scene, cameras, kind] = argv.slice(2);
const isChrome = kind === "chrome";
const server = await startServer(scene, "--cameras", cameras, "--backend", "cpu");
const { address, port } = server;

// ---- the browser --------------------------------------------------------------------------------
const browser = await puppeteer.launch({
  browser: kind, executablePath: env.BROWSER, headless: true,
  args: isChrome ? ["--no-sandbox", "--disable-gpu", "--host-resolver-rules=MAP foreign.example 127.0.0.1"] : [],
});
const page = await browser.newPage();
const problems = [];
page.on("pageerror", (error) => problems.push(String(error)));
page.on("console", (message) => { if (message.type() === "error") problems.push(message.text()); });
const outside = [];
page.on("request", (request) => { if (new URL(request.url()).host !== `127.0.0.1:${port}` && !request.url().startsWith("blob:")) outside.push(request.url()); });

const rest = (after = 0) => page.waitForFunction((least) => {
  const { exact, input, picture } = document.querySelector("canvas").dataset;
  return exact === "true" && Number(input) >= least && Number(picture) > 0;
}, { timeout: 30000 }, after);
const inputs = () => page.evaluate("input");
// Firefox passes keys to the page later.
async function press(key) {
  const before = await inputs();
  await page.keyboard.press(key);
  await page.waitForFunction((count) => input >= count, {}, before + 2);
}
// The pixels of the canvas, as base64 of RGBA.
const pixels = () => page.evaluate(() => {
  const canvas = document.querySelector("canvas");
  const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  let text = "";
  for (let i = 0; i < data.length; i += 8192) text += String.fromCharCode(...data.subarray(i, i + 8192));
  return { width: canvas.width, height: canvas.height, data: btoa(text) };
});

try {
  await page.setViewport({ width: 900, height: 640 });
  if (isChrome) await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: "dark" }]);
  await page.goto(address);
  await rest();
  check("the token leaves the address", !page.url().includes("token"), page.url());
  await page.screenshot({ path: kind + "_dark.png" });
  const facts = await page.$eval("#line", (line) => line.textContent);
  check("the status line has codec, size and rate", /^WebP \u00b7 \d+\u00d7\d+ \u00b7 [\d.]+ Mbit\/s/.test(facts), facts);

  const first = await pixels();
  execFileSync(env.QUADSPLAT, ["render", scene, "--cameras", cameras, "--backend", "cpu", "--camera-index", "0",
    "--size", `${first.width}x${first.height}`, "--output", "render.ppm", "--overwrite"], { stdio: "ignore" });
  const file = readFileSync("render.ppm");
  const drawn = Buffer.from(first.data, "base64");
  const bytes = file.subarray(file.length - 3 * first.width * first.height);
  let different = 0;
  for (let i = 0; i < bytes.length; ++i) different += bytes[i] !== drawn[4 * Math.floor(i / 3) + i % 3] ? 1 : 0;
  check("the picture at rest is that of render", different === 0, different + " values differ");

  const box = await (await page.$("canvas")).boundingBox();
  await page.mouse.move(box.x + 300, box.y + 200);
  await page.mouse.down();
  await page.mouse.move(box.x + 400, box.y + 240, { steps: 10 });
  await page.mouse.up();
  await rest(await inputs());
  const turned = await pixels();
  check("a drag turns the scene", turned.data !== first.data);
  await press("Home");
  await rest(await inputs());
  check("Home returns to the first view", (await pixels()).data === first.data);

  await page.keyboard.down("w");
  await new Promise((resolve) => setTimeout(resolve, 400));
  await page.keyboard.up("w");
  await rest(await inputs());
  check("W moves the camera", (await pixels()).data !== first.data);

  await press("1");
  await page.waitForFunction(() => document.querySelector("#mode").value === "3dgs");
  check("1 chooses 3dgs", true);
  await press("h");
  await page.waitForFunction(() => document.querySelector("#numbers").textContent.includes("heat map pairs"));
  await rest(await inputs());
  await page.screenshot({ path: kind + "_heatmap.png" });

  await page.click("#menu");
  await page.screenshot({ path: kind + "_commands.png" });
  const names = await page.$$eval("#commands button", (buttons) => buttons.map((button) => button.dataset.help));
  check("the commands of the window are offered", names.includes("Frame the scene") && names.includes("quadbox"), names);
  check("commands that write files are not", !names.some((name) => /film|screenshot|open|quit|save/i.test(name)), names);
  await page.keyboard.press("Escape");
  await page.click("#ask");
  if (isChrome) await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: "light" }]);
  await page.screenshot({ path: kind + "_help.png" });
  await page.click("#ask");

  if (isChrome) {
    const tree = JSON.stringify(await page.accessibility.snapshot());
    for (const name of ["Culling mode", "Screenshot", "Help"]) check(`"${name}" has a name for screen readers`, tree.includes(name));
  }

  await page.evaluate(() => socket.close());
  await page.waitForFunction(() => socket.readyState === 1 && document.querySelector("#connection").textContent === "exact", { timeout: 20000 });
  check("a lost connection comes back", true);

  await checkVideo();
  if (isChrome) await checkPhoneAndNames();
  const stranger = await (await browser.createBrowserContext()).newPage();
  await stranger.goto(`http://127.0.0.1:${port}/`);
  await stranger.waitForFunction(() => document.querySelector("#connection").textContent.includes("no valid token"));
  check("without the token nothing is shown", true);

  check("no request leaves the server", outside.length === 0, outside);
  check("the page reports no error", problems.length === 0, problems.join("; "));
} catch (error) {
  check("all steps were possible", false, error + " " + problems.join("; "));
  await page.screenshot({ path: kind + "_failed.png" }).catch(() => {});
} finally {
  await browser.close();
  check("Ctrl+C ends the server with 130", (await server.end()) === 130);
}
exit(exitCode());

// Over a slow line moving pictures are VP9, also after an error of the decoder and in another size; a page without
// VideoDecoder gets JPEG.
async function checkVideo() {
  const line = await slowLine(port, 10, 40);
  const slow = await browser.newPage();
  const moving = async (codec) => {
    await slow.evaluate(() => { canvas.dataset.codec = ""; });
    const box = await (await slow.$("canvas")).boundingBox();
    await slow.mouse.move(box.x + 100, box.y + 100);
    await slow.mouse.down();
    for (let i = 0; i < 400; ++i) {
      await slow.mouse.move(box.x + 100 + i % 50, box.y + 100);
      if (await slow.$eval("canvas", (canvas) => canvas.dataset.codec) === codec) break;
    }
    const found = await slow.$eval("canvas", (canvas) => canvas.dataset.codec);
    await slow.mouse.up();
    await slow.waitForFunction(() => canvas.dataset.exact === "true" && Number(canvas.dataset.input) === input, { timeout: 30000 });
    return found;
  };
  try {
    await slow.setViewport({ width: 900, height: 640 });
    await slow.goto(through(address, line.port));
    await slow.waitForFunction(() => canvas.dataset.exact === "true", { timeout: 30000 });
    check("over a slow line pictures are VP9", (await moving("VP9")) === "VP9");
    await slow.setViewport({ width: 700, height: 500 });
    await slow.waitForFunction(() => canvas.dataset.exact === "true" && canvas.width === 700, { timeout: 30000 });
    check("also in another size", (await moving("VP9")) === "VP9");
    await slow.evaluate(() => decoder.fail());
    check("and after an error of the decoder", (await moving("VP9")) === "VP9");
    await slow.evaluate(() => { decoder.errors = 9; decoder.fail(); });
    check("a page that cannot decode gets JPEG", (await moving("JPEG")) === "JPEG");
    await slow.evaluateOnNewDocument(() => { delete window.VideoDecoder; });
    await slow.reload();
    await slow.waitForFunction(() => canvas.dataset.exact === "true", { timeout: 30000 });
    check("and so does a browser without VideoDecoder", (await moving("JPEG")) === "JPEG");
  } finally {
    await slow.close();
    line.end();
  }
}

async function checkPhoneAndNames() {
  const phone = await browser.newPage();
  await phone.emulate({ viewport: { width: 390, height: 800, deviceScaleFactor: 2, isMobile: true, hasTouch: true }, userAgent: "phone" });
  await phone.goto(address);
  await phone.waitForFunction(() => document.querySelector("canvas").dataset.exact === "true", { timeout: 30000 });
  const wide = await phone.evaluate(() => document.documentElement.scrollWidth);
  check("the page fits a phone", wide <= 390, wide);
  const before = await phone.evaluate(() => document.querySelector("canvas").dataset.picture);
  await phone.touchscreen.touchStart(200, 300);
  for (let x = 200; x < 300; x += 10) await phone.touchscreen.touchMove(x, 320);
  await phone.touchscreen.touchEnd();
  await phone.waitForFunction((old) => Number(document.querySelector("canvas").dataset.picture) > Number(old), {}, before);
  check("a finger turns the scene", true);
  await phone.screenshot({ path: "phone.png" });
  await phone.close();

  const foreign = await browser.newPage();
  const answer = await foreign.goto(`http://foreign.example:${port}/`);
  check("a foreign name of this machine is refused", answer.status() === 403, answer.status());
  await foreign.close();
}
