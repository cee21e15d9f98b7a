import assert from "node:assert/strict";
import { test } from "node:test";
import { crc32, deflateSync } from "node:zlib";

import { printingOf, sheetOf, USUAL } from "../../service/explorer/js/page/paper.js";
import { described } from "../../service/explorer/js/page/png.js";

const SCREEN = { width: 800, height: 400 };

test("without a size a picture is as on the screen", () => {
  assert.deepEqual(sheetOf(USUAL, SCREEN), { ...SCREEN, ratio: 2, dpi: null });
  assert.deepEqual(printingOf(USUAL), {});
});

test("a width in mm gives so many dots, and letters of the plane have so many points", () => {
  const { width, height, ratio } = sheetOf({ ...USUAL, width: "127", dpi: "300", letters: "6" }, SCREEN);
  assert.ok(Math.abs(width * ratio - 1500) < 1e-9, "5 inches at 300 dpi");
  assert.ok(Math.abs(height * ratio - 750) < 1e-9, "the other side follows from the screen");
  assert.ok(Math.abs((12 * ratio * 72) / 300 - 6) < 1e-9, "letters of 12 pixels have 6 points");
  assert.deepEqual(printingOf({ ...USUAL, width: "127", letters: "6" }), { width: 127, dpi: 300, font_size: 6 });
  const both = sheetOf({ ...USUAL, width: "100", height: "100" }, SCREEN);
  assert.equal(both.width, both.height);
});

test("a size that would exhaust memory, or is none, is refused in words", () => {
  assert.throws(() => sheetOf({ ...USUAL, width: "1200", height: "1200", dpi: "1200" }, SCREEN), /at most 40 million pixels, not 56693 × 56693/);
  assert.throws(() => printingOf({ ...USUAL, width: "wide" }), /width, mm: 20 to 1200/);
  assert.throws(() => printingOf({ ...USUAL, height: "60", letters: "400" }), /letters, points: 4 to 36/);
});

/** The chunks of a PNG by name, each with the right checksum. */
function chunksOf(png) {
  const chunks = {}, view = new DataView(png.buffer, png.byteOffset);
  for (let at = 8; at < png.length; at += 12 + view.getUint32(at)) {
    const length = view.getUint32(at);
    assert.equal(view.getUint32(at + 8 + length), crc32(png.subarray(at + 4, at + 8 + length)));
    chunks[Buffer.from(png.subarray(at + 4, at + 8)).toString("latin1")] = Buffer.from(png.subarray(at + 8, at + 8 + length));
  }
  return chunks;
}

test("a PNG carries its caption and its dots per inch, each with a checksum, and its pixels as before", () => {
  const raw = (name, content) => {
    const body = Buffer.concat([Buffer.from(name), content]), ends = [Buffer.alloc(4), Buffer.alloc(4)];
    ends[0].writeUInt32BE(content.length);
    ends[1].writeUInt32BE(crc32(body));
    return Buffer.concat([ends[0], body, ends[1]]);
  };
  const header = Buffer.from([0, 0, 0, 1, 0, 0, 0, 1, 8, 0, 0, 0, 0]), pixels = deflateSync(Buffer.from([0, 7]));
  const png = Buffer.concat([Buffer.from("89504e470d0a1a0a", "hex"), raw("IHDR", header), raw("IDAT", pixels), raw("IEND", Buffer.alloc(0))]);
  const chunks = chunksOf(described(png, { description: "δ = 0.6", dpi: 254 }));
  assert.deepEqual(Object.keys(chunks), ["IHDR", "pHYs", "iTXt", "IDAT", "IEND"]);
  assert.equal(chunks.iTXt.toString("utf8"), "Description\0\0\0\0\0δ = 0.6");
  assert.deepEqual([...chunks.pHYs], [0, 0, 0x27, 0x10, 0, 0, 0x27, 0x10, 1]);
  assert.deepEqual(chunks.IDAT, pixels);
  assert.ok(!("pHYs" in chunksOf(described(png, { description: "", dpi: null }))));
});
