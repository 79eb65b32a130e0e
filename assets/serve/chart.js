// SPDX-License-Identifier: MIT
//
// The panel of the zoom recorder with its chart. Curves, ticks and the values at the cursor come from
// the server (src/app/viewer/state/zoom_chart.h), as shares of the chart's width and height.
"use strict";

let readingAt = null;  // share of the chart's width under the pointer

function showRecorder(body) {
  const zoom = sections.recorder;
  if (!zoom) return;
  const parts = partsOf(body, { plan: "p", buttons: "div", chart: "div", keys: "div", reading: "p", label: "p", trust: "p", status: "p", start: "p", controls: "div" });
  setText(parts.plan, zoom.running ? zoom.status : zoom.plan);
  for (const name of ["chart", "keys", "reading"]) parts[name].hidden = !zoom.chart;
  if (zoom.chart) {
    parts.chart.replaceChildren(zoomChart(zoom.chart, parts.reading));
    parts.keys.className = "keys";
    parts.keys.replaceChildren();
    for (const curve of zoom.chart.curves) make("span", curve.mode, parts.keys).style.setProperty("--of", modeColor(curve.mode));
    showReading(zoom.chart, parts.reading);
  }
  for (const name of ["label", "trust", "status", "start"]) {
    parts[name].className = "faint";
    setText(parts[name], (name === "status" && zoom.running ? "" : zoom[name]) || "");
  }
  showControls(parts.controls, sections.controls.recorder || [], parts.buttons);
}

function showReading(chart, place) {
  place.className = "faint";
  const nearest = readingAt === null || chart.readings.length === 0 ? null
    : chart.readings.reduce((best, one) => (Math.abs(one.at - readingAt) < Math.abs(best.at - readingAt) ? one : best));
  setText(place, nearest ? nearest.title + ": " + nearest.rows.map(([mode, value]) => mode + " " + value).join(", ") : "");
  return nearest;
}

function zoomChart(chart, place) {
  const width = 340, height = 220, left = 46, right = 12, top = 20, bottom = 34;
  const x = (share) => left + share * (width - left - right), y = (share) => top + (1 - share) * (height - top - bottom);
  const points = (list) => list.map(([a, b]) => x(a).toFixed(1) + "," + y(b).toFixed(1)).join(" ");
  const svg = makeSvg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": chart.title + " against " + chart.axis });
  for (const [at, text] of chart.across) {
    svg.append(makeSvg("line", { x1: x(at), x2: x(at), y1: y(0), y2: y(1), stroke: "var(--line)" }));
    svg.append(svgText(text, { x: x(at), y: y(0) + 13, "text-anchor": "middle" }));
  }
  for (const [at, text] of chart.up) {
    svg.append(makeSvg("line", { x1: x(0), x2: x(1), y1: y(at), y2: y(at), stroke: "var(--line)" }));
    svg.append(svgText(text, { x: left - 5, y: y(at) + 4, "text-anchor": "end" }));
  }
  svg.append(svgText(chart.title, { x: left, y: 12 }));
  svg.append(svgText(chart.axis, { x: width - right, y: height - 5, "text-anchor": "end" }));
  for (const curve of chart.curves.filter((one) => one.band)) {
    const band = [...curve.points.map(([a, , low]) => [a, low]), ...curve.points.map(([a, , , high]) => [a, high]).reverse()];
    svg.append(makeSvg("polygon", { points: points(band), fill: modeColor(curve.mode), opacity: 0.12 }));
  }
  for (const curve of chart.curves) {
    // quadbox-naive lists the same pairs as quadbox: its wider curve stays visible under the other.
    svg.append(makeSvg("polyline", { points: points(curve.points), fill: "none", stroke: modeColor(curve.mode), "stroke-width": curve.mode === "quadbox-naive" ? 3.5 : 2, "stroke-dasharray": curve.dashed ? "6 4" : "none" }));
    if (!curve.dashed && !curve.plain) for (const [a, b] of curve.points) svg.append(makeSvg("circle", { cx: x(a), cy: y(b), r: 2.5, fill: modeColor(curve.mode) }));
  }
  const line = makeSvg("line", { y1: y(0), y2: y(1), stroke: "var(--faint)", visibility: "hidden" });
  svg.append(line);
  const mark = () => {
    const nearest = showReading(chart, place);
    line.setAttribute("visibility", nearest ? "visible" : "hidden");
    if (!nearest) return;
    line.setAttribute("x1", x(nearest.at));
    line.setAttribute("x2", x(nearest.at));
  };
  svg.onpointermove = (event) => {
    const box = svg.getBoundingClientRect();
    readingAt = Math.min(1, Math.max(0, ((event.clientX - box.left) * width / box.width - left) / (width - left - right)));
    mark();
  };
  svg.onpointerleave = () => {
    readingAt = null;
    mark();
  };
  mark();
  return svg;
}
