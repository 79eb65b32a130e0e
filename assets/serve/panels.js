// SPDX-License-Identifier: MIT
//
// The panels beside the picture: which are open, their frames, and helpers of what they draw. The
// server keeps which are open, as the window does; a panel draws itself from its section.
"use strict";

// name of a panel -> draws its body, and the sections that it needs
const kPanelBodies = {
  table: { show: showTable, needs: ["table", "controls", "legend"] },
  split: { show: showSplit, needs: ["split", "grid", "controls"] },
  inspector: { show: showInspector, needs: ["inspector", "legend"] },
  recorder: { show: showRecorder, needs: ["recorder", "controls", "legend"] },
  crop: { show: showCrop, needs: ["crop", "controls"] },
  path: { show: showPath, needs: ["path", "controls"] },
  settings: { show: showSettings, needs: ["facts", "controls"] },
  training: { show: showTraining, needs: ["training", "controls"] },
};

// ---- helpers ------------------------------------------------------------------------------------
const lightPage = matchMedia("(prefers-color-scheme: light)");
lightPage.addEventListener("change", () => showPanels(() => true));

function themed(colors) {
  return lightPage.matches ? colors.light : colors.dark;
}
function modeColor(mode, onPicture = false) {
  const colors = sections.legend && sections.legend.modes[mode];
  if (!colors) return "gray";
  return onPicture ? colors.dark : themed(colors);
}

function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

function makeSvg(tag, attributes) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}
function svgText(text, attributes) {
  const made = makeSvg("text", attributes);
  made.textContent = text;
  return made;
}

// The parts of a panel's body by name; they are made once, in this order.
function partsOf(body, tags) {
  if (!body.parts) {
    body.parts = {};
    for (const [name, tag] of Object.entries(tags)) {
      body.parts[name] = make(tag, "", body);
      body.parts[name].dataset.part = name;
    }
  }
  return body.parts;
}

function showFacts(place, facts) {
  place.className = "facts";
  place.replaceChildren();
  for (const [label, value] of facts) {
    make("dt", label, place);
    make("dd", value, place);
  }
}

// The bar of colours of a legend with its ticks; nothing without one.
function showLegend(place, legend) {
  place.replaceChildren();
  if (!legend) return;
  make("p", legend.title, place).className = "faint";
  const bar = make("div", "", place);
  bar.className = "legend";
  bar.style.background = "linear-gradient(to right, " + legend.colors.join(", ") + ")";
  const ticks = make("div", "", place);
  ticks.className = "ticks";
  for (const [share, text] of legend.ticks) make("span", text, ticks).style.left = 100 * share + "%";
}

// ---- the panels that need no file of their own ----------------------------------------------------
function showSplit(body) {
  const parts = partsOf(body, { controls: "div", legend: "div", words: "p", facts: "dl" });
  showControls(parts.controls, sections.controls.split || []);
  const split = sections.split;
  showLegend(parts.legend, split && split.legend);
  parts.words.className = "faint";
  setText(parts.words, split ? split.words : "");
  showFacts(parts.facts, split ? split.facts : []);
}

function showCrop(body) {
  const parts = partsOf(body, { words: "p", controls: "div" });
  setText(parts.words, sections.crop ? sections.crop.words : "");
  showControls(parts.controls, sections.controls.crop || []);
}

function showSettings(body) {
  const parts = partsOf(body, { facts: "dl", controls: "div" });
  showFacts(parts.facts, sections.facts || []);
  showControls(parts.controls, sections.controls.settings || []);
}

function showTraining(body) {
  const training = sections.training;
  if (!training) return;
  const parts = partsOf(body, { share: "progress", controls: "div", facts: "dl", chart: "div", reading: "p" });
  parts.share.value = training.share;
  parts.share.ariaLabel = "Iterations done";
  showControls(parts.controls, sections.controls.training || []);
  showFacts(parts.facts, training.facts);
  if (training.chart) parts.chart.replaceChildren(zoomChart(training.chart, parts.reading));
}

function showPath(body) {
  const path = sections.path;
  if (!path) return;
  const parts = partsOf(body, { cameras: "div", title: "p", keyframes: "div", controls: "div" });
  showCameras(parts.cameras, path);
  parts.title.className = "faint";
  setText(parts.title, `Path: ${path.keyframes.length} keyframes`);
  showKeyframes(parts.keyframes, path.keyframes);
  showControls(parts.controls, sections.controls.path || []);
}

