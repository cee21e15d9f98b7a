/** Frames as a GIF, which pages and slides show without a player. */

import { applyPalette, GIFEncoder, quantize } from "./gifenc.esm.js";

const COLOURS = 256;

/**
 * Frames of one size, each with the colours it needs.
 * @param {HTMLCanvasElement[]} frames
 * @param {number} milliseconds that each is seen
 * @param {AbortSignal} signal
 * @returns {Promise<Blob>}
 */
export async function animated(frames, milliseconds, signal) {
  const gif = GIFEncoder();
  for (const frame of frames) {
    // Between two frames the page can be drawn, and the film be stopped.
    await new Promise((resolve) => setTimeout(resolve));
    signal.throwIfAborted();
    const { width, height } = frame;
    const { data } = frame.getContext("2d").getImageData(0, 0, width, height);
    const palette = quantize(data, COLOURS);
    gif.writeFrame(applyPalette(data, palette), width, height, { palette, delay: milliseconds });
  }
  gif.finish();
  return new Blob([gif.bytes()], { type: "image/gif" });
}
