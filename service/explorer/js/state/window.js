/** Windows of the plane: pure arithmetic. A view is {t0, t1, v0, v1}. */

/** Narrowest window each way. Below, double precision runs out. */
export const NARROWEST = 1e-9;
/** Highest speed that a window reaches. */
export const HIGHEST = 100;

function digits(value) {
  return Number(value.toPrecision(12));
}

function clamp(value, least, most) {
  return Math.min(Math.max(value, least), most);
}

/** A window that the service accepts: at most a period wide, starting at a phase, without negative speeds. */
export function within(view) {
  const width = clamp(view.t1 - view.t0, NARROWEST, 1);
  let t0 = view.t0 + (view.t1 - view.t0 - width) / 2;
  t0 -= Math.floor(t0);
  const height = clamp(view.v1 - view.v0, NARROWEST, HIGHEST);
  const v0 = clamp(view.v0, 0, HIGHEST - height);
  return { t0, t1: t0 + width, v0, v1: v0 + height };
}

/** Window scaled about a point. Each way stops at its limit, where the other still follows. */
export function scaled(view, { t, v }, factor) {
  const along = (from, to, fixed, least, most) => {
    const width = to - from;
    const wanted = clamp(width * factor, Math.min(least, width), Math.max(most, width));
    const real = wanted / width;
    return [fixed + (from - fixed) * real, fixed + (to - fixed) * real];
  };
  const [t0, t1] = along(view.t0, view.t1, t, NARROWEST, 1);
  const [v0, v1] = along(view.v0, view.v1, v, NARROWEST, HIGHEST);
  return { t0, t1, v0, v1 };
}

/** Whether two windows are the same to the digits that a request has. */
export function same(one, other) {
  if (!one || !other) return one === other;
  const near = (a, b, width) => Math.abs(a - b) <= 1e-9 * width + 2e-12 * (1 + Math.abs(a));
  const [width, height] = [one.t1 - one.t0, one.v1 - one.v0];
  return near(one.t0, other.t0, width) && near(one.t1, other.t1, width) && near(one.v0, other.v0, height) && near(one.v1, other.v1, height);
}

/** Which limit a window has reached, in words; an empty text if none. */
export function limitOf(view) {
  if (view.t1 - view.t0 <= NARROWEST * 1.001 || view.v1 - view.v0 <= NARROWEST * 1.001) {
    return "This is as near as numbers go: the window is 1e-9 wide.";
  }
  if (view.v1 >= HIGHEST) return `Speeds are shown up to ${HIGHEST}.`;
  return "";
}

/**
 * Window as a request has it. The start is rounded and the width added: rounding both ends by themselves could make the
 * window wider than a period, which the service refuses.
 */
export function axesOf(view, cells) {
  const start = digits(view.t0) >= 1 ? 0 : digits(view.t0);
  const width = Math.min(digits(view.t1 - view.t0), 1);
  return {
    time: { start, stop: start + width, cells: cells.time },
    velocity: { start: digits(view.v0), stop: digits(view.v1), cells: cells.velocity },
  };
}

/** Window of a request's grid. */
export function viewOf({ time, velocity }) {
  return { t0: time.start, t1: time.stop, v0: velocity.start, v1: velocity.stop };
}
