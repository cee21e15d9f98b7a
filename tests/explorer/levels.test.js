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
