// SPDX-License-Identifier: MIT
//
// The panel with the numbers of all modes. Its columns, words and digits come from the server
// (src/app/viewer/state/mode_table.h).
"use strict";

let tableOrder = null;  // {title, descending}; null: by mode

// The columns that fit: the highest rank goes first, as in the window.
function columnsThatFit(columns, letters) {
  const kept = columns.map((column, index) => ({ ...column, index }));
  const width = () => kept.reduce((sum, column) => sum + column.letters + 0.8, 0);
  while (kept.length > 2 && width() > letters) {
    const last = kept.reduce((worst, column) => (column.rank > worst.rank ? column : worst));
    kept.splice(kept.indexOf(last), 1);
  }
  return kept;
}

function orderedRows(table) {
  const rows = [...table.rows];
  const index = tableOrder ? table.columns.findIndex((column) => column.title === tableOrder.title) : -1;
  if (index < 0) return rows;
  const value = (row) => row.values[index] || 0, sign = tableOrder.descending ? -1 : 1;
  return rows.sort((a, b) => (value(a) === 0) - (value(b) === 0) || sign * (value(a) - value(b)));
}

function showTable(body) {
  const table = sections.table;
  if (!table) return;
  const parts = partsOf(body, { grid: "div", keys: "div", controls: "div", status: "p", facts: "dl", caveat: "p" });
  const letter = parseFloat(getComputedStyle(document.documentElement).fontSize);
  const columns = columnsThatFit(table.columns, (body.clientWidth || 300) / letter);
  const rows = orderedRows(table);
  const structure = JSON.stringify([columns.map((column) => column.title), rows.map((row) => row.mode), tableOrder, lightPage.matches]);
  if (body.structure !== structure) {
    body.structure = structure;
    makeTable(parts.grid, table, columns, rows, body);
  }
  const scale = {
    most: 1.05 * Math.max(...rows.map((row) => Math.max(row.fps, row.high)), 1e-9),
    longest: Math.max(...rows.map((row) => (row.stages ? row.stages.ms.reduce((a, b) => a + b, 0) : 0)), 1e-9),
  };
  const lines = parts.grid.querySelectorAll("tbody tr");
  rows.forEach((row, i) => {
    const here = row.mode === table.mode;
    lines[i].classList.toggle("here", here);
    columns.forEach((column, c) => showCell(lines[i].children[c], row, column, { ...scale, here }));
  });
  setText(parts.grid.querySelector("caption"), table.caption);
  parts.grid.setAttribute("aria-busy", table.measuring);
  parts.keys.className = "keys faint";
  parts.keys.replaceChildren();
  if (columns.some((column) => column.kind === "stages")) {
    for (const stage of sections.legend.stages) make("span", stage.name, parts.keys).style.setProperty("--of", themed(stage));
  }
  showControls(parts.controls, sections.controls.table || []);
  parts.status.className = table.waits ? "caution" : "faint";
  setText(parts.status, table.status);
  showFacts(parts.facts, table.facts);
  parts.caveat.className = "caution";
  setText(parts.caveat, table.caveat);
}

// The elements of the table; showCell() fills them. They stay while columns and order do, so that
// new numbers disturb neither a click nor the keyboard's place.
function makeTable(grid, table, columns, rows, body) {
  const focus = document.activeElement && document.activeElement.dataset.cell;
  const element = document.createElement("table");
  element.className = "numbers";
  make("caption", table.caption, element).className = "unseen";
  const head = make("tr", "", make("thead", "", element));
  for (const column of columns) {
    const cell = make("th", "", head);
    cell.scope = "col";
    if (column.kind === "stages") {
      cell.textContent = column.title;
      continue;
    }
    const button = make("button", column.title, cell);
    button.type = "button";
    button.title = "order by " + column.title;
    button.dataset.cell = "head " + column.title;
    const chosen = tableOrder && tableOrder.title === column.title;
    if (chosen) cell.ariaSort = tableOrder.descending ? "descending" : "ascending";
    button.onclick = () => {
      tableOrder = { title: column.title, descending: chosen ? !tableOrder.descending : column.kind === "bar" };
      showTable(body);
    };
  }
  const lines = make("tbody", "", element);
  for (const row of rows) {
    const line = make("tr", "", lines);
    for (const column of columns) makeCell(make("td", "", line), row, column);
  }
  grid.replaceChildren(element);
  if (focus) element.querySelector(`[data-cell="${CSS.escape(focus)}"]`)?.focus();
}

function makeCell(cell, row, column) {
  cell.dataset.column = column.title;
  if (column.kind === "mode") {
    const button = make("button", row.mode, cell);
    button.type = "button";
    button.dataset.cell = row.mode;
    button.onclick = () => send({ type: "command", command: row.mode });
  } else if (column.kind === "stages") {
    cell.className = "stages";
    const line = make("div", "", cell);
    for (const stage of sections.legend.stages) make("span", "", line).style.background = themed(stage);
  } else if (column.kind === "bar") {
    cell.className = "bar";
    for (const tag of ["i", "b"]) make(tag, "", cell).style.background = modeColor(row.mode);
    make("span", "", cell);
  }
}

function showCell(cell, row, column, scale) {
  const { text, faint } = row.cells[column.index];
  cell.classList.toggle("faint", faint);
  if (column.kind === "mode") {
    const button = cell.firstElementChild;
    button.title = sections.legend.modes[row.mode].summary + "\n" + row.trust;
    button.ariaCurrent = scale.here ? "true" : null;
  } else if (column.kind === "stages") {
    cell.title = row.stages ? row.stages.text : "";
    [...cell.firstElementChild.children].forEach((part, i) => {
      part.style.width = row.stages ? 100 * row.stages.ms[i] / scale.longest + "%" : 0;
    });
  } else if (column.kind === "bar") {
    const [bar, span, words] = cell.children;
    bar.style.width = 98 * row.fps / scale.most + "%";
    span.hidden = row.low <= 0;
    span.style.left = 98 * row.low / scale.most + "%";
    span.style.width = 98 * Math.max(0, row.high - row.low) / scale.most + "%";
    setText(words, text);
  } else {
    setText(cell, text);
  }
}
