// SPDX-License-Identifier: MIT
//
// scripts/check_serve page: starts the server, opens its page in Chromium or Firefox, and checks what a visitor sees.
//   node check_serve.mjs SCENE CAMERAS chrome|firefox
// Prints a line per check and leaves screenshots in the current folder. Exit code 1: a check failed. Firefox cannot
// emulate phones, media and names of hosts, so these checks are Chromium's.
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { argv, env, exit } from "node:process";
import puppeteer from "puppeteer-core";
import { check, exitCode, slowLine, start, startServer, through } from "./serve_kit.mjs";

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

// The panels as a visitor uses them, mostly by keyboard.
async function checkPanels(page, box) {
  const open = (name) => page.waitForSelector(`#panel-${name}:not([hidden])`, { timeout: 30000 });
  const focusPicture = () => page.focus("canvas");
  const mode = (name) => page.waitForFunction((it) => sections["table/table"] && sections["table/table"].rows.some((row) => row.here && row.cells[0].text === it), { timeout: 30000 }, name);
  await focusPicture();
  await page.keyboard.press("F10");
  await open("table");
  await page.waitForFunction(() => sections["table/text"].text.includes("medians of"), { timeout: 120000 });
  const measured = await page.evaluate(() => sections["table/table"].rows.every((row) => row.cells[1].value > 0) && sections["table/table"].rows.length);
  check("a view at rest is measured in all modes", measured >= 6, measured);
  const texts = await page.evaluate(() => [...document.querySelectorAll('#panel-table td[data-column="pairs"]')].map((cell) => cell.textContent).join() === sections["table/table"].rows.map((row) => row.cells[2].text).join());
  check("the table shows the server's digits", texts);
  await page.keyboard.press("3");
  await mode("dualbox");
  const here = await page.$eval("#panel-table tr.here button", (button) => button.textContent);
  check("the table follows the keys", here === "dualbox", here);
  await page.focus('#panel-table button[data-cell="exact"]');
  await page.keyboard.press("Enter");
  await mode("exact");
  check("a row chooses its mode by keyboard", await page.evaluate(() => document.activeElement.dataset.cell === "exact"));
  await page.screenshot({ path: "table.png" });
  await focusPicture();
  await page.keyboard.press("F10");
  await page.waitForSelector("#panel-table", { hidden: true });

  await page.keyboard.press("b");
  await open("inspector");
  await page.mouse.click(box.x + 250, box.y + 300);
  await page.waitForFunction(() => sections["inspector/table"] && sections["inspector/figure"], { timeout: 60000 });
  const rows = await page.$$eval("#panel-inspector [data-cell]", (buttons) => buttons.length);
  check("a click lists the Gaussians of a pixel", rows > 1, rows);
  check("the inspector draws the boxes", await page.$("#panel-inspector svg polygon") !== null);
  await page.screenshot({ path: "inspector.png" });
  await focusPicture();
  await page.keyboard.press("b");

  await page.keyboard.press("c");
  await page.waitForSelector("#overlay .divider", { timeout: 60000 });
  await page.focus("#overlay .divider");
  for (let i = 0; i < 5; ++i) await page.keyboard.press("ArrowLeft");
  await page.waitForFunction(() => Math.abs(sections.divider.divider - 0.4) < 0.01, { timeout: 30000 });
  check("the divider moves by keyboard", true);
  await page.waitForFunction(() => sections["split/facts"].facts.some(([label]) => label === "PSNR"), { timeout: 30000 });
  await rest(await inputs());
  await page.screenshot({ path: "split.png" });
  await focusPicture();
  await page.keyboard.press("c");
  await page.keyboard.press("F9");
  await page.waitForFunction(() => document.querySelectorAll("#overlay .cell").length >= 6, { timeout: 60000 });
  check("all modes are shown side by side", true);
  await focusPicture();
  await page.keyboard.press("F9");
  await page.waitForFunction(() => document.querySelectorAll("#overlay .cell").length === 0, { timeout: 60000 });

  await page.keyboard.press("i");
  await open("settings");
  await page.focus('[data-control="splat scale"]');
  await page.keyboard.press("End");
  await page.waitForFunction(() => sections["settings/controls"].rows.find((row) => row.name === "splat scale").value === 3, { timeout: 30000 });
  check("a setting is changed by keyboard", true);
  await page.evaluate(() => setControl("splat scale", 1));
  await focusPicture();
  await page.keyboard.press("i");

  await page.keyboard.press("r");
  await open("crop");
  await page.focus('[data-control="Box"]');
  await page.keyboard.press(" ");
  await page.waitForSelector("#overlay .handle", { timeout: 30000 });
  check("the box of the crop has handles", (await page.$$("#drawing line")).length >= 8);
  await page.focus('[data-control="Box"]');
  await page.keyboard.press(" ");
  await page.waitForFunction(() => document.querySelectorAll("#overlay .handle").length === 0, { timeout: 30000 });
  await focusPicture();
  await page.keyboard.press("r");

  await page.keyboard.press("z");
  await open("recorder");
  await page.evaluate(() => setControl("steps", 2));
  await page.waitForFunction(() => sections["recorder/text"].text.startsWith("2 steps"), { timeout: 30000 });
  await page.evaluate(() => [...document.querySelectorAll("#panel-recorder button")].find((button) => button.textContent === "Record").click());
  await page.waitForFunction(() => Object.values(sections).some((one) => one && one.text && one.text.startsWith("all 2 steps")), { timeout: 300000 });
  check("a zoom is recorded with its chart", (await page.$$("#panel-recorder svg polyline")).length >= 6);
  await page.evaluate(() => [...document.querySelectorAll("#panel-recorder button")].find((button) => button.textContent === "The zoom as CSV").click());
  await page.waitForFunction(() => (document.body.dataset.saved || "").endsWith("_zoom.csv"), { timeout: 30000 });
  check("the zoom is saved as CSV", true);
  await page.screenshot({ path: "recorder.png" });
  await focusPicture();
  await page.keyboard.press("z");

  await page.keyboard.press("l");
  await open("path");
  await page.keyboard.press("k");
  await page.keyboard.press("]");
  await page.waitForFunction(() => sections["path/items"].rows.length === 1, { timeout: 30000 });
  await rest(await inputs());
  await page.keyboard.press("k");
  await page.waitForFunction(() => sections["path/items"].rows.length === 2, { timeout: 30000 });
  await page.evaluate(() => setControl("seconds", 0.2, 1));
  await page.waitForFunction(() => Math.abs(sections["path/items"].rows[1].find((item) => item.control === "seconds").value - 0.2) < 1e-6, { timeout: 30000 });
  await page.evaluate(() => [...document.querySelectorAll("#panel-path button")].find((button) => button.textContent === "Film").click());
  await page.waitForFunction(() => (document.body.dataset.saved || "").endsWith(".mp4") || sections.messages.some((one) => one.text.includes("ffmpeg")), { timeout: 120000 });
  check("a film is saved, or the page says that ffmpeg is missing", true);
  await page.screenshot({ path: "path.png" });

  const edits = join(mkdtempSync(join(tmpdir(), "quadsplat_edits_")), "mine.edits.json");
  writeFileSync(edits, JSON.stringify({ version: 1, steps: [{ step: "select", tool: "sphere", point: [0, 0, 0], radius: 1 }, { step: "hide" }] }));
  await (await page.$("#file")).uploadFile(edits);
  await page.waitForFunction(() => sections.messages.some((one) => one.text.startsWith("mine.edits.json: 2 steps")), { timeout: 30000 });
  check("a file of edits is opened", true);
  rmSync(edits);
  await page.evaluate(() => send({ type: "command", command: "Undo" }));
  await focusPicture();
  await page.keyboard.press("l");

  await page.keyboard.press("F10");
  await open("table");
  if (isChrome) {
    const tree = JSON.stringify(await page.accessibility.snapshot({ interestingOnly: false }));
    for (const name of ["FPS of all modes", "Open panels", "measure at", "Close FPS of all modes"])
      check(`"${name}" has a name for screen readers`, tree.includes(name));
  }
  for (const [width, height] of [[3840, 2160], [1280, 720]]) {
    await page.setViewport({ width, height });
    await new Promise((resolve) => setTimeout(resolve, 500));
    const fits = await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth && document.documentElement.scrollHeight <= innerHeight);
    check(`the page fits ${width}x${height}`, fits);
  }
  await page.setViewport({ width: 900, height: 640 });
  await focusPicture();
  await page.keyboard.press("F10");
}

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
  await page.waitForFunction(() => document.querySelector("#note").textContent.includes("with a heat map"), { timeout: 30000 });
  await rest(await inputs());
  await page.screenshot({ path: kind + "_heatmap.png" });

  await page.click("#menu");
  await page.screenshot({ path: kind + "_commands.png" });
  const names = await page.$$eval("#commands button", (buttons) => buttons.map((button) => button.dataset.help));
  check("the commands of the window are offered", names.includes("Frame the scene") && names.includes("quadbox"), names);
  await page.type("#commands input", "map heat");
  const found = await page.$$eval("#commands button:not([hidden])", (buttons) => buttons.map((button) => button.dataset.help));
  check("a command is found by words", found.length === 2 && found.includes("Heat map"), found);
  await page.$eval("#commands input", (field) => { field.value = ""; field.dispatchEvent(new Event("input")); });
  // The browser saves the edits.
  const here = names.filter((name) => /screenshot|open a|reload|quit|save|train/i.test(name) && name !== "Save the edits");
  check("commands that open or write files here are not", here.length === 0, here);
  await page.keyboard.press("Escape");
  await page.click("#ask");
  if (isChrome) await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: "light" }]);
  await page.screenshot({ path: kind + "_help.png" });
  await page.click("#ask");

  if (isChrome) {
    const tree = JSON.stringify(await page.accessibility.snapshot());
    for (const name of ["Culling mode", "Screenshot", "Help"]) check(`"${name}" has a name for screen readers`, tree.includes(name));
  }

  await page.focus("canvas");
  await page.keyboard.press("h");
  await checkPanels(page, box);

  await rest(await inputs());
  const kept = await page.evaluate(() => JSON.stringify(JSON.parse(sections.view.pose).position));
  await page.reload();
  await page.waitForFunction((place) => sections.view && JSON.stringify(JSON.parse(sections.view.pose).position) === place, { timeout: 30000 }, kept);
  check("a reload keeps the view", true);
  await page.evaluate(() => socket.close());
  await page.waitForFunction(() => socket.readyState === 1 && document.querySelector("#connection").textContent === "exact", { timeout: 20000 });
  check("a lost connection comes back", true);

  await checkVideo();
  await checkTraining();
  if (isChrome) await checkPhoneAndNames();
  const stranger = await (await browser.createBrowserContext()).newPage();
  await stranger.goto(`http://127.0.0.1:${port}/`);
  await stranger.waitForFunction(() => document.querySelector("#connection").textContent.includes("no valid token"));
  check("without the token nothing is shown", true);

  check("no request leaves the server", outside.length === 0, outside);
  check("the page reports no error", problems.length === 0, problems.join("; "));
} catch (error) {
  const pages = (await Promise.all(browser.browserContexts().map((context) => context.pages()))).flat();
  const lines = await Promise.all(pages.map((one) => one.evaluate(() => document.querySelector("footer")?.textContent).catch(String)));
  check("all steps were possible", false, [error, ...problems, ...lines].join("; "));
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
    await slow.goto(address);
    await slow.waitForFunction(() => canvas.dataset.exact === "true", { timeout: 30000 });
    check("over loopback pictures are JPEG", (await moving("JPEG")) === "JPEG");
    await slow.evaluate(() => { const old = draw; window.codecs = []; window.draw = (image, facts) => { window.codecs.push(kCodecs[facts.codec]); old(image, facts); }; });
    await moving("never");
    const codecs = await slow.evaluate(() => window.codecs.filter((codec) => codec !== "WebP"));
    check("and stay JPEG", codecs.filter((codec) => codec === "JPEG").length > 0.9 * codecs.length, codecs.join());
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

// A training from two pictures of the scene: its panel, its buttons, and Ctrl+C.
async function checkTraining() {
  const data = mkdtempSync(join(tmpdir(), "check_serve-"));
  mkdirSync(join(data, "images"));
  const two = JSON.parse(readFileSync(cameras, "utf8")).slice(0, 2);
  writeFileSync(join(data, "cameras.json"), JSON.stringify(two));
  two.forEach((camera, i) => execFileSync(env.QUADSPLAT, ["render", scene, "--cameras", cameras, "--camera-index", String(i), "--backend", "cpu", "--output", join(data, "images", camera.img_name + ".png")]));
  const training = await start("train", data, "--out-dir", join(data, "model"), "--resolution-scale", "2", "--iterations", "1000000", "--random-points", "2000", "--backend", "cpu", "--serve");
  const shown = await browser.newPage();
  try {
    shown.on("pageerror", (error) => problems.push(String(error)));
    await shown.setViewport({ width: 1280, height: 800 });
    await shown.goto(training.address);
    const fact = (label) => shown.evaluate((name) => (sections["training/facts"].facts.find((one) => one[0] === name) || [])[1], label);
    const state = (text) => shown.waitForFunction((it) => sections["training/facts"] && sections["training/facts"].facts[0][1] === it, { timeout: 60000 }, text);
    await state("running");
    const first = await fact("in the picture");
    await shown.waitForFunction((it) => sections["training/facts"].facts.find((one) => one[0] === "in the picture")[1] !== it && sections["training/chart"], { timeout: 60000 }, first);
    check("the picture follows a training", true);
    const press = (name) => shown.evaluate((it) => [...document.querySelectorAll("#panel-training button")].find((button) => button.textContent === it).click(), name);
    await press("Pause");
    await state("paused");
    await shown.waitForFunction(() => document.querySelector("canvas").dataset.exact === "true", { timeout: 60000 });
    const paused = await fact("iteration");
    await press("Step");
    await shown.waitForFunction((it) => sections["training/facts"].facts[1][1] !== it, { timeout: 60000 }, paused);
    check("a button takes one iteration", await fact("state") === "paused");
    check("no path reaches the page", !(await shown.evaluate(() => JSON.stringify(sections))).includes(data));
    await shown.screenshot({ path: "training.png" });
  } finally {
    await shown.close();
    const code = await training.end();
    check("Ctrl+C ends the training as without a page", code === 130, code);
    rmSync(data, { recursive: true });
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
  await new Promise((resolve) => setTimeout(resolve, 1000));  // a tap soon after a swipe is part of it
  await phone.tap("#choose");
  await phone.waitForSelector('#panels [data-panel="table"]', { visible: true });
  await phone.tap('#panels [data-panel="table"]');
  await phone.waitForSelector("#panel-table:not([hidden]) table", { timeout: 30000 });
  check("the list of panels closes on a phone", await phone.evaluate(() => document.querySelector("#panels").hidden));
  const wider = await phone.evaluate(() => document.documentElement.scrollWidth);
  check("an open panel fits a phone", wider <= 390, wider);
  check("the picture stays visible on a phone", await phone.evaluate(() => canvas.clientHeight > 200));
  await phone.screenshot({ path: "phone.png" });
  await phone.close();

  const foreign = await browser.newPage();
  const answer = await foreign.goto(`http://foreign.example:${port}/`);
  check("a foreign name of this machine is refused", answer.status() === 403, answer.status());
  await foreign.close();
}
