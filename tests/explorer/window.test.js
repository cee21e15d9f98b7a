import assert from "node:assert/strict";
import { test } from "node:test";

import { axesOf, HIGHEST, limitOf, NARROWEST, same, scaled, viewOf, within } from "../../service/explorer/js/state/window.js";

const CELLS = { time: 500, velocity: 500 };
/** By so much the service lets a window exceed a period: rounding, and no more. */
const ROUNDING = 1e-12;

test("a window of a whole period is never wider than a period, wherever it begins", () => {
  for (let i = 0; i < 20_000; i++) {
    const view = within({ t0: i / 7919 + 1e-13 * i, t1: i / 7919 + 1e-13 * i + 1, v0: 0, v1: 7 });
    const { time } = axesOf(view, CELLS);
    assert.ok(time.stop - time.start <= 1 + ROUNDING, `${time.start} to ${time.stop}`);
    assert.ok(time.start >= 0 && time.start < 1);
  }
});

test("a phase that rounds to 1 is phase 0", () => {
  const { time } = axesOf({ t0: 1 - 1e-14, t1: 1.5, v0: 0, v1: 7 }, CELLS);
  assert.equal(time.start, 0);
});

test("zooming out of a corner keeps the window within what the service takes", () => {
  let view = { t0: 0.9, t1: 0.90001, v0: 3, v1: 3.00001 };
  for (let i = 0; i < 100; i++) view = within(scaled(view, { t: view.t0, v: view.v1 }, 2));
  assert.ok(view.t1 - view.t0 <= 1 + ROUNDING);
  assert.ok(view.v0 >= 0 && view.v1 <= HIGHEST);
  assert.match(limitOf(view), /up to 100/);
});

test("at the narrowest window the wheel neither moves nor narrows it", () => {
  const view = { t0: 0.25, t1: 0.25 + NARROWEST, v0: 3, v1: 3 + NARROWEST };
  const zoomed = within(scaled(view, { t: 0.25, v: 3 }, 0.5));
  assert.ok(same(zoomed, view));
  assert.match(limitOf(view), /1e-9/);
});

test("one direction at its limit does not stop the other, and the point under the pointer stays", () => {
  const at = { t: 0.5, v: 2 };
  const zoomed = scaled({ t0: 0, t1: 1, v0: 1, v1: 3 }, at, 2);
  assert.deepEqual(zoomed, { t0: 0, t1: 1, v0: 0, v1: 4 });
});

test("the wheel narrows both ways about the point under the pointer", () => {
  assert.deepEqual(scaled({ t0: 0, t1: 1, v0: 0, v1: 8 }, { t: 0.5, v: 2 }, 0.5), { t0: 0.25, t1: 0.75, v0: 1, v1: 5 });
});

test("a window survives the way through a request", () => {
  const view = within({ t0: 0.123456789, t1: 0.2, v0: 1, v1: 2 });
  assert.ok(same(viewOf(axesOf(view, CELLS)), view));
  assert.ok(!same(view, { ...view, t1: 0.21 }));
});

test("windows are the same to a billionth of their width, and to rounding", () => {
  for (const width of [1, 1e-3]) {
    const view = { t0: 0, t1: width, v0: 0, v1: 2 * width };
    assert.ok(same(view, { ...view, t0: 0.5e-9 * width, v1: 2 * width + 1e-9 * width }));
    for (const name of ["t0", "t1", "v0", "v1"]) assert.ok(!same(view, { ...view, [name]: view[name] + 5e-9 * width + 5e-12 }), name);
  }
});

test("a window that is too wide keeps its middle", () => {
  const { t0, t1, v0, v1 } = within({ t0: 0.1, t1: 1.7, v0: 1, v1: 2 });
  assert.ok(Math.abs(t1 - t0 - 1) < 1e-12 && Math.abs((((t0 + t1) / 2 - 0.9) % 1)) < 1e-12);
  assert.deepEqual([v0, v1], [1, 2]);
  assert.deepEqual([0.25, -1].map((low) => within({ t0: 0, t1: 1, v0: low, v1: low + 0.5 }).v0), [0.25, 0]);
});
