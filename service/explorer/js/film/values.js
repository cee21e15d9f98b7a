/** What a film runs through: values of a slider, or times of a motion. Pure arithmetic. */

export const FRAMES = [2, 120];

/**
 * Evenly spaced values.
 * @param {{from: string, to: string, count: string}} given texts of fields
 * @returns {number[]}
 */
export function valuesBetween({ from, to, count }) {
  const [first, last, frames] = [from, to, count].map((text) => (text.trim() === "" ? NaN : Number(text)));
  if (!Number.isFinite(first) || !Number.isFinite(last) || first === last) throw new Error("a film runs from one number to another");
  return Array.from({ length: framesIn(frames) }, (_, i) => Number((first + ((last - first) * i) / (frames - 1)).toPrecision(9)));
}

/** @param {number} frames */
export function framesIn(frames) {
  if (!Number.isInteger(frames) || frames < FRAMES[0] || frames > FRAMES[1]) throw new Error(`a film has ${FRAMES[0]} to ${FRAMES[1]} frames`);
  return frames;
}

/**
 * Times of one period of a motion, the last of its history: of one that does not repeat, of four forcing periods.
 * @param {Motion} motion
 * @param {number} frames
 */
export function timesOf({ shown: { time }, end: { name } }, frames) {
  const repeats = Number(/^P\((\d+),/.exec(name ?? "")?.[1] ?? 4);
  const last = time[time.length - 1], first = Math.max(time[0], last - repeats);
  return Array.from({ length: framesIn(frames) }, (_, i) => first + ((last - first) * i) / frames);
}

/** Ends that are offered for a slider: a tenth below and above its value. @param {number} value */
export function endsAbout(value) {
  const digits = (number) => String(Number(number.toPrecision(4)));
  return { from: digits(0.9 * value), to: digits(value === 1 ? 1 : 1.1 * value) };
}
