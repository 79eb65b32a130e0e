// SPDX-License-Identifier: MIT
//
// The page of `quadsplat serve`: connection, pictures, input. The server decides what keys and
// gestures do. src/app/serve/message.h has the messages, picture_message.h the header of pictures;
// video.js decodes them. The other scripts of this folder draw the panels from the server's state
// (`sections`).
"use strict";

const kFileMessage = 2, kHeader = 96, kKey = 1, kLossless = 2, kLastPart = 4, kLastStrip = 8, kMostSide = 4096;
const kReasons = {  // by the code with which the server closes the connection
  1011: "the server had an error with this page; trying again",
  1013: "the server has as many visitors as it serves; trying again",
};
const kWheelPixels = 100;  // of a notch

const at = (id) => document.getElementById(id);
const canvas = at("picture");
const context = canvas.getContext("2d", { alpha: false, colorSpace: "srgb" });
let socket = null, received = 0, input = 0, retry = 500;
let parts = [];          // of the strip that arrives
let strips = [];         // of the picture that arrives: first row, promise of an image
let shown = null;        // facts of the picture on the canvas
let newest = 0;          // number of the newest picture that has arrived
let sections = {};
let cursor = null, cursorDue = false;
const pressed = new Set();
const decoder = new PictureDecoder((decodes) => send({ type: "video", decodes }, false));
const line = new LineFacts();

