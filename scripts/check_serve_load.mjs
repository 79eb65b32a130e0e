// SPDX-License-Identifier: MIT
//
// scripts/check_serve load: 10,000 pictures of 20 visitors and 500 connections; the server's memory stays the
// same, and the visitors get equal shares. scripts/check_serve races: 400 pictures and 60 connections, for a program with
// ThreadSanitizer, which is slow, needs memory for its history, and ends the server with 66 after a race.
//   node check_serve_load.mjs SCENE CAMERAS [races]
// The visitors are plain WebSocket clients (package ws, a part of puppeteer-core). Every other one takes VP9 and
// confirms like a slow line, so that it gets VP9 at any load of the machine. Memory is compared from when all of them do.
import { argv, exit } from "node:process";
import WebSocket from "ws";
import { check, exitCode, memoryOf, startServer, wait } from "./serve_kit.mjs";

const [scene, cameras, kind] = argv.slice(2);
const kVisitors = 20;
const [kPictures, kConnections, kWarm] = kind === "races" ? [400, 60, 100] : [10000, 500, 8000];  // memory pools fill first
const kMostGrowth = kind === "races" ? Infinity : 32;  // MiB; 3 kB for each picture
const kSlowLine = 2500;  // bytes in a millisecond
const server = await startServer(scene, "--cameras", cameras, "--backend", "cpu");

// A client at an address of its own, because the server limits the connections of an address.
function connect(number) {
  return new WebSocket(`ws://127.0.0.1:${server.port}/live`, {
    origin: `http://127.0.0.1:${server.port}`, localAddress: `127.0.1.${1 + number % 200}`, perMessageDeflate: false,
  });
}

let pictures = 0, videos = 0, lost = 0;
class Visitor {
  constructor(number) {
    this.number = number;
    this.takesVideo = number % 2 === 1;
    this.videos = 0;
    this.free = 0;  // the time when the slow line has carried everything so far
    this.received = 0;
    this.socket = connect(number);
    this.say = (message) => this.socket.readyState === WebSocket.OPEN && this.socket.send(JSON.stringify(message));
    this.socket.on("open", () => {
      this.say({ type: "hello", token: server.token, width: 480, height: 360 });
      if (this.takesVideo) this.say({ type: "video", decodes: true });
      this.say({ type: "button", button: 0, down: true, x: 0, y: 0, input: 1 });
    });
    this.socket.on("message", (data, isBinary) => { if (isBinary) this.take(data); });
    this.socket.on("close", () => { lost += this.ends ? 0 : 1; });
    this.socket.on("error", () => {});
  }
  async take(data) {
    this.free = Math.max(this.free, performance.now()) + (this.takesVideo ? data.length / kSlowLine : 6);
    await wait(this.free - performance.now());
    ++pictures;
    if (data[1] === 3) {
      ++videos;
      ++this.videos;
    }
    ++this.received;
    this.say({ type: "cursor", x: this.received % 200, y: 0, input: 1 + this.received });
    this.say({ type: "received", count: this.received });
  }
  end() {
    this.ends = true;
    this.socket.terminate();
  }
}

async function until(count) {
  for (let waited = 0; pictures < count && waited < 600000; waited += 50) await wait(50);
}

try {
  const visitors = Array.from({ length: kVisitors }, (_, number) => new Visitor(number));
  await until(kWarm);
  for (let waited = 0; kind !== "races" && videos > 0 && visitors.some((one) => one.takesVideo && one.videos < 20) && waited < 120000; waited += 50) await wait(50);
  const before = await memoryOf(server.pid);
  const begun = visitors.map((visitor) => visitor.received);
  const warm = pictures;
  await until(warm + kPictures);
  const after = await memoryOf(server.pid);
  check(`${kPictures} pictures were sent`, pictures >= warm + kPictures, pictures);
  check("some of them as VP9, or there is no libvpx", videos > 100 || videos === 0 || kind === "races", videos);
  check("no visitor was lost", lost === 0, lost);
  check(`memory is flat over them (${before.toFixed(0)} to ${after.toFixed(0)} MiB, ${videos} by VP9)`, after - before < kMostGrowth);
  const shares = visitors.map((visitor, i) => visitor.received - begun[i]);
  const mean = shares.reduce((a, b) => a + b, 0) / kVisitors;
  if (kind !== "races") {
    check(`visitors get equal shares (${Math.min(...shares)} to ${Math.max(...shares)} pictures)`,
      Math.min(...shares) > 0.8 * mean && Math.max(...shares) < 1.2 * mean, shares);
  }
  for (const visitor of visitors) visitor.end();

  for (let i = 0; i < kConnections; ++i) {
    const socket = connect(i);
    await new Promise((resolve) => {
      socket.on("open", () => socket.send(JSON.stringify({ type: "hello", token: server.token, width: 640, height: 480 })));
      socket.on("message", (_, isBinary) => { if (isBinary || i % 3 === 0) resolve(); });
      socket.on("error", resolve);
    });
    socket.terminate();
  }
  await wait(1000);
  const last = await memoryOf(server.pid);
  check(`memory is flat over ${kConnections} connections (${last.toFixed(0)} MiB)`, last - before < kMostGrowth);
} catch (error) {
  check("all steps were possible", false, error);
}
check("Ctrl+C ends the server with 130", (await server.end()) === 130);
exit(exitCode());
