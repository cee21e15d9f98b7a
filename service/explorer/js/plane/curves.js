/** Long curves for a screen: what lies outside the window is left out, and points closer than a pixel are joined. */

const FINEST_PIXELS = 0.8;
const SHIFTS = [-1, 0, 1];

/** Rectangle around the points of a piece. */
function boxOf(piece) {
  if (piece.box) return piece.box;
  const box = { t0: Infinity, t1: -Infinity, v0: Infinity, v1: -Infinity };
  piece.time.forEach((t, i) => {
    const v = piece.velocity[i];
    box.t0 = Math.min(box.t0, t);
    box.t1 = Math.max(box.t1, t);
    box.v0 = Math.min(box.v0, v);
    box.v1 = Math.max(box.v1, v);
  });
  return (piece.box = box);
}

function apart(box, view, shift) {
  return box.t1 + shift < view.t0 || box.t0 + shift > view.t1 || box.v1 < view.v0 || box.v0 > view.v1;
}

/** Points of a piece on the screen as lists [x, y, x, y, ...], one for each run inside the window. */
function runsOf(plot, { time, velocity }, shift) {
  const runs = [];
  let run = null, before = null, [x0, y0] = [0, 0];
  const { left, top, width, height } = plot;
  const inside = (x, y) => x >= left - width && x <= left + 2 * width && y >= top - height && y <= top + 2 * height;
  for (let i = 0; i < time.length; i++) {
    const x = plot.x(time[i] + shift), y = plot.y(velocity[i]);
    const here = inside(x, y);
    if (here && !run) {
      run = before ? [...before, x, y] : [x, y];
      runs.push(run);
      [x0, y0] = [x, y];
    } else if (here || run) {
      const last = i === time.length - 1;
      if (!here || last || Math.hypot(x - x0, y - y0) >= FINEST_PIXELS) {
        run.push(x, y);
        [x0, y0] = [x, y];
      }
      if (!here) run = null;
    }
    before = [x, y];
  }
  return runs;
}

/**
 * Lines that draw pieces of curves in a window.
 * @param {import("./plot.js").Plot} plot maps time and velocity to the screen
 * @param {Polyline[]} pieces phases may run beyond a period
 * @returns {number[][]}
 */
export function linesOf(plot, pieces) {
  return SHIFTS.flatMap((shift) =>
    pieces.filter((piece) => !apart(boxOf(piece), plot.view, shift)).flatMap((piece) => runsOf(plot, piece, shift)));
}
