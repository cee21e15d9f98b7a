import assert from "node:assert/strict";
import { test } from "node:test";

import { endsAbout, timesOf, valuesBetween } from "../../service/explorer/js/film/values.js";

test("a film of a slider runs evenly from one value to the other", () => {
  assert.deepEqual(valuesBetween({ from: "0.5", to: "0.7", count: "3" }), [0.5, 0.6, 0.7]);
  assert.deepEqual(valuesBetween({ from: "0.7", to: "0.5", count: "2" }), [0.7, 0.5]);
  for (const given of [{ from: "", to: "1", count: "5" }, { from: "1", to: "1", count: "5" }, { from: "a", to: "1", count: "5" }]) {
    assert.throws(() => valuesBetween(given), /from one number to another/);
  }
  for (const count of ["1", "121", "2.5", ""]) assert.throws(() => valuesBetween({ from: "0", to: "1", count }), /2 to 120 frames/);
});

test("a film of the tooth is its last period, without the first frame again at the end", () => {
  const motion = (name) => /** @type {any} */ ({ shown: { time: [0, 5, 10.5] }, end: { name } });
  assert.deepEqual(timesOf(motion("P(2,2,1)"), 4), [8.5, 9, 9.5, 10]);
  assert.deepEqual(timesOf(motion("P(3,1,0)*"), 3), [7.5, 8.5, 9.5]);
  assert.deepEqual(timesOf(motion(null), 2), [6.5, 8.5]);
});

test("the ends that are offered lie about the value, and those of restitution do not exceed 1", () => {
  assert.deepEqual(endsAbout(0.6), { from: "0.54", to: "0.66" });
  assert.deepEqual(endsAbout(1), { from: "0.9", to: "1" });
});
