import assert from "node:assert/strict";
import { test } from "node:test";

import { partsOf, wholeOf } from "../../service/explorer/js/plane/levels.js";

const tilesOf = (rows, columns, cells) => ({ rows, columns, down: Math.ceil(cells / rows), across: Math.ceil(cells / columns), first: 0 });
const LEVELS = [1, 2, 3, 4, 5, 6, 7].map((level) => {
  const cells = Math.ceil(100000 / 2 ** level), side = Math.min(1640, cells);
  return { level, every: 2 ** level, ...tilesOf(side, side, cells) };
});
const LARGE = {
  time: { start: 0, stop: 1, cells: 100000 }, velocity: { start: 0, stop: 7, cells: 100000 },
  tiles: { ...tilesOf(205, 205, 100000), states: [] }, levels: LEVELS,
};
const around = (t, v, part) => ({ t0: t - part / 2, t1: t + part / 2, v0: v - 3.5 * part, v1: v + 3.5 * part });

test("a large basin is shown by one tile of the level that fits on a screen", () => {
  const { every, step, down, across, query } = wholeOf(LARGE);
  assert.deepEqual({ every, step, down, across, query }, { every: 128, step: 1, down: 1, across: 1, query: "level=7" });
});

test("without levels every n-th cell of each tile is shown, as before", () => {
  const { every, step, query } = wholeOf({ ...LARGE, levels: [] });
  assert.deepEqual({ every, step, query }, { every: 67, step: 67, query: "every=67" });
  assert.deepEqual(partsOf({ ...LARGE, levels: [] }, 67, around(0.5, 3.5, 0.1)), []);
});

for (const part of [0.5, 0.1, 0.02, 0.01, 0.004]) {
  test(`a window of ${part} of the basin is covered by few tiles of a finer level, and by their own numbers`, () => {
    const view = around(0.61, 2.9, part);
    const [{ time, velocity, shown }, ...others] = partsOf(LARGE, 128, view);
    assert.equal(others.length, 0);
    assert.ok(time.start <= view.t0 && view.t1 <= time.stop && velocity.start <= view.v0 && view.v1 <= velocity.stop);
    const cells = (part * 100000) / shown.every;
    assert.ok(cells <= 1500 && (shown.every === 1 || 2 * cells > 1500));
    // A window of c cells touches at most c / side + 2 tiles each way.
    assert.ok(shown.down <= cells / shown.rows + 2 && shown.across <= cells / shown.columns + 2);
    const row = Math.floor(shown.first / shown.stride), column = shown.first % shown.stride;
    assert.ok(Math.abs(time.start - (column * shown.columns * shown.every) / 100000) < 1e-9);
    assert.ok(Math.abs(velocity.start - (7 * row * shown.rows * shown.every) / 100000) < 1e-9);
    assert.equal(shown.states.length, shown.down * shown.across);
  });
}

// Twice as many cells along time as along velocity, in tiles that are higher than wide.
const WIDE = {
  time: { start: 0.25, stop: 1.25, cells: 8000 }, velocity: { start: 1, stop: 3, cells: 4000 },
  tiles: { rows: 500, columns: 300, down: 8, across: 27, first: 0, states: [] },
  levels: [
    { level: 1, every: 2, rows: 600, columns: 500, down: 4, across: 8, first: 0 },
    { level: 2, every: 4, rows: 600, columns: 500, down: 2, across: 4, first: 0 },
    { level: 3, every: 8, rows: 500, columns: 1000, down: 1, across: 1, first: 0 },
  ],
};

test("the longer side says which cells are shown", () => {
  for (const [time, velocity] of [[8000, 4000], [4000, 8000]]) {
    const outline = { ...WIDE, time: { ...WIDE.time, cells: time }, velocity: { ...WIDE.velocity, cells: velocity } };
    assert.equal(wholeOf(outline).query, "level=3");
    assert.equal(wholeOf({ ...outline, levels: [] }).query, "every=6");
  }
});

test("a level that is exactly coarse enough is taken", () => {
  // 12000 cells want every 8th.
  assert.equal(wholeOf({ ...WIDE, time: { ...WIDE.time, cells: 12000 } }).query, "level=3");
});

test("a window that is not square is covered by the tiles of its own rows and columns", () => {
  // 2000 x 400 cells: 1000 columns of level 1, of tiles of 500 x 600 of them.
  const [{ time, velocity, shown }, ...others] = partsOf(WIDE, 8, { t0: 0.5, t1: 0.75, v0: 1.9, v1: 2.1 });
  assert.equal(others.length, 0);
  assert.deepEqual([shown.query, shown.down, shown.across, shown.first, shown.stride], ["level=1", 1, 2, 1 * 8 + 2, 8]);
  assert.deepEqual(time, { start: 0.5, stop: 0.75, cells: 2000 });
  assert.ok(Math.abs(velocity.start - 1.6) < 1e-12 && Math.abs(velocity.stop - 2.2) < 1e-12 && velocity.cells === 1200);
});

test("the finest cells are those of the tiles themselves, up to the edge", () => {
  const [{ time, velocity, shown }] = partsOf(WIDE, 8, { t0: 1.2, t1: 1.25, v0: 2.9, v1: 3 });
  assert.deepEqual([shown.query, shown.every, shown.down, shown.across, shown.first], ["level=0", 1, 1, 2, 7 * 27 + 25]);
  // Columns 7500 to 8000, and rows 3500 to 4000.
  assert.deepEqual([time.stop, time.cells, velocity.stop, velocity.cells], [1.25, 500, 3, 500]);
  assert.ok(Math.abs(time.start - (0.25 + 7500 / 8000)) < 1e-12 && Math.abs(velocity.start - (1 + 3500 / 2000)) < 1e-12);
});

test("where phases begin anew within the window there are two parts", () => {
  const parts = partsOf(LARGE, 128, around(1.0, 2.9, 0.1));
  assert.equal(parts.length, 2);
  assert.equal(Math.min(...parts.map(({ time }) => time.start)), 0);
  assert.equal(Math.max(...parts.map(({ time }) => time.stop)), 1);
});

test("the whole window, and one of a few cells, have no parts", () => {
  assert.deepEqual(partsOf(LARGE, 128, { t0: 0, t1: 1, v0: 0, v1: 7 }), []);
  assert.deepEqual(partsOf(LARGE, 128, around(0.5, 3.5, 0.002)), []);
});