// ---- connection ---------------------------------------------------------------------------------
// The token comes in the fragment, which is removed so that a copied address does not give it away.
function token() {
  const given = new URLSearchParams(location.hash.slice(1)).get("token");
  if (given) {
    sessionStorage.setItem("token", given);
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem("token") || "";
}

function send(message, isInput = true) {
  if (!socket || socket.readyState !== WebSocket.OPEN) return;
  if (isInput) line.input(message.input = ++input);
  socket.send(JSON.stringify(message));
}

function say(text, isError) {
  at("connection").textContent = text;
  document.querySelector("footer").classList.toggle("error", Boolean(isError));
}

function connect() {
  socket = new WebSocket((location.protocol === "https:" ? "wss://" : "ws://") + location.host + "/live");
  socket.binaryType = "arraybuffer";
  received = 0;
  input = 0;
  newest = 0;
  dropStrips();
  shown = null;
  sections = {};
  socket.onopen = () => {
    send({ type: "hello", token: token(), ...pictureSize() }, false);
    decoder.begin();
    restoreView();
  };
  socket.onmessage = (event) => {
    retry = 500;
    if (typeof event.data === "string") return takeState(JSON.parse(event.data));
    takePart(event.data);
  };
  socket.onclose = (event) => {
    if (event.code === 4401)
      return say("the address has no valid token: open the address that the program printed", true);
    say(kReasons[event.code] || "not connected; trying again", true);
    setTimeout(connect, retry);
    retry = Math.min(2 * retry, 8000);
  };
}

// A reload, or a connection that comes back, keeps the view and the open panels.
function keepView() {
  const { scene, pose, mode } = sections.view;
  const panels = (sections.panels || []).filter((panel) => panel.open).map((panel) => panel.title);
  sessionStorage.setItem("view", JSON.stringify({ scene, camera: pose, mode, panels }));
}
function restoreView() {
  const kept = JSON.parse(sessionStorage.getItem("view") || "null");
  if (!kept) return;
  const { scene, camera, mode, panels } = kept;
  send({ type: "view", scene, camera, mode });
  send({ type: "panels", open: panels });
}

// ---- pictures -----------------------------------------------------------------------------------
function pictureSize() {
  const scale = window.devicePixelRatio || 1;
  const box = canvas.getBoundingClientRect();
  const side = (length) => Math.min(kMostSide, Math.max(1, Math.round(length * scale)));
  return { width: side(box.width), height: side(box.height) };
}

function confirm(arrived) {
  const held = Math.min(10000, Math.max(0, performance.now() - arrived));
  send({ type: "received", count: ++received, held }, false);
}

async function takePart(data) {
  const arrived = performance.now();
  line.bytes(data.byteLength);
  if (new Uint8Array(data, 0, 1)[0] === kFileMessage) {
    takeFile(data);
    return confirm(arrived);
  }
  const head = new DataView(data, 0, kHeader);
  const facts = {
    codec: head.getUint8(1), flags: head.getUint8(2), divisor: head.getUint8(3),
    number: head.getUint32(4, true), input: head.getUint32(8, true),
    width: head.getUint16(16, true), height: head.getUint16(18, true), top: head.getUint16(20, true),
    key: (head.getUint8(2) & kKey) !== 0,
    lossless: (head.getUint8(2) & kLossless) !== 0,
  };
  if (facts.number !== newest) dropStrips();
  newest = facts.number;
  parts.push(new Uint8Array(data, kHeader));
  const owner = socket;
  if ((facts.flags & kLastPart) !== 0) {
    const image = decoder.image(facts, parts);
    image.catch(() => {});  // reported below
    strips.push({ top: facts.top, image });
    parts = [];
    if ((facts.flags & kLastStrip) !== 0) await showStrips(facts, owner);
  }
  if (owner === socket) confirm(arrived);
}

// A picture that another one replaces.
function dropStrips() {
  for (const { image } of strips) image.then((one) => one && one.close(), () => {});
  strips = [];
  parts = [];
}

async function showStrips(facts, owner) {
  const mine = strips;
  strips = [];
  try {
    const images = await Promise.all(mine.map(({ image }) => image));
    const isWanted = owner === socket && !(shown && shown.number > facts.number);
    if (isWanted && images.every(Boolean)) draw(images.map((image, i) => ({ image, top: mine[i].top })), facts);
    for (const image of images) if (image) image.close();
  } catch {
    say("the browser cannot show a picture of the server", true);
  }
}

// `drawn`: strips of the picture with their first rows.
function draw(drawn, facts) {
  const { width, height } = facts.divisor === 1 ? facts : pictureSize();
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  context.imageSmoothingEnabled = facts.width !== canvas.width;
  const scale = canvas.height / facts.height;
  drawn.forEach(({ image, top }, i) => {
    const bottom = i + 1 < drawn.length ? drawn[i + 1].top : facts.height;
    context.drawImage(image, 0, top * scale, canvas.width, (bottom - top) * scale);
  });
  shown = facts;
  line.shown(facts.input);
  at("line").textContent = line.text(facts);
  canvas.dataset.codec = kCodecs[facts.codec];
  canvas.dataset.picture = facts.number;
  canvas.dataset.input = facts.input;
  canvas.dataset.exact = facts.lossless;
  say(facts.lossless ? "exact" : "live");
}

// ---- state --------------------------------------------------------------------------------------
function takeState(message) {
  if (message.type !== "state") return;
  Object.assign(sections, message.sections);
  const changed = (...names) => names.some((name) => name in message.sections);
  if (changed("commands")) showCommands();
  if (changed("help", "commands")) showHelp();
  if (changed("scenes")) {
    fill(at("scene"), sections.scenes.map((scene, i) => [i, scene.name]));
    at("scene").parentElement.hidden = sections.scenes.length < 2;  // there is no choice
  }
  if (changed("view", "commands", "scenes")) showView();
  if (changed("status")) showStatus();
  if (changed("messages")) showMessages();
  showPanels(changed);
  if (changed("view", "panels") && sections.view) keepView();
}

function make(tag, text, parent) {
  const made = document.createElement(tag);
  made.textContent = text;
  parent.append(made);
  return made;
}

function fill(select, rows) {
  select.replaceChildren();
  for (const [value, text] of rows) make("option", text, select).value = value;
}

function showCommands() {
  const modes = sections.commands.filter((command) => command.menu === "Mode");
  fill(at("mode"), modes.map((command) => [command.help, command.help]));
  at("commands").replaceChildren();
  const words = make("input", "", at("commands"));
  Object.assign(words, { type: "search", placeholder: "words of a command", ariaLabel: "Words of a command" });
  words.oninput = () => filterCommands(words.value);
  words.onkeydown = (event) => {
    if (event.key === "Enter") at("commands").querySelector("button:not([hidden])")?.click();
  };
  let menu = "";
  for (const command of sections.commands) {
    if (command.held) continue;  // only a key can be held
    if (command.menu !== menu) make("h2", command.menu, at("commands"));
    menu = command.menu;
    const button = make("button", command.help, at("commands"));
    button.type = "button";
    button.title = command.tooltip;
    button.dataset.help = command.help;
    button.dataset.menu = command.menu;
    make("kbd", command.key, button);
    button.onclick = () => {
      send({ type: "command", command: command.help });
      canvas.focus();
    };
  }
}

// Shows the commands whose menu, name or key contain every word.
function filterCommands(text) {
  const words = text.toLowerCase().split(" ");
  for (const button of at("commands").querySelectorAll("button")) {
    const about = (button.dataset.menu + " " + button.textContent).toLowerCase();
    button.hidden = !words.every((word) => about.includes(word));
  }
  for (const menu of at("commands").querySelectorAll("h2")) menu.hidden = text !== "";
}

function showHelp() {
  if (!sections.help || !sections.commands) return;
  const table = at("help").querySelector("table");
  table.replaceChildren();
  const rows = [...sections.help, ["One finger", "as a left drag"], ["Two fingers", "pan, and nearer or farther"],
                ...sections.commands.map((command) => [command.key, command.help])];
  for (const [keys, effect] of rows) {
    const row = make("tr", "", table);
    make("td", keys, row);
    make("td", effect, row);
  }
}

function showView() {
  const view = sections.view;
  if (!view || !sections.scenes) return;
  at("scene").value = view.scene;
  at("mode").value = view.mode;
  for (const button of at("commands").querySelectorAll("button"))
    button.setAttribute("aria-pressed", view.checked.includes(button.dataset.help));
  document.title = view.title;
}

function showStatus() {
  const { numbers, note, faint, caution } = sections.status;
  setText(at("numbers"), numbers);
  at("numbers").classList.toggle("faint", faint);
  setText(at("note"), note);
  at("note").classList.toggle("caution", caution);
}

function showMessages() {
  at("messages").replaceChildren();
  for (const message of sections.messages)
    make("p", message.text, at("messages")).classList.toggle("error", message.error);
}

// ---- input --------------------------------------------------------------------------------------
// Positions are pixels of the picture.
function placeOnPicture(event) {
  const box = canvas.getBoundingClientRect(), size = pictureSize();
  const limit = (value) => Math.max(-1e5, Math.min(1e5, value));
  return { x: limit((event.clientX - box.left) * size.width / box.width),
           y: limit((event.clientY - box.top) * size.height / box.height) };
}

// One message for all motion until the next refresh of the screen.
function moveCursor(to) {
  cursor = to;
  if (cursorDue) return;
  cursorDue = true;
  requestAnimationFrame(flushCursor);
}
function flushCursor() {
  cursorDue = false;
  if (cursor) send({ type: "cursor", ...cursor });
  cursor = null;
}

const kButtons = [0, 2, 1];  // of the browser: left, middle, right
const fingers = new Map();
const kTapPixels = 8;  // a finger that moves less taps
let resting = null;    // the press of a finger that has not moved yet
let pinch = null, pinchDue = false;
let pinched = false;   // a second finger came: the last one to leave does nothing

function press(button, down, event) {
  if (cursor) flushCursor();
  send({ type: "button", button, down, ...placeOnPicture(event) });
}

function middle() {
  const [a, b] = [...fingers.values()];
  return { clientX: (a.clientX + b.clientX) / 2, clientY: (a.clientY + b.clientY) / 2,
           apart: Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY) };
}

