import assert from "node:assert/strict";
import { test } from "node:test";

import { refusedBy, shadesOf, stopAt } from "../../service/explorer/js/panels/track.js";

const NONE = { above: null, below: null, between: null };
const damping = { min: 0.05, max: 1.2, step: 0.001, valueAt: (place) => place };
const stiffness = { min: 1, max: 6, step: 0.01, valueAt: (place) => Number((10 ** place).toPrecision(3)) };
const DAMPINGS = refusedBy({ ...NONE, above: 0.3152 });
const STIFFNESSES = refusedBy({ ...NONE, above: 0.045, between: [13.1, 41.47] });

test("a thumb goes where the service takes its value, and no further", () => {
  assert.deepEqual(stopAt(DAMPINGS, damping, 0.4, 0.6), { place: 0.4, stopped: false });
  assert.deepEqual(stopAt(DAMPINGS, damping, 0.2, 0.6), { place: 0.316, stopped: true });
  const below = refusedBy({ ...NONE, below: 0.1897 });
  assert.deepEqual(stopAt(below, { min: 0, max: 0.25, step: 0.0005, valueAt: (place) => place }, 0.25, 0.1), { place: 0.1895, stopped: true });
});

test("a gap stops a thumb on the side from which it comes, and can be jumped", () => {
  assert.deepEqual(stopAt(STIFFNESSES, stiffness, 1.5, 4), { place: 1.62, stopped: true });
  assert.deepEqual(stopAt(STIFFNESSES, stiffness, 1.5, 1.05), { place: 1.11, stopped: true });
  assert.deepEqual(stopAt(STIFFNESSES, stiffness, 1.05, 4), { place: 1.05, stopped: false });
});

test("a value that is refused leaves on the nearer side, and stays where all are", () => {
  assert.deepEqual(stopAt(STIFFNESSES, stiffness, 1.2, 1.4), { place: 1.11, stopped: true });
  assert.deepEqual(stopAt(refusedBy({ ...NONE, above: 2 }), damping, 0.7, 0.6), { place: 0.6, stopped: true });
});

test("what is shaded is what is refused of the track", () => {
  const along = (parts, { min, max }, placeOf) => shadesOf(parts, { min, max, placeOf }).map((ends) => ends.map((end) => Number(end.toFixed(3))));
  assert.deepEqual(along(DAMPINGS, damping, (value) => value), [[0, 0.231]]);
  assert.deepEqual(along(STIFFNESSES, stiffness, (value) => Math.log10(Math.max(value, 1e-9))), [[0.023, 0.124]]);
  assert.deepEqual(along(refusedBy({ ...NONE, between: [1000, null] }), stiffness, Math.log10), [[0.4, 1]]);
  assert.deepEqual(along(refusedBy(NONE), damping, (value) => value), []);
});
