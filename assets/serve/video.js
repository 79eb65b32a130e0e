// SPDX-License-Identifier: MIT
//
// Turns the server's pictures into images of the canvas: JPEG and WebP by createImageBitmap, VP9 by
// WebCodecs where the browser has it and the page is a secure context.
"use strict";

const kCodecs = ["", "JPEG", "WebP", "VP9"];
const kImageTypes = ["", "image/jpeg", "image/webp"];
const kVp9 = 3, kMostDecoderErrors = 3;
// The server's pictures have these colours; browsers differ about streams that do not say so.
const kVideo = {
  codec: "vp09.00.51.08", optimizeForLatency: true,
  colorSpace: { matrix: "smpte170m", primaries: "bt709", transfer: "bt709", fullRange: false },
};

// `ask(decodes)` asks the server for VP9 beginning with a key picture, or for pictures without VP9.
class PictureDecoder {
  constructor(ask) {
    this.ask = ask;
    this.errors = 0;
    this.waiting = new Map();  // number of a picture -> resolve
    this.decoder = null;
  }

  // Called after the connection was made.
  async begin() {
    this.close();
    if (this.errors >= kMostDecoderErrors || !("VideoDecoder" in window)) return;
    try {
      if ((await VideoDecoder.isConfigSupported(kVideo)).supported) this.ask(true);
    } catch {
      // JPEG it is
    }
  }

  // An image with width, height and close(), or null if this picture cannot be decoded.
  image(facts, bytes) {
    if (facts.codec === kVp9) return this.frame(facts, bytes);
    const file = new Blob(bytes, { type: kImageTypes[facts.codec] });
    return createImageBitmap(file, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
  }

  frame(facts, bytes) {
    if (!this.decoder && !facts.key) return Promise.resolve(null);  // a key picture is coming
    if (!this.decoder) {
      this.decoder = new VideoDecoder({ output: (frame) => this.take(frame), error: () => this.fail() });
      this.decoder.configure(kVideo);
    }
    return new Promise((resolve) => {
      this.waiting.set(facts.number, resolve);
      try {
        this.decoder.decode(new EncodedVideoChunk({
          type: facts.key ? "key" : "delta", timestamp: facts.number, data: bytes[0],
        }));
      } catch {
        this.fail();
      }
    });
  }

  take(frame) {
    this.errors = 0;
    const resolve = this.waiting.get(frame.timestamp);
    this.waiting.delete(frame.timestamp);
    if (resolve) resolve(frame);
    else frame.close();
  }

  fail() {
    this.close();
    this.ask(++this.errors < kMostDecoderErrors);
  }

  close() {
    if (this.decoder && this.decoder.state !== "closed") this.decoder.close();
    this.decoder = null;
    for (const resolve of this.waiting.values()) resolve(null);
    this.waiting.clear();
  }
}

// The bytes that arrived and the delays of the last second, for the status line.
class LineFacts {
  constructor() {
    this.arrived = [];         // [time, bytes]
    this.inputs = new Map();   // number of an input -> time
    this.delay = 0;            // milliseconds from the last input to its picture
  }

  input(number) {
    this.inputs.set(number, performance.now());
    if (this.inputs.size > 500) this.inputs.delete(this.inputs.keys().next().value);
  }

  bytes(count) {
    const now = performance.now();
    this.arrived.push([now, count]);
    while (now - this.arrived[0][0] > 1000) this.arrived.shift();
  }

  // A picture that answers this input is shown.
  shown(number) {
    const began = this.inputs.get(number);
    if (began === undefined) return;
    this.delay = performance.now() - began;
    for (const earlier of this.inputs.keys()) if (earlier <= number) this.inputs.delete(earlier);
  }

  text(facts) {
    const bits = 8 * this.arrived.reduce((sum, [, count]) => sum + count, 0);
    const words = [kCodecs[facts.codec], facts.width + "\u00d7" + facts.height,
                   (bits / 1e6).toFixed(1) + " Mbit/s"];
    if (this.delay > 0) words.push(Math.round(this.delay) + " ms");
    return words.join(" \u00b7 ");
  }
}
