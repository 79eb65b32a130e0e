// SPDX-License-Identifier: MIT
//
// The panels beside the picture: which are open, their frames, and their blocks. The server keeps
// which are open, as the window does, and says the blocks of each (src/app/viewer/panel_model); a
// block draws itself from its section by its kind.
"use strict";

// ---- helpers ------------------------------------------------------------------------------------
const lightPage = matchMedia("(prefers-color-scheme: light)");
lightPage.addEventListener("change", () => showPanels(() => true));

// The colour on dark, or on light pages.
const themed = (ink) => ink[lightPage.matches ? 1 : 0];

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

function showKeys(place, keys) {
  place.className = "keys";
  place.replaceChildren();
  for (const key of keys) make("span", key.text, place).style.setProperty("--of", themed(key.ink));
}

// A button on a row of a list.
function listButton(text, name, parent, action) {
  const button = make("button", text, parent);
  button.type = "button";
  button.ariaLabel = name;
  button.onclick = action;
  return button;
}

// ---- blocks -------------------------------------------------------------------------------------
// kind of a block -> its element, and a function that shows the section in it
const kBlocks = {
  text: ["p", (place, block) => {
    place.className = block.tone;
    setText(place, block.text);
  }],
  facts: ["dl", (place, block) => {
    place.className = "facts";
    place.replaceChildren();
    for (const [label, value] of block.facts) {
      make("dt", label, place);
      make("dd", value, place);
    }
  }],
  progress: ["progress", (place, block) => {
    place.value = block.share;
    place.ariaLabel = block.what;
  }],
  controls: ["div", (place, block) => showControls(place, block.rows)],
  keys: ["div", (place, block) => showKeys(place, block.keys)],
  colorbar: ["div", showColorBar],
  table: ["div", showTable],
  list: ["div", showList],
  items: ["div", showItems],
  chart: ["div", showChart],
  figure: ["div", showFigure],
  plot: ["div", showPlot],
};

// The bar of colours of a legend with its ticks.
function showColorBar(place, block) {
  place.replaceChildren();
  make("p", block.title, place).className = "faint";
  const bar = make("div", "", place);
  bar.className = "legend";
  bar.style.background = "linear-gradient(to right, " + block.colors.join(", ") + ")";
  const ticks = make("div", "", place);
  ticks.className = "ticks";
  for (const [share, text] of block.ticks) make("span", text, ticks).style.left = 100 * share + "%";
}

function showList(place, block) {
  place.className = "list scroll";
  const names = block.labels.join("\n");
  if (place.names !== names) {
    place.replaceChildren();
    block.labels.forEach((label, i) => {
      listButton(label, label, make("div", "", place), () => setControl(block.control, 0, i)).className = "name";
    });
  }
  place.names = names;
  [...place.querySelectorAll("button")].forEach((button, i) => button.setAttribute("aria-pressed", i === block.chosen));
}

function showItems(place, block) {
  place.className = "list";
  place.replaceChildren();
  block.rows.forEach((items, i) => {
    const line = make("div", "", place), name = items.find((item) => item.kind === "item").label;
    for (const item of items) makeItem(line, item, i, name);
  });
}
function makeItem(line, item, i, name) {
  if (item.kind === "item" || item.kind === "button") {
    const button = listButton(item.label, item.control + ": " + name, line, () => setControl(item.control, 0, i));
    if (item.kind === "item") button.className = "name";
  } else if (item.kind === "number") {
    const field = make("input", "", line);
    Object.assign(field, { type: "number", min: item.least, max: item.most, step: 0.1, value: Number(item.value.toFixed(2)), ariaLabel: item.label });
    field.onchange = () => setControl(item.control, Number(field.value) || item.least, i);
  } else {
    const label = make("label", "", line), box = make("input", "", label);
    box.type = "checkbox";
    box.checked = item.value !== 0;
    box.onchange = () => setControl(item.control, box.checked ? 1 : 0, i);
    label.append(item.label);
    label.title = item.help;
  }
}

function showFigure(place, block) {
  const [x0, y0] = block.low, width = block.high[0] - x0, height = block.high[1] - y0, unit = width / 320;
  const svg = makeSvg("svg", { viewBox: `${x0} ${y0} ${width} ${height}`, role: "img", "aria-label": block.name });
  svg.style.maxHeight = "20rem";
  for (const shape of block.shapes) {
    const color = themed(shape.ink), [[left, top], [right, bottom]] = shape.points;
    const style = shape.width > 0 ? { fill: "none", stroke: color, "stroke-width": shape.width * unit, opacity: shape.opacity }
                                  : { fill: color, opacity: shape.opacity };
    if (shape.box) svg.append(makeSvg("rect", { x: left, y: top, width: right - left, height: bottom - top, ...style }));
    else svg.append(makeSvg("polygon", { points: shape.points.map((point) => point.join(",")).join(" "), ...style }));
  }
  place.replaceChildren(svg);
}

function showPlot(place, block) {
  const width = 320, height = 50, most = 1.15 * Math.max(...block.values, 1e-9), last = block.values.length - 1 || 1;
  const svg = makeSvg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": block.caption });
  const points = block.values.map((value, i) => width * i / last + "," + height * (1 - value / most));
  svg.append(makeSvg("polyline", { points: points.join(" "), fill: "none", stroke: "var(--mark)" }));
  place.replaceChildren(svg);
  make("p", block.caption, place).className = "faint";
}

// Shows the blocks of a panel; the element of a block stays while the panel has it, so that the
// keyboard's place stays.
function showBlocks(body, names, changed) {
  const old = body.blocks || new Map();
  body.blocks = new Map();
  for (const name of names) {
    const block = sections[name], [tag, show] = kBlocks[block.kind];
    const place = old.get(name) || document.createElement(tag), isNew = !old.has(name);
    place.dataset.block = name;
    body.blocks.set(name, place);
    if (isNew || changed(name)) show(place, block);
  }
  const wanted = [...body.blocks.values()];
  if (body.childElementCount !== wanted.length || wanted.some((place, i) => body.children[i] !== place)) body.replaceChildren(...wanted);
}

// ---- frames of the panels -------------------------------------------------------------------------
function showPanels(changed) {
  if (!sections.panels) return;
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
  for (const { name, open } of sections.panels) {
    if (open && sections[name]) showBlocks(at("panel-" + name).lastElementChild, sections[name], changed);
  }
  if (changed("divider", "grid", "box", "awaited")) showOverlay();
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
      button.onclick = () => {
        togglePanel(panel);
        if (matchMedia("(max-width: 720px)").matches) at("choose").click();  // the list covers the picture
      };
    }
  }
  for (const panel of sections.panels)
    menu.querySelector(`[data-panel="${panel.name}"]`).setAttribute("aria-pressed", panel.open);
}
