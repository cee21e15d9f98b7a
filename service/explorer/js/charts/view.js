/** What a chart shows of its whole: pure arithmetic. A view is {x: [from, to], y: [from, to]}. */

/** Narrowest view, as a part of the whole. Below, a picture of so many points shows nothing more. */
const NARROWEST = 1e-6;

/** @typedef {{x: number[], y: number[]}} ChartView */
/** @typedef {{x: number, y: number}} Spot */

/** @param {number[]} ends @param {number[]} whole */
function fitted([from, to], [least, most]) {
  const width = Math.min(Math.max(to - from, NARROWEST * (most - least)), most - least);
  const begin = Math.min(Math.max((from + to - width) / 2, least), most - width);
  return [begin, begin + width];
}

/** A view that lies within the whole. @param {ChartView} view @param {ChartView} whole @returns {ChartView} */
export function inside(view, whole) {
  return { x: fitted(view.x, whole.x), y: fitted(view.y, whole.y) };
}

/** A view scaled about a spot, which stays where it is. @param {ChartView} view @param {Spot} spot @param {number} factor */
export function scaledAbout({ x, y }, spot, factor) {
  const along = (/** @type {number[]} */ [from, to], fixed) => [fixed + (from - fixed) * factor, fixed + (to - fixed) * factor];
  return { x: along(x, spot.x), y: along(y, spot.y) };
}

/** A view moved by parts of its width and height. @param {ChartView} view */
export function shifted({ x, y }, across, up) {
  const along = (/** @type {number[]} */ [from, to], part) => [from + part * (to - from), to + part * (to - from)];
  return { x: along(x, across), y: along(y, up) };
}

/** Middle of a view. @param {ChartView} view @returns {Spot} */
export function middleOf({ x, y }) {
  return { x: (x[0] + x[1]) / 2, y: (y[0] + y[1]) / 2 };
}

/** Whether two views are the same to what is seen. @param {ChartView|null} one @param {ChartView|null} other */
export function sameView(one, other) {
  if (!one || !other) return one === other;
  const near = (a, b) => Math.abs(a[0] - b[0]) + Math.abs(a[1] - b[1]) <= 1e-9 * (a[1] - a[0]);
  return near(one.x, other.x) && near(one.y, other.y);
}

/** @param {ChartView} view @param {Spot} spot */
export function holds({ x, y }, spot) {
  return spot.x >= x[0] && spot.x <= x[1] && spot.y >= y[0] && spot.y <= y[1];
}

/**
 * The point nearest to a spot, of those that are seen; null if all lie farther than `reach`.
 * @template {Spot} T
 * @param {T[]} points
 * @param {Spot} spot
 * @param {ChartView} view
 * @param {{x: number, y: number}} unit what one pixel is
 * @param {number} reach in pixels
 * @returns {T|null}
 */
export function nearest(points, spot, view, unit, reach) {
  let [found, least] = [null, reach];
  for (const point of points) {
    const distance = Math.hypot((point.x - spot.x) / unit.x, (point.y - spot.y) / unit.y);
    if (distance <= least && holds(view, point)) [found, least] = [point, distance];
  }
  return found;
}

/**
 * The next point from a spot to the right, left, up or down, of those that are seen; null if there is none. To a side it
 * is of the next value that has one; up and down it stays at the value as long as that has one.
 * @template {Spot} T
 * @param {T[]} points
 * @param {Spot} spot
 * @param {number[]} way as [1, 0] for the right
 * @param {ChartView} view
 * @returns {T|null}
 */
export function nextPoint(points, spot, [across, up], view) {
  const [width, height] = [view.x[1] - view.x[0], view.y[1] - view.y[0]];
  const cost = (point) => {
    const [dx, dy] = [(point.x - spot.x) / width, (point.y - spot.y) / height];
    const [along, aside] = across ? [dx * across, Math.abs(dy)] : [dy * up, Math.abs(dx)];
    if (!(along > 1e-9)) return Infinity;
    // A side step weighs more than any way along the same value.
    return across ? along * 1e6 + aside : along + aside * 1e3;
  };
  let [found, least] = [null, Infinity];
  for (const point of points) {
    if (!holds(view, point)) continue;
    const costs = cost(point);
    if (costs < least) [found, least] = [point, costs];
  }
  return found;
}
