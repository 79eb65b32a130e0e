// SPDX-License-Identifier: MIT
//
// Draws the controls of a panel from the rows that the server sends (src/app/viewer/commands/controls.h),
// and sends what the visitor chooses.
"use strict";

const kSteps = 1000;        // of a slider
const kOwnMilliseconds = 700;  // a control that the visitor moves is not moved by the server

const waitingValues = new Map();  // of controls, until the next refresh of the screen

function setControl(control, value, index = 0) {
  const first = waitingValues.size === 0;
  waitingValues.set(control + "\n" + index, { type: "set", control, value, index });
  if (first) requestAnimationFrame(flushControls);
}
function flushControls() {
  for (const message of waitingValues.values()) send(message);
  waitingValues.clear();
}

function numberText(row, value) {
  return value.toFixed(row.step === 1 ? 0 : row.decimals) + row.unit;
}

// Between the value of a number and the place of its slider, 0 to kSteps.
function placeOf(row, value) {
  const share = row.log ? Math.log(value / row.least) / Math.log(row.most / row.least)
                        : (value - row.least) / (row.most - row.least || 1);
  return Math.round(kSteps * Math.min(1, Math.max(0, share)));
}
function valueAt(row, place) {
  const share = place / kSteps;
  const value = row.log ? row.least * (row.most / row.least) ** share : row.least + share * (row.most - row.least);
  const stepped = row.step > 0 ? row.least + row.step * Math.round((value - row.least) / row.step) : Number(value.toPrecision(4));
  return Math.min(row.most, Math.max(row.least, stepped));
}

// One entry per kind: make(element) returns the input, its listeners, and how it shows a row.
const kControlKinds = {
  toggle: (place, get) => {
    const input = make("input", "", place);
    input.type = "checkbox";
    input.onchange = () => setControl(get().name, input.checked ? 1 : 0);
    return { input, show: (row) => { input.checked = row.value !== 0; } };
  },
  choice: (place, get) => {
    const input = make("select", "", place);
    input.onchange = () => setControl(get().name, input.selectedIndex);
    let choices = "";
    return { input, show: (row) => {
      if (choices !== row.choices.join("\n")) fill(input, row.choices.map((text, i) => [i, text]));
      choices = row.choices.join("\n");
      input.selectedIndex = row.value;
    } };
  },
  color: (place, get) => {
    const input = make("input", "", place);
    input.type = "color";
    input.oninput = () => setControl(get().name, parseInt(input.value.slice(1), 16));
    return { input, show: (row) => { input.value = "#" + row.value.toString(16).padStart(6, "0"); } };
  },
  typed: (place, get) => {
    const input = make("input", "", place);
    input.type = "number";
    input.onchange = () => {
      const row = get(), value = Math.min(row.most, Math.max(row.least, Number(input.value) || 0));
      setControl(row.name, row.step === 1 ? Math.round(value) : value);
    };
    return { input, show: (row) => {
      Object.assign(input, { min: row.least, max: row.most, step: row.step || "any", value: Number(row.value.toPrecision(5)) });
    } };
  },
  slider: (place, get) => {
    const input = make("input", "", place), output = make("output", "", place);
    input.type = "range";
    input.oninput = () => {
      const row = get(), value = row.step === 1 ? Number(input.value) : valueAt(row, Number(input.value));
      output.textContent = numberText(row, value);
      input.setAttribute("aria-valuetext", output.textContent);
      setControl(row.name, value);
    };
    return { input, show: (row) => {
      const whole = row.step === 1;  // the keys of a slider then make one step
      input.min = whole ? row.least : 0;
      input.max = whole ? row.most : kSteps;
      input.value = whole ? row.value : placeOf(row, row.value);
      output.textContent = numberText(row, row.value);
      input.setAttribute("aria-valuetext", output.textContent);
    } };
  },
};

function kindOf(row) {
  if (row.kind !== "number") return row.kind;
  return row.typed ? "typed" : "slider";
}

// Shows the rows in `parent`; elements stay while their row does, so that the keyboard's place stays.
function showControls(parent, rows) {
  if (!parent.controls) {
    parent.controls = new Map();
    parent.grid = make("div", "", parent);
    parent.grid.className = "controls";
    parent.line = make("div", "", parent);
    parent.line.className = "buttons";
  }
  const known = parent.controls, names = new Set(rows.map((row) => row.name));
  for (const [name, control] of known) {
    if (names.has(name) && control.kind === kindOf(rows.find((row) => row.name === name))) continue;
    for (const element of control.elements) element.remove();
    known.delete(name);
  }
  for (const row of rows) {
    const control = known.get(row.name) || makeControl(parent, row);
    known.set(row.name, control);
    control.row = row;
    if (Date.now() - control.touched > kOwnMilliseconds || document.activeElement !== control.input) control.show(row);
  }
  // In the order of the rows.
  for (const [place, isButton] of [[parent.grid, false], [parent.line, true]]) {
    const wanted = rows.filter((row) => (row.kind === "button") === isButton).flatMap((row) => known.get(row.name).elements);
    if (wanted.some((element, i) => place.children[i] !== element)) place.replaceChildren(...wanted);
    place.hidden = wanted.length === 0;
  }
}

function makeControl(parent, row) {
  const control = { row, kind: kindOf(row), touched: 0 };
  if (row.kind === "button") {
    const button = document.createElement("button");
    button.type = "button";
    button.onclick = () => setControl(control.row.name, 0);
    control.show = (now) => {
      button.textContent = now.label;
      button.title = now.help;
      button.disabled = !now.enabled;
    };
    return Object.assign(control, { input: button, elements: [button] });
  }
  const label = document.createElement("label"), place = document.createElement("div");
  place.className = "value";
  label.textContent = row.label;
  label.title = row.help;
  const { input, show } = kControlKinds[control.kind](place, () => control.row);
  input.id = "control-" + row.name.replace(/[^A-Za-z0-9]+/g, "-");
  input.dataset.control = row.name;
  label.htmlFor = input.id;
  input.title = row.help;
  input.addEventListener("input", () => { control.touched = Date.now(); });
  const showRow = (now) => {
    input.disabled = !now.enabled;
    show(now);
  };
  return Object.assign(control, { input, show: showRow, elements: [label, place] });
}
