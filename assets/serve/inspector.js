// SPDX-License-Identifier: MIT
//
// The panel with the Gaussians of the clicked pixel, and the shape, boxes and tiles of one of them.
"use strict";

function showInspector(body) {
  const found = sections.inspector;
  if (!found) return;
  const parts = partsOf(body, { words: "p", note: "p", light: "div", rows: "div", more: "p", figure: "div", keys: "div", meaning: "p", counts: "div" });
  setText(parts.words, found.words);
  setText(parts.note, found.note || "");
  parts.note.className = "caution";
  const has = Boolean(found.rows);
  for (const name of ["light", "rows", "more"]) parts[name].hidden = !has;
  const construction = has ? found.construction : null;
  for (const name of ["figure", "keys", "meaning", "counts"]) parts[name].hidden = !construction;
  if (!has) return;
  parts.light.replaceChildren(transmittancePlot(found));
  showContributions(parts.rows, found);
  parts.more.className = "faint";
  setText(parts.more, found.more > 0 ? `and ${found.more} more behind them` : "");
  if (!construction) return;
  parts.figure.replaceChildren(constructionFigure(construction, found.pixel));
  parts.keys.className = "keys faint";
  parts.keys.replaceChildren();
  make("span", "alpha = 1/255", parts.keys).style.setProperty("--of", "#D55E00");
  for (const { mode } of construction.boxes) make("span", mode, parts.keys).style.setProperty("--of", modeColor(mode));
  parts.meaning.className = "faint";
  setText(parts.meaning, construction.words);
  const table = document.createElement("table");
  table.className = "numbers";
  const head = make("tr", "", make("thead", "", table));
  for (const title of construction.columns) make("th", title, head).scope = "col";
  const lines = make("tbody", "", table);
  for (const row of construction.counts) {
    const line = make("tr", "", lines);
    line.classList.toggle("here", row.here);
    make("td", row.mode, line);
    for (const count of row.counts) make("td", String(count), line);
  }
  parts.counts.replaceChildren(table);
}

function showContributions(place, found) {
  const focus = document.activeElement && document.activeElement.dataset.gaussian;
  const top = place.scrollTop;
  place.className = "scroll";
  const table = document.createElement("table");
  table.className = "numbers";
  const head = make("tr", "", make("thead", "", table));
  for (const title of found.columns) make("th", title, head).scope = "col";
  const lines = make("tbody", "", table);
  for (const row of found.rows) {
    const line = make("tr", "", lines);
    line.classList.toggle("here", row.picked);
    const button = make("button", row.label, make("td", "", line));
    button.type = "button";
    button.dataset.gaussian = row.gaussian;
    button.ariaCurrent = row.picked ? "true" : null;
    button.onclick = () => setControl("Gaussian", 0, row.gaussian);
    for (const text of row.cells) make("td", text, line);
    const swatch = make("span", "", make("td", "", line));
    swatch.className = "swatch";
    swatch.style.background = row.color;
    swatch.title = row.color;
  }
  place.replaceChildren(table);
  place.scrollTop = top;
  if (focus) table.querySelector(`[data-gaussian="${CSS.escape(focus)}"]`)?.focus();
}

// A step for each Gaussian, in its colour.
function transmittancePlot(found) {
  const rows = found.rows.filter((row) => !row.stops);
  const width = 320, height = 90, left = 14, bottom = 16;
  const svg = makeSvg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": found.title });
  const x = (i) => left + (width - left - 4) * i / Math.max(rows.length, 1);
  const y = (value) => 4 + (height - bottom - 8) * (1 - value);
  rows.forEach((row, i) => {
    svg.append(makeSvg("rect", { x: x(i), y: y(row.transmittance), width: Math.max(1, x(i + 1) - x(i)), height: y(0) - y(row.transmittance), fill: row.color, opacity: 0.7 }));
  });
  const steps = rows.flatMap((row, i) => {
    const after = i + 1 < rows.length ? rows[i + 1].transmittance : found.behind;
    return [[x(i), y(row.transmittance)], [x(i + 1), y(row.transmittance)], [x(i + 1), y(after)]];
  });
  svg.append(makeSvg("polyline", { points: steps.map((point) => point.join(",")).join(" "), fill: "none", stroke: "var(--text)", "stroke-width": 1.2 }));
  for (const value of [0, 1]) {
    svg.append(makeSvg("line", { x1: left, x2: width - 4, y1: y(value), y2: y(value), stroke: "var(--line)" }));
    svg.append(svgText(String(value), { x: 2, y: y(value) + 4 }));
  }
  svg.append(svgText(found.title, { x: left, y: height - 3 }));
  return svg;
}

// Pixels of the frame; tiles are strong where a pixel uses the pair.
function constructionFigure(figure, pixel) {
  const [x0, y0, x1, y1] = figure.window, unit = (x1 - x0) / 320;
  const svg = makeSvg("svg", { viewBox: `${x0} ${y0} ${x1 - x0} ${y1 - y0}`, role: "img", "aria-label": figure.words });
  svg.style.maxHeight = "20rem";
  const box = ([left, top, right, bottom], more) => svg.append(makeSvg("rect", { x: left, y: top, width: right - left, height: bottom - top, ...more }));
  const opacities = [0.55, 0.3, 0.14];
  for (const [tile, use] of figure.tiles) box(tile, { fill: modeColor(figure.mode), opacity: opacities[use] });
  for (let x = Math.ceil(x0 / figure.side) * figure.side; x <= x1 && (x1 - x0) / figure.side < 200; x += figure.side)
    svg.append(makeSvg("line", { x1: x, x2: x, y1: y0, y2: y1, stroke: "var(--line)", "stroke-width": unit }));
  for (let y = Math.ceil(y0 / figure.side) * figure.side; y <= y1 && (y1 - y0) / figure.side < 200; y += figure.side)
    svg.append(makeSvg("line", { x1: x0, x2: x1, y1: y, y2: y, stroke: "var(--line)", "stroke-width": unit }));
  for (const { mode, boxes } of figure.boxes) {
    for (const one of boxes) box(one, { fill: "none", stroke: modeColor(mode), "stroke-width": 1.5 * unit });
  }
  if (figure.ellipse.length > 0)
    svg.append(makeSvg("polygon", { points: figure.ellipse.map((point) => point.join(",")).join(" "), fill: "none", stroke: "#D55E00", "stroke-width": 2 * unit }));
  const half = Math.max(0.5, 4 * unit);
  box([pixel[0] - half, pixel[1] - half, pixel[0] + half, pixel[1] + half], { fill: "none", stroke: "#00c88c", "stroke-width": 2 * unit });
  return svg;
}
