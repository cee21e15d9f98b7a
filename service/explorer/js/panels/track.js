/** The part of a slider's track that the service refuses: where it is, and the place next to it where a thumb stops. */

/**
 * Values that a bound of the service refuses, as [from, to] pairs.
 * @param {Bound} bound
 * @returns {[number, number][]}
 */
export function refusedBy({ above, below, between }) {
  /** @type {[number, number][]} */
  const parts = [];
  if (above !== null) parts.push([-Infinity, above]);
  if (below !== null) parts.push([below, Infinity]);
  if (between) parts.push([between[0], between[1] ?? Infinity]);
  return parts;
}

/** The part that has a value; undefined where the value is taken. @param {[number, number][]} parts */
function around(parts, value) {
  return parts.find(([from, to]) => value >= from && value <= to);
}

/**
 * Place of a thumb that is moved to `place`: there, or the last step before a refused part. It stays where it was if
 * there is none.
 * @param {[number, number][]} parts that are refused
 * @param {{min: number, max: number, step: number, valueAt: (place: number) => number}} track
 * @param {number} place
 * @param {number} before where it was
 * @returns {{place: number, stopped: boolean}}
 */
export function stopAt(parts, { min, max, step, valueAt }, place, before) {
  if (!around(parts, valueAt(place))) return { place, stopped: false };
  const out = (way) => {
    let n = 1;
    while (n * step <= max - min && around(parts, valueAt(place + way * n * step))) n++;
    const found = Number((place + way * n * step).toPrecision(12));
    return found >= min && found <= max && !around(parts, valueAt(found)) ? [found] : [];
  };
  // On the side from which it comes; from within a refused part, to the nearer side.
  const from = around(parts, valueAt(before)) ? place : before;
  const [found = before] = [...out(-1), ...out(1)].sort((one, other) => Math.abs(one - from) - Math.abs(other - from));
  return { place: found, stopped: true };
}

/**
 * Refused parts of a track, as [from, to] in parts of its length.
 * @param {[number, number][]} parts
 * @param {{min: number, max: number, placeOf: (value: number) => number}} track
 */
export function shadesOf(parts, { min, max, placeOf }) {
  const along = (value) => Math.min(Math.max((placeOf(value) - min) / (max - min), 0), 1);
  return parts.map(([from, to]) => [along(from), along(to)]).filter(([from, to]) => to > from);
}