canvas.addEventListener("pointerdown", (event) => {
  event.preventDefault();
  canvas.focus();
  canvas.setPointerCapture(event.pointerId);
  if (event.pointerType !== "touch") return press(kButtons[event.button] ?? 0, true, event);
  // Messages cover a large part of a phone's picture.
  for (const note of at("messages").querySelectorAll("p:not(.error)")) note.remove();
  fingers.set(event.pointerId, event);
  if (fingers.size === 1) resting = event;
  if (fingers.size === 2) {  // two fingers pan, as the middle button does
    pinch = middle();
    if (!resting && !pinched) press(0, false, event);
    resting = null;
    pinched = true;
    press(2, true, pinch);
  }
});
canvas.addEventListener("pointermove", (event) => {
  if (event.pointerType !== "touch") {
    if (event.buttons !== 0) moveCursor(placeOnPicture(event));
    return;
  }
  if (!fingers.has(event.pointerId)) return;
  fingers.set(event.pointerId, event);
  if (fingers.size === 1 && !pinched) {
    if (resting) {
      if (Math.hypot(event.clientX - resting.clientX, event.clientY - resting.clientY) < kTapPixels) return;
      press(0, true, resting);
      resting = null;
    }
    return moveCursor(placeOnPicture(event));
  }
  if (fingers.size !== 2 || pinchDue) return;
  pinchDue = true;
  requestAnimationFrame(() => {
    pinchDue = false;
    if (fingers.size !== 2) return;
    const now = middle();
    moveCursor(placeOnPicture(now));
    const notches = 6 * Math.log((now.apart || 1) / (pinch.apart || 1));
    if (Math.abs(notches) > 0.05) {
      send({ type: "wheel", notches: Math.max(-50, Math.min(50, notches)) });
      pinch = now;
    }
  });
});
function lift(event) {
  if (event.pointerType !== "touch") return press(kButtons[event.button] ?? 0, false, event);
  if (fingers.size === 2) press(2, false, middle());
  fingers.delete(event.pointerId);
  if (fingers.size > 0) return;
  const taps = resting && event.type === "pointerup";
  if (taps) press(0, true, resting);
  if (!pinched && (taps || !resting)) press(0, false, resting ?? event);
  resting = null;
  pinched = false;
}
canvas.addEventListener("pointerup", lift);
canvas.addEventListener("pointercancel", lift);
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  const unit = event.deltaMode === 0 ? kWheelPixels : 3;  // pixels or lines
  const notches = -(event.deltaY || event.deltaX) / unit;
  send({ type: "wheel", notches: Math.max(-50, Math.min(50, notches)), shift: event.shiftKey, ctrl: event.ctrlKey });
}, { passive: false });

