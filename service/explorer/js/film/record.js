/** Frames as a film: WebM, as browsers record it. */

const FORMATS = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"];
// Some seconds of a megabit each stay below a megabyte.
const BITS_A_SECOND = 1_000_000;
const LAST_FRAME_MS = 400;

/** Wait, or until it is stopped. @param {number} milliseconds @param {AbortSignal} signal */
function wait(milliseconds, signal) {
  return new Promise((resolve, reject) => {
    const timer = setTimeout(resolve, milliseconds);
    signal.addEventListener("abort", () => (clearTimeout(timer), reject(signal.reason)), { once: true });
  });
}

/**
 * Record frames of one size, at an even pace however long each took to make.
 * @param {HTMLCanvasElement[]} frames
 * @param {number} milliseconds that each is seen
 * @param {AbortSignal} signal
 * @returns {Promise<Blob>}
 */
export async function recorded(frames, milliseconds, signal) {
  const mimeType = FORMATS.find((format) => globalThis.MediaRecorder?.isTypeSupported(format));
  if (!mimeType) throw new Error("this browser records no WebM");
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [frames[0].width, frames[0].height];
  const context = canvas.getContext("2d");
  context.drawImage(frames[0], 0, 0);
  const recorder = new MediaRecorder(canvas.captureStream(), { mimeType, videoBitsPerSecond: BITS_A_SECOND });
  /** @type {Blob[]} */
  const parts = [];
  recorder.addEventListener("dataavailable", ({ data }) => parts.push(data));
  const stopped = new Promise((resolve) => recorder.addEventListener("stop", resolve, { once: true }));
  recorder.start();
  try {
    for (const frame of frames) {
      context.drawImage(frame, 0, 0);
      await wait(milliseconds, signal);
    }
    context.drawImage(frames.at(-1), 0, 0);
    await wait(LAST_FRAME_MS, signal);
  } finally {
    recorder.stop();
  }
  await stopped;
  return new Blob(parts, { type: "video/webm" });
}
