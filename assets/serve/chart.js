// SPDX-License-Identifier: MIT
//
// Charts: curves, columns, ticks and the values at the cursor come from the server
// (src/app/viewer/panel_model/panel_model.h), as shares of the chart's width and height.
"use strict";

function showChart(place, chart) {
  if (!place.reading) {
    place.svg = make("div", "", place);
    place.reading = make("p", "", place);
    place.reading.className = "faint";
    place.at = null;  // share of the chart's width under the pointer
  }
  place.svg.replaceChildren(chartSvg(chart, place));
}

// The values at the pointer; null without a pointer.
function showReading(chart, place) {
  const nearest = place.at === null || chart.readings.length === 0 ? null
    : chart.readings.reduce((best, one) => (Math.abs(one.at - place.at) < Math.abs(best.at - place.at) ? one : best));
  setText(place.reading, nearest ? nearest.title + ": " + nearest.rows.map(([name, value]) => name + " " + value).join(", ") : "");
  return nearest;
}

function chartSvg(chart, place) {
  const width = 340, height = 16 * chart.letters, left = chart.up.some(([, text]) => text.length > 2) ? 46 : 14;
  const right = 12, top = chart.title ? 20 : 6, bottom = chart.across.length > 0 ? 34 : 18;
  const x = (share) => left + share * (width - left - right), y = (share) => top + (1 - share) * (height - top - bottom);
  const points = (list) => list.map(([a, b]) => x(a).toFixed(1) + "," + y(b).toFixed(1)).join(" ");
  const svg = makeSvg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": chart.title ? chart.title + " against " + chart.axis : chart.axis });
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
  for (const [from, to, share, color] of chart.columns)
    svg.append(makeSvg("rect", { x: x(from), y: y(share), width: Math.max(1, x(to) - x(from)), height: y(0) - y(share), fill: color, opacity: 0.7 }));
  chart.curves.forEach((curve, number) => {
    const aside = 2 * (number - (chart.curves.length - 1) / 2);
    if (curve.bars) for (const [a, , low, high] of curve.points)
      svg.append(makeSvg("line", { x1: x(a) + aside, x2: x(a) + aside, y1: y(low), y2: y(high), stroke: themed(curve.ink), opacity: 0.8 }));
  });
  for (const curve of chart.curves) {
    const color = themed(curve.ink);
    svg.append(makeSvg("polyline", { points: points(curve.points), fill: "none", stroke: color, "stroke-width": curve.width, "stroke-dasharray": curve.dashed ? "6 4" : "none" }));
    if (curve.marked) for (const [a, b, , , noisy] of curve.points) {
      svg.append(makeSvg("circle", { cx: x(a), cy: y(b), r: 2.5, fill: color }));
      if (noisy) svg.append(makeSvg("circle", { cx: x(a), cy: y(b), r: 5, fill: "none", stroke: color }));
    }
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
    place.at = Math.min(1, Math.max(0, ((event.clientX - box.left) * width / box.width - left) / (width - left - right)));
    mark();
  };
  svg.onpointerleave = () => {
    place.at = null;
    mark();
  };
  mark();
  return svg;
}