function key(event, down) {
  if (event.metaKey || (event.target !== canvas && event.target !== document.body)) return;
  const browsers = ["Tab", "F5", "F11", "F12"];  // keys that stay the browser's
  const withControl = ["KeyZ", "KeyA", "KeyI", "KeyH", "KeyM", "KeyS", "Period", "Comma"];
  if (browsers.includes(event.key) || (event.ctrlKey && down && !withControl.includes(event.code))) return;
  if (event.code === "F1") {
    event.preventDefault();
    if (down) at("ask").click();
    return;
  }
  if (down) pressed.add(event.code);
  else if (!pressed.delete(event.code)) return;
  event.preventDefault();
  send({ type: "key", code: event.code, down, repeat: event.repeat, shift: event.shiftKey,
         ctrl: event.ctrlKey, alt: event.altKey });
}
addEventListener("keydown", (event) => key(event, true));
addEventListener("keyup", (event) => key(event, false));
addEventListener("blur", () => {
  pressed.clear();
  send({ type: "blur" });
});

const kMenus = [["choose", "panels"], ["menu", "commands"], ["ask", "help"]];  // button, what it opens
function toggle(button, panel) {
  const opens = panel.hidden;
  for (const [other, its] of kMenus) {
    at(its).hidden = true;
    at(other).setAttribute("aria-expanded", false);
  }
  panel.hidden = !opens;
  button.setAttribute("aria-expanded", opens);
}
for (const [button, its] of kMenus) at(button).onclick = () => toggle(at(button), at(its));
at("stop").onclick = () => send({ type: "stop" });
at("scene").onchange = () => send({ type: "scene", scene: Number(at("scene").value) });
at("mode").onchange = () => send({ type: "command", command: at("mode").value });
addEventListener("keydown", (event) => {
  if (event.key !== "Escape") return;
  for (const [button, its] of kMenus) if (!at(its).hidden) at(button).click();
  canvas.focus();
});

// The picture as it is on the canvas: at rest exactly the pixels of the renderer.
at("shot").onclick = () => {
  if (!shown) return;
  const view = sections.view, name = sections.scenes[view.scene].name;
  canvas.toBlob((file) => saveFile(file, name + "_" + view.mode + "_" + canvas.width + "x" + canvas.height + ".png"), "image/png");
};

at("open").onclick = () => at("file").click();
at("file").onchange = () => {
  openFile(at("file").files[0]);
  at("file").value = "";  // so that the same file can be opened again
};
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", (event) => {
  event.preventDefault();
  openFile(event.dataTransfer.files[0]);
});

new ResizeObserver(() => {
  send({ type: "resize", ...pictureSize() });
  showPanels((...names) => names.includes("crop") || names.includes("table"));
}).observe(canvas);
canvas.focus();
connect();
