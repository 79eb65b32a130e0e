// SPDX-License-Identifier: MIT
//
// Shared by the scripts that scripts/check_serve runs: checks, the server, a slow line in front of it.
import { spawn } from "node:child_process";
import net from "node:net";
import { env } from "node:process";

let failures = 0;
export function check(what, holds, found = "") {
  console.log((holds ? "ok      " : "FAILED  ") + what + (holds ? "" : ": " + found));
  if (!holds) ++failures;
}
export const exitCode = () => (failures === 0 ? 0 : 1);
export const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

// Starts `quadsplat serve` with these arguments. `address` has the token; end() resolves to the exit code.
export const startServer = (...args) => start("serve", ...args);

// The same for `quadsplat COMMAND`, whose output has the address.
export async function start(...args) {
  const server = spawn(env.QUADSPLAT, [...args, "--port", "0"]);
  let errors = "";
  server.stderr.on("data", (data) => { errors += data; });
  const address = await new Promise((resolve, reject) => {
    let out = "";
    server.stdout.on("data", (data) => {
      out += data;
      const line = out.match(/^(https?:.*)\n/m);
      if (line) resolve(line[1]);
    });
    server.on("exit", () => reject(new Error("the server ended: " + errors)));
  });
  return {
    address, port: Number(new URL(address).port), token: new URL(address).hash.slice("#token=".length),
    pid: server.pid,
    end() {
      server.removeAllListeners("exit");
      const ended = new Promise((resolve) => server.on("exit", (code) => resolve(code)));
      server.kill("SIGINT");
      return ended;
    },
  };
}

const kPiece = 1500;         // bytes that arrive together
const kMostQueued = 262144;  // bytes in front of the line, before the sender has to wait

// One direction of a line: a FIFO and one timer. The line carries `bits` a second; a byte arrives
// `delay` milliseconds after it has passed.
function direction(from, to, bits, delay) {
  const fifo = [];
  let free = 0, queued = 0, timer = null;
  const deliver = () => {
    timer = null;
    const now = performance.now();
    while (fifo.length > 0 && fifo[0].at <= now) {
      const { bytes } = fifo.shift();
      queued -= bytes.length;
      if (to.destroyed) continue;
      if (bytes.length > 0) to.write(bytes);
      else to.end();
    }
    if (queued < kMostQueued / 2) from.resume();
    if (fifo.length > 0) timer = setTimeout(deliver, Math.max(1, fifo[0].at - now));
  };
  from.on("data", (data) => {
    for (let begin = 0; begin < data.length; begin += kPiece) {
      const bytes = data.subarray(begin, begin + kPiece);
      free = Math.max(free, performance.now()) + 8e3 * bytes.length / bits;
      fifo.push({ at: free + delay, bytes });
      queued += bytes.length;
    }
    if (queued > kMostQueued) from.pause();
    if (!timer) timer = setTimeout(deliver, 1);
  });
  from.on("end", () => {
    fifo.push({ at: Math.max(free, performance.now()) + delay, bytes: Buffer.alloc(0) });
    if (!timer) timer = setTimeout(deliver, 1);
  });
  from.on("error", () => to.destroy());
}

// Listens at a free port and connects to `port` through a line of so many Mbit/s in each direction and
// a round trip of `trip` ms.
export async function slowLine(port, megabits, trip) {
  const server = net.createServer({ noDelay: true, allowHalfOpen: true }, (client) => {
    const upstream = net.connect({ port, host: "127.0.0.1", noDelay: true, allowHalfOpen: true });
    direction(client, upstream, megabits * 1e6, trip / 2);
    direction(upstream, client, megabits * 1e6, trip / 2);
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return { port: server.address().port, end: () => server.close() };
}

// The process's memory in MiB.
export async function memoryOf(pid) {
  const { readFileSync } = await import("node:fs");
  const line = readFileSync(`/proc/${pid}/status`, "utf8").match(/VmRSS:\s+(\d+)/);
  return Number(line[1]) / 1024;
}

// The page's address through another port.
export const through = (address, port) => address.replace(/:\d+\//, `:${port}/`);
