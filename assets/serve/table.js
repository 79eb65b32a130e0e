// SPDX-License-Identifier: MIT
//
// Tables of panels. Columns, words and digits come from the server
// (src/app/viewer/panel_model/panel_model.h).
"use strict";

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

// `order`: {title, descending}; undefined: as the server sent them.
function orderedRows(table, order) {
  const rows = [...table.rows];
  const index = order ? table.columns.findIndex((column) => column.title === order.title) : -1;
  if (index < 0) return rows;
  const value = (row) => row.cells[index].value, sign = order.descending ? -1 : 1;
  return rows.sort((a, b) => (value(a) === 0) - (value(b) === 0) || sign * (value(a) - value(b)));
}

function showTable(place, table) {
  if (!place.grid) {
    place.grid = make("div", "", place);
    place.keys = make("div", "", place);
  }
  place.grid.className = table.scrolls ? "scroll" : "";
  const letter = parseFloat(getComputedStyle(document.documentElement).fontSize);
  const columns = columnsThatFit(table.columns, (place.clientWidth || at("side").clientWidth || 300) / letter);
  const rows = orderedRows(table, place.order);
  const structure = JSON.stringify([columns.map((column) => column.title), rows.map((row) => row.cells[0].text), place.order, lightPage.matches]);
  if (place.structure !== structure) {
    place.structure = structure;
    makeTable(place, table, columns, rows);
  }
  // Bars leave room for the numbers: a number on a bar has too little contrast.
  const numbers = rows.flatMap((row) => row.cells.filter((cell) => cell.bar)).map((cell) => cell.text.length);
  place.grid.style.setProperty("--numbers", Math.max(0, ...numbers) + 1 + "ch");
  const lines = place.grid.querySelectorAll("tbody tr");
  rows.forEach((row, i) => {
    lines[i].classList.toggle("here", row.here);
    columns.forEach((column, c) => showCell(lines[i].children[c], row, row.cells[column.index], table));
  });
  if (place.refocus) place.grid.querySelector(`[data-cell="${CSS.escape(place.refocus)}"]`)?.focus();
  place.refocus = null;
  setText(place.grid.querySelector("caption"), table.caption);
  place.grid.setAttribute("aria-busy", table.busy);
  showKeys(place.keys, columns.at(-1).index + 1 === table.columns.length ? table.keys : []);
  place.keys.classList.add("faint");
}

// The elements of the table; showCell() fills them. They stay while columns and order do, so that
// new numbers disturb neither a click nor the keyboard's place.
function makeTable(place, table, columns, rows) {
  const focus = document.activeElement && document.activeElement.dataset.cell;
  const element = document.createElement("table");
  element.className = "numbers";
  make("caption", table.caption, element).className = "unseen";
  const head = table.head ? make("tr", "", make("thead", "", element)) : null;
  for (const column of head ? columns : []) {
    const cell = make("th", "", head);
    cell.scope = "col";
    if (column.orders) makeOrder(cell, column, place);
    else cell.textContent = column.title;
  }
  const lines = make("tbody", "", element);
  for (const row of rows) {
    const line = make("tr", "", lines);
    for (const column of columns) make("td", "", line).dataset.column = column.title;
  }
  place.grid.replaceChildren(element);
  if (focus) place.refocus = focus;
}

// The button in a head that orders the rows by its column.
function makeOrder(cell, column, place) {
  const button = make("button", column.title, cell);
  button.type = "button";
  button.title = "order by " + column.title;
  button.dataset.cell = "head " + column.title;
  const chosen = place.order && place.order.title === column.title;
  if (chosen) cell.ariaSort = place.order.descending ? "descending" : "ascending";
  button.onclick = () => {
    place.order = { title: column.title, descending: chosen ? !place.order.descending : column.descends };
    showTable(place, sections[place.dataset.block]);
  };
}

// The parts of a cell are made once, and shown again with other numbers.
function showCell(place, row, cell, table) {
  place.classList.toggle("faint", cell.tone === "faint");
  if (!cell.use) place.title = cell.title || "";
  if (cell.use) {
    const button = place.firstElementChild || make("button", "", place);
    button.type = "button";
    button.dataset.cell = cell.text;
    setText(button, cell.text);
    button.title = cell.title || "";
    button.ariaCurrent = row.here ? "true" : null;
    button.onclick = () => setControl(...cell.use);
  } else if (cell.parts || place.className === "stages") {
    place.className = "stages";
    const line = place.firstElementChild || make("div", "", place);
    table.keys.forEach((key, i) => {
      const part = line.children[i] || make("span", "", line);
      part.style.background = themed(key.ink);
      part.style.width = cell.parts ? 100 * cell.parts[i] + "%" : 0;
    });
  } else if (cell.bar) {
    place.classList.add("bar");
    if (place.childElementCount === 0) {
      place.textContent = "";
      for (const tag of ["i", "b", "span"]) make(tag, "", place);
    }
    const [bar, span, words] = place.children;
    bar.style.background = span.style.background = themed(cell.bar.ink);
    const along = (share) => `calc((100% - var(--numbers)) * ${share})`;
    bar.style.width = along(cell.bar.value);
    span.hidden = cell.bar.low <= 0;
    span.style.left = along(cell.bar.low);
    span.style.width = along(Math.max(0, cell.bar.high - cell.bar.low));
    setText(words, cell.text);
  } else if (cell.swatch) {
    const swatch = place.firstElementChild || make("span", "", place);
    swatch.className = "swatch";
    swatch.style.background = swatch.title = cell.swatch;
  } else {
    setText(place, cell.text);
  }
}
