import assert from "node:assert/strict";
import { test } from "node:test";

import { inside, middleOf, nearest, nextPoint, sameView, scaledAbout, shifted } from "../../service/explorer/js/charts/view.js";

const WHOLE = { x: [0.5, 0.7], y: [0, 8] };
const PIXEL = { x: 0.001, y: 0.02 };

test("a chart is scaled about the pointer, which stays where it is", () => {
  const { x, y } = scaledAbout(WHOLE, { x: 0.55, y: 2 }, 0.5);
  assert.deepEqual([x.map((each) => Number(each.toFixed(9))), y], [[0.525, 0.625], [1, 5]]);
});

test("a view ends where the whole ends, with its own width as long as that fits", () => {
  assert.deepEqual(inside(shifted({ x: [0.6, 0.7], y: [4, 8] }, 0.5, 0.5), WHOLE).y, [4, 8]);
  assert.ok(sameView(inside({ x: [0.4, 0.5], y: [-3, 1] }, WHOLE), { x: [0.5, 0.6], y: [0, 4] }));
  assert.ok(sameView(inside(scaledAbout(WHOLE, middleOf(WHOLE), 3), WHOLE), WHOLE));
});

test("a zoom ends before numbers do", () => {
  const { x, y } = inside(scaledAbout(WHOLE, middleOf(WHOLE), 1e-12), WHOLE);
  assert.ok(x[1] - x[0] > 1e-7 && y[1] - y[0] > 1e-6);
});

test("the point under the pointer is the nearest on the screen, of those that are seen", () => {
  const points = [{ x: 0.6, y: 4 }, { x: 0.602, y: 4 }, { x: 0.601, y: 4.5 }];
  assert.equal(nearest(points, { x: 0.6015, y: 4.1 }, WHOLE, PIXEL, 30), points[1]);
  assert.equal(nearest(points, { x: 0.65, y: 4 }, WHOLE, PIXEL, 30), null);
  assert.equal(nearest(points, { x: 0.6015, y: 4.1 }, { x: [0.5, 0.7], y: [4.2, 8] }, PIXEL, 30), points[2]);
});

test("arrows go to the next value, and up and down stay at a value", () => {
  const [low, high, next, far] = [{ x: 0.6, y: 1 }, { x: 0.6, y: 5 }, { x: 0.601, y: 4 }, { x: 0.61, y: 1 }];
  const points = [far, next, high, low];
  assert.equal(nextPoint(points, low, [1, 0], WHOLE), next);
  assert.equal(nextPoint(points, low, [0, 1], WHOLE), high);
  assert.equal(nextPoint(points, next, [-1, 0], WHOLE), high);
  assert.equal(nextPoint(points, far, [1, 0], WHOLE), null);
});
