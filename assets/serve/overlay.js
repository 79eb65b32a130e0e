// SPDX-License-Identifier: MIT
//
// What is drawn over the picture: the divider and the names of a split, the labels of all modes side
// by side, the box of the crop with its handles, shapes that select, rulers. Its colours fit the
// picture, not the page.
"use strict";

function plate(text, at, parent) {
  const made = make("div", text, parent);
  made.className = "plate";
  Object.assign(made.style, at);
  return made;
}

function showOverlay() {
  const place = at("overlay"), split = sections.divider, grid = sections.grid;
  for (const old of [...place.children]) if (!old.dataset.drag) old.remove();
  showDivider(split && split.sides && !grid ? split : null);
  if (split && !grid && split.names) {
    // At the top, below the legend of a heat map. Messages are at the bottom.
    const top = sections.view && sections.view.heatmap ? "19%" : "0.7rem";
    if (split.sides) {
      plate(split.names[0], { right: 100 - 100 * split.divider + "%", top, marginRight: "0.7rem" }, place);
      plate(split.names[1], { left: 100 * split.divider + "%", top, marginLeft: "0.7rem" }, place);
    } else if (split.view === "one at a time") {
      plate(split.names[0], { left: "50%", top, transform: "translateX(-50%)" }, place);
    }
  }
  if (grid) showGrid(place, grid);
  showBox(place, grid ? null : sections.box);
  const awaited = sections.awaited;
  if (awaited) plate(awaited.text, { top: "0.7rem", left: "0.7rem" }, place).classList.toggle("covers", awaited.covers);
}

// The divider stays while it is dragged.
let dividerDrag = false, dividerTouched = 0;
function showDivider(split) {
  const place = at("overlay");
  let divider = place.querySelector(".divider");
  if (!split) {
    divider?.remove();
    return;
  }
  if (!divider) {
    divider = make("button", "", place);
    divider.type = "button";
    divider.className = "divider";
    divider.dataset.drag = "divider";
    divider.setAttribute("role", "slider");
    divider.setAttribute("aria-label", "Divider of the split");
    divider.setAttribute("aria-valuemin", 0);
    divider.setAttribute("aria-valuemax", 100);
    divider.onpointerdown = (event) => {
      dividerDrag = true;
      divider.setPointerCapture(event.pointerId);
    };
    divider.onpointermove = (event) => {
      if (!dividerDrag) return;
      const box = canvas.getBoundingClientRect();
      moveDivider(divider, (event.clientX - box.left) / box.width);
    };
    divider.onpointerup = divider.onpointercancel = () => { dividerDrag = false; };
    divider.onkeydown = (event) => {
      const by = { ArrowLeft: -0.02, ArrowRight: 0.02, PageDown: -0.1, PageUp: 0.1 }[event.key];
      if (!by) return;
      event.preventDefault();
      moveDivider(divider, Number(divider.dataset.at) + by);
    };
  }
  if (!dividerDrag && Date.now() - dividerTouched > kOwnMilliseconds) placeDivider(divider, split.divider);
}
function placeDivider(divider, share) {
  divider.style.left = 100 * share + "%";
  divider.dataset.at = share;
  divider.setAttribute("aria-valuenow", Math.round(100 * share));
}
function moveDivider(divider, share) {
  dividerTouched = Date.now();
  placeDivider(divider, Math.min(1, Math.max(0, share)));
  setControl("divider", Number(divider.dataset.at));
}

function showGrid(place, grid) {
  for (const label of grid.labels) {
    const cell = make("div", "", place);
    cell.className = "cell";
    cell.classList.toggle("here", label.here);
    const percent = (share) => 100 * share + "%";
    Object.assign(cell.style, { left: percent(label.x), top: percent(label.y), width: percent(grid.side), height: percent(grid.side), outlineColor: label.color });
    const words = make("p", "", cell);
    words.style.maxWidth = percent(1 / (grid.columns * grid.side));
    make("b", label.mode, words).style.color = label.color;
    words.append(label.text);
  }
}

let handleDrag = null;  // number of the face
function showBox(place, shape) {
  const drawing = at("drawing");
  const box = canvas.getBoundingClientRect();
  drawing.replaceChildren();
  for (const [from, to] of (shape && shape.lines) || []) {
    const ends = { x1: from[0] * box.width, y1: from[1] * box.height, x2: to[0] * box.width, y2: to[1] * box.height };
    drawing.append(makeSvg("line", { ...ends, stroke: "#000a", "stroke-width": 3 }), makeSvg("line", { ...ends, stroke: "#56b4e9", "stroke-width": 1.5 }));
  }
  for (const [spot, text] of (shape && shape.labels) || [])
    plate(text, { left: 100 * spot[0] + "%", top: 100 * spot[1] + "%", transform: "translate(-50%, -140%)" }, place);
  const faces = ["x low", "x high", "y low", "y high", "z low", "z high"];
  const handles = (shape && shape.handles) || [];
  for (let face = 0; face < faces.length; ++face) {
    const spot = handles[face];
    let handle = place.querySelector(`[data-drag="face ${face}"]`);
    if (!spot || spot[0] < 0 || spot[0] > 1 || spot[1] < 0 || spot[1] > 1) {
      if (handleDrag !== face) handle?.remove();
      continue;
    }
    if (!handle) {
      handle = make("button", "", place);
      handle.type = "button";
      handle.className = "handle";
      handle.tabIndex = -1;  // the panel's numbers do the same by keyboard
      handle.dataset.drag = "face " + face;
      handle.setAttribute("aria-label", "Face of the box: " + faces[face]);
      handle.onpointerdown = (event) => {
        handleDrag = face;
        handle.setPointerCapture(event.pointerId);
      };
      handle.onpointermove = (event) => {
        if (handleDrag === face) moveHandle(face, placeOnPicture(event));
      };
      handle.onpointerup = handle.onpointercancel = () => { handleDrag = null; };
    }
    handle.style.left = 100 * spot[0] + "%";
    handle.style.top = 100 * spot[1] + "%";
  }
}

let handleMove = null;  // until the next refresh of the screen
function moveHandle(face, to) {
  if (!handleMove) requestAnimationFrame(() => {
    send({ type: "handle", ...handleMove });
    handleMove = null;
  });
  handleMove = { face, ...to };
}
