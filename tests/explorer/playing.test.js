import assert from "node:assert/strict";
import { test } from "node:test";

import { Clock, departureAt, displacementAt, glowAt, impactsBetween, lastBelow } from "../../service/explorer/js/tooth/playing.js";

const HISTORY = {
  // The impact at t = 2 is two samples.
  time: [1, 1.5, 2, 2, 3], displacement: [0.6, 0, -0.6, -0.6, 0], velocity: [0, 0, 0, 0, 0], permanent_from: null,
  contacts: [{ time: 2, wall: -1, direction: "impact", speed: -4 }, { time: 2.5, wall: 1, direction: "out", speed: 9 }],
};

test("the tooth is where its history is, between samples on a line", () => {
  assert.equal(displacementAt(HISTORY, 1.25), 0.3);
  assert.equal(displacementAt(HISTORY, 2), -0.6);
  assert.equal(displacementAt(HISTORY, 0), 0.6);
  assert.equal(displacementAt(HISTORY, 9), 0);
});

test("the last sample is found by halving", () => {
  const values = Array.from({ length: 100 }, (_, i) => i / 10);
  for (const value of [-1, 0, 0.05, 4.2, 9.9, 50]) assert.equal(lastBelow(values, value), values.findLastIndex((each) => each <= value));
});

test("an impact sounds once, and leaving a wall does not sound", () => {
  assert.deepEqual(impactsBetween(HISTORY, 1.9, 2).map(({ speed }) => speed), [-4]);
  assert.deepEqual(impactsBetween(HISTORY, 2, 3), []);
});

test("the wall that was struck glows, and fades", () => {
  const struck = glowAt(HISTORY, 2, 0.1), later = glowAt(HISTORY, 2.1, 0.1);
  assert.equal(struck.upper, 0);
  // 4 of 9, the speed of the fastest contact; over a time of `fade` by 1/e.
  assert.ok(Math.abs(struck.lower - (4 / 9) ** 2) < 1e-12 && Math.abs(later.lower - (4 / 9) ** 2 / Math.E) < 1e-12);
});

test("each wall glows by its own contacts", () => {
  const contacts = [{ time: 1, wall: 1, direction: "impact", speed: 4 }, { time: 1, wall: -1, direction: "impact", speed: -2 }];
  assert.deepEqual(glowAt({ ...HISTORY, contacts }, 1, 0.1), { upper: 1, lower: 0.25 });
});

test("the dot is at the last departure", () => {
  const departures = [{ t: 1, v: 3 }, { t: 2.2, v: 4 }];
  assert.equal(departureAt(departures, 1.9), departures[0]);
  assert.equal(departureAt(departures, 2.3), departures[1]);
  assert.equal(departureAt([], 1), null);
});

test("the clock begins again after the end", () => {
  const clock = new Clock(1, 3, 2);
  assert.deepEqual(clock.run(0.5), { before: 1, after: 2 });
  assert.deepEqual(clock.run(0.6), { before: 1, after: 1 });
});