// A button on a row of a list.
function listButton(text, name, parent, action) {
  const button = make("button", text, parent);
  button.type = "button";
  button.ariaLabel = name;
  button.onclick = action;
  return button;
}

function showCameras(place, path) {
  place.className = "list scroll";
  const names = path.cameras.join("\n");
  if (place.names !== names) {
    place.replaceChildren();
    path.cameras.forEach((label, i) => {
      const button = listButton(label, label, make("div", "", place), () => setControl("camera", 0, i));
      button.className = "name";
    });
    if (path.cameras.length === 0) setText(place, "This scene came without cameras.");
  }
  place.names = names;
  [...place.querySelectorAll("button")].forEach((button, i) => button.setAttribute("aria-pressed", i === path.camera));
}

function showKeyframes(place, keyframes) {
  place.className = "list";
  const known = JSON.stringify(keyframes);
  if (place.known === known) return;
  place.known = known;
  place.replaceChildren();
  keyframes.forEach((keyframe, i) => {
    const line = make("div", "", place);
    listButton(keyframe.label, "Go to keyframe " + keyframe.label, line, () => setControl("keyframe", 0, i)).className = "name";
    if (i > 0) {
      const seconds = make("input", "", line);
      Object.assign(seconds, { type: "number", min: 0.05, max: 3600, step: 0.1, value: Number(keyframe.seconds.toFixed(2)), ariaLabel: "Seconds after the keyframe before" });
      seconds.onchange = () => setControl("seconds", Number(seconds.value) || 0.05, i);
    }
    const label = make("label", "", line), ease = make("input", "", label);
    ease.type = "checkbox";
    ease.checked = keyframe.ease;
    ease.onchange = () => setControl("ease", ease.checked ? 1 : 0, i);
    label.append("ease");
    label.title = "the camera slows down to a stop here";
    listButton("\u00d7", "Remove keyframe " + keyframe.label, line, () => setControl("remove keyframe", 0, i));
  });
}

// ---- frames of the panels -------------------------------------------------------------------------
function showPanels(changed) {
  if (!sections.panels || !sections.legend) return;
  const side = at("side");
  if (changed("panels")) {
    showPanelMenu();
    for (const panel of sections.panels) {
      const frame = at("panel-" + panel.name) || makePanel(side, panel);
      const opens = panel.open && frame.hidden;
      frame.hidden = !panel.open;
      if (opens) frame.scrollIntoView({ block: "nearest" });
    }
    side.hidden = !sections.panels.some((panel) => panel.open);
  }
  for (const panel of sections.panels) {
    const { show, needs } = kPanelBodies[panel.name];
    if (panel.open && changed("panels", ...needs)) show(at("panel-" + panel.name).lastElementChild);
  }
  if (changed("split", "grid", "crop", "legend")) showOverlay();
  if (changed("job")) showJob();
}

function togglePanel(panel) {
  send({ type: "command", command: panel.title });
}

function makePanel(side, panel) {
  const frame = make("section", "", side);
  frame.className = "panel";
  frame.id = "panel-" + panel.name;
  frame.hidden = true;
  frame.setAttribute("aria-labelledby", "title-" + panel.name);
  const head = make("header", "", frame);
  make("h2", panel.title, head).id = "title-" + panel.name;
  const close = make("button", "\u00d7", head);
  close.type = "button";
  close.title = `close (${panel.key})`;
  close.ariaLabel = "Close " + panel.title;
  close.onclick = () => {
    togglePanel(panel);
    canvas.focus();
  };
  make("div", "", frame);
  return frame;
}

function showPanelMenu() {
  const menu = at("panels");
  if (menu.childElementCount === 0) {
    for (const panel of sections.panels) {
      const button = make("button", panel.title, menu);
      button.type = "button";
      button.dataset.panel = panel.name;
      make("kbd", panel.key, button);
      button.onclick = () => togglePanel(panel);
    }
  }
  for (const panel of sections.panels)
    menu.querySelector(`[data-panel="${panel.name}"]`).setAttribute("aria-pressed", panel.open);
}
