/** Which cells of a basin are shown: pure arithmetic. Large basins have levels with every 2nd, 4th, 8th ... cell. */

// Largest number of cells each way that are fetched and drawn. Of more cells, only every n-th is shown.
const MOST_CELLS = 1500;
// With fewer cells in the window, computing it anew shows more.
const LEAST_CELLS = 256;
const LABELLED = 3;
const SHIFTS = [-1, 0, 1];

/**
 * The tiles from which a picture is made, of `rows` by `columns` of their own cells: `down` by `across` of them, of which
 * those beside each other have consecutive numbers from `first` on, and those above each other differ by `stride`. A
 * pixel is `every` cells of the basin each way, and `step` cells of the tiles.
 * @typedef {Tiling & { stride: number, every: number, step: number, query: string, states: number[]|null }} Shown
 */

/** Tiles of a whole basin: those of its finest level that fits on a screen, else its own. */
export function wholeOf({ time, velocity, tiles, levels }) {
  const every = Math.ceil(Math.max(time.cells, velocity.cells) / MOST_CELLS);
  const level = levels.find((one) => one.every >= every);
  if (level) return shownOf(level, level, level.first);
  return { ...tiles, stride: tiles.across, every, step: every, query: `every=${every}`, states: null };
}

function shownOf(level, { down, across }, first) {
  const { rows, columns, every } = level;
  const states = Array(down * across).fill(LABELLED);
  return { rows, columns, down, across, first, stride: level.across, every, step: 1, query: `level=${level.level}`, states };
}

/**
 * The parts of a finished basin that a window shows in the finest level that fits on a screen; none if what is shown
 * already, every n-th cell, is no coarser, or if the window has too few cells. Two where phases begin anew within it.
 * @param {Outline} outline
 * @param {number} every
 * @param {View} view
 * @returns {{ time: Axis, velocity: Axis, shown: Shown }[]}
 */
export function partsOf(outline, every, view) {
  const { time, velocity, tiles, levels } = outline;
  if (!levels.length) return [];
  const width = (time.stop - time.start) / time.cells, height = (velocity.stop - velocity.start) / velocity.cells;
  const cells = Math.max((view.t1 - view.t0) / width, (view.v1 - view.v0) / height);
  const level = [{ ...tiles, level: 0, every: 1 }, ...levels].find((one) => cells / one.every <= MOST_CELLS);
  if (!level || level.every >= every || cells < LEAST_CELLS) return [];
  const rows = along(velocity, level.rows * level.every, view.v0, view.v1);
  return SHIFTS.flatMap((shift) => {
    const columns = along(time, level.columns * level.every, view.t0 - shift, view.t1 - shift);
    if (!rows || !columns) return [];
    const size = { down: rows.count, across: columns.count };
    const shown = shownOf(level, size, level.first + rows.from * level.across + columns.from);
    return [{ time: columns.axis, velocity: rows.axis, shown }];
  });
}

/** Tiles along an axis, of so many cells, that lie between two values, and the axis that they cover; null if none do. */
function along({ start, stop, cells }, tile, from, to) {
  const low = Math.max(from, start), high = Math.min(to, stop), size = (stop - start) / cells;
  if (!(low < high)) return null;
  const first = Math.floor((low - start) / size / tile), last = Math.ceil((high - start) / size / tile);
  const begin = first * tile, end = Math.min(last * tile, cells);
  return { from: first, count: last - first, axis: { start: start + begin * size, stop: start + end * size, cells: end - begin } };
}
