// SPDX-License-Identifier: MIT
//
// Files that the server sends, such as a film or a table: their parts are collected and saved. Files of edits and of
// measures go the other way.
// src/app/serve/file_message.h has the header.
"use strict";

const kFileHeader = 16;
let fileParts = [], fileNumber = -1, fileBytes = 0;

function takeFile(data) {
  const head = new DataView(data, 0, kFileHeader);
  const isLast = (head.getUint8(1) & 4) !== 0, nameBytes = head.getUint16(2, true);
  const number = head.getUint32(4, true), whole = Number(head.getBigUint64(8, true));
  const name = new TextDecoder().decode(new Uint8Array(data, kFileHeader, nameBytes));
  if (number !== fileNumber) [fileParts, fileBytes] = [[], 0];
  fileNumber = number;
  const part = new Uint8Array(data, kFileHeader + nameBytes);
  fileParts.push(part);
  fileBytes += part.length;
  showTransfer(isLast ? "" : `receiving ${name}: ${Math.floor(100 * fileBytes / Math.max(whole, 1))} %`);
  if (!isLast) return;
  saveFile(new Blob(fileParts), name);
  [fileParts, fileNumber] = [[], -1];
}

function saveFile(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  document.body.dataset.saved = name;
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

async function openFile(file) {
  const most = 1 << 20;
  if (!file) return;
  showTransfer(file.size > most ? `${file.name}: only files of at most 1 MiB are sent` : "");
  if (file.size <= most) send({ type: "file", name: file.name, text: await file.text() });
}

let transfer = "";
function showTransfer(words) {
  transfer = words;
  showJob();
}

// The line about what runs for this visitor, with a button that stops it.
function showJob() {
  const job = sections.job, place = at("job");
  const words = job ? job.words + (job.share === null ? "" : ` ${Math.floor(100 * job.share)} %`) : transfer;
  place.hidden = words === "";
  setText(place.firstElementChild, words);
  at("stop").hidden = !job;
}
