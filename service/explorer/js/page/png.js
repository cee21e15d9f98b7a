/** What a PNG says of itself beside its pixels: a description, and its dots per inch. */

const SIGNATURE_AND_HEADER = 33;
const INCH_IN_M = 0.0254;

const TABLE = Uint32Array.from({ length: 256 }, (_, byte) => {
  let rest = byte;
  for (let bit = 0; bit < 8; bit++) rest = rest & 1 ? (rest >>> 1) ^ 0xedb88320 : rest >>> 1;
  return rest;
});

function checksum(bytes) {
  let rest = 0xffffffff;
  for (const byte of bytes) rest = TABLE[(rest ^ byte) & 255] ^ (rest >>> 8);
  return (rest ^ 0xffffffff) >>> 0;
}

/** @param {string} name @param {Uint8Array} content */
function chunk(name, content) {
  const bytes = new Uint8Array(content.length + 12), view = new DataView(bytes.buffer);
  view.setUint32(0, content.length);
  bytes.set(new TextEncoder().encode(name), 4);
  bytes.set(content, 8);
  view.setUint32(8 + content.length, checksum(bytes.subarray(4, 8 + content.length)));
  return bytes;
}

function resolution(dpi) {
  const bytes = new Uint8Array(9), view = new DataView(bytes.buffer), perMetre = Math.round(dpi / INCH_IN_M);
  view.setUint32(0, perMetre);
  view.setUint32(4, perMetre);
  bytes[8] = 1;
  return bytes;
}

/**
 * A PNG with a description, which may have any letters, and with dots per inch.
 * @param {Uint8Array} png
 * @param {{description: string, dpi: number|null}} said
 * @returns {Uint8Array}
 */
export function described(png, { description, dpi }) {
  // A keyword, no compression, no language, and no keyword in it.
  const added = [chunk("iTXt", new TextEncoder().encode(`Description\0\0\0\0\0${description}`))];
  if (dpi !== null) added.unshift(chunk("pHYs", resolution(dpi)));
  const whole = new Uint8Array(png.length + added.reduce((sum, { length }) => sum + length, 0));
  whole.set(png.subarray(0, SIGNATURE_AND_HEADER));
  let at = SIGNATURE_AND_HEADER;
  for (const each of added) {
    whole.set(each, at);
    at += each.length;
  }
  whole.set(png.subarray(SIGNATURE_AND_HEADER), at);
  return whole;
}
