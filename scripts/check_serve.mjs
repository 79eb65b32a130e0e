// SPDX-License-Identifier: MIT
//
// scripts/check_serve: starts the server, opens its page in Chromium, and checks what a visitor sees.
//   node check_serve.mjs SCENE CAMERAS
// Prints a line per check and leaves screenshots in the current folder. Exit code 1: a check failed.
import { execFileSync, spawn } from "node:child_process";
import { readFileSync } from "node:fs";
import { argv, env, exit } from "node:process";
import puppeteer from "puppeteer-core";

const [scene, cameras] = argv.slice(2);
let failures = 0;
function check(what, holds, found = "") {
  console.log((holds ? "ok      " : "FAILED  ") + what + (holds ? "" : ": " + found));
  if (!holds) ++failures;
}

// ---- the server ---------------------------------------------------------------------------------
const server = spawn(env.QUADSPLAT, ["serve", scene, "--cameras", cameras, "--backend", "cpu", "--port", "0"]);
let errors = "";
server.stderr.on("data", (data) => { errors += data; });
const address = await new Promise((resolve, reject) => {
  let out = "";
  server.stdout.on("data", (data) => {
    out += data;
    if (out.includes("\n")) resolve(out.trim());
  });
  server.on("exit", () => reject(new Error("the server ended: " + errors)));
});
const port = new URL(address).port;

// ---- the browser --------------------------------------------------------------------------------
const browser = await puppeteer.launch({
  executablePath: env.CHROMIUM, headless: true,
  args: ["--no-sandbox", "--disable-gpu", `--host-resolver-rules=MAP foreign.example 127.0.0.1`],
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
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: "dark" }]);
  await page.goto(address);
  await rest();
  check("the token leaves the address", !page.url().includes("token"), page.url());
  await page.screenshot({ path: "dark.png" });

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
  await page.keyboard.press("Home");
  await rest(await inputs());
  check("Home returns to the first view", (await pixels()).data === first.data);

  await page.keyboard.down("w");
  await new Promise((resolve) => setTimeout(resolve, 400));
  await page.keyboard.up("w");
  await rest(await inputs());
  check("W moves the camera", (await pixels()).data !== first.data);

  await page.keyboard.press("1");
  await page.waitForFunction(() => document.querySelector("#mode").value === "3dgs");
  check("1 chooses 3dgs", true);
  await page.keyboard.press("h");
  await page.waitForFunction(() => document.querySelector("#numbers").textContent.includes("heat map pairs"));
  await rest(await inputs());
  await page.screenshot({ path: "heatmap.png" });

  await page.click("#menu");
  await page.screenshot({ path: "commands.png" });
  const names = await page.$$eval("#commands button", (buttons) => buttons.map((button) => button.dataset.help));
  check("the commands of the window are offered", names.includes("Frame the scene") && names.includes("quadbox"), names);
  check("commands that write files are not", !names.some((name) => /film|screenshot|open|quit|save/i.test(name)), names);
  await page.keyboard.press("Escape");
  await page.click("#ask");
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: "light" }]);
  await page.screenshot({ path: "help_light.png" });
  await page.click("#ask");

  const tree = JSON.stringify(await page.accessibility.snapshot());
  for (const name of ["Culling mode", "Screenshot", "Help"]) check(`"${name}" has a name for screen readers`, tree.includes(name));

  await page.evaluate(() => socket.close());
  await page.waitForFunction(() => socket.readyState === 1 && document.querySelector("#connection").textContent === "exact", { timeout: 20000 });
  check("a lost connection comes back", true);

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
  const stranger = await (await browser.createBrowserContext()).newPage();
  await stranger.goto(`http://127.0.0.1:${port}/`);
  await stranger.waitForFunction(() => document.querySelector("#connection").textContent.includes("no valid token"));
  check("without the token nothing is shown", true);

  check("no request leaves the server", outside.length === 0, outside);
  check("the page reports no error", problems.length === 0, problems.join("; "));
} catch (error) {
  check("all steps were possible", false, error + " " + problems.join("; "));
  await page.screenshot({ path: "failed.png" }).catch(() => {});
} finally {
  await browser.close();
  server.removeAllListeners("exit");
  const ended = new Promise((resolve) => server.on("exit", (code) => resolve(code)));
  server.kill("SIGINT");
  check("Ctrl+C ends the server with 130", (await ended) === 130);
}
exit(failures === 0 ? 0 : 1);
