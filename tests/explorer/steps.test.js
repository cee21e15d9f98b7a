import assert from "node:assert/strict";
import test from "node:test";

import { changesAt, panelAt, placesOf, stepsOf } from "../../service/explorer/js/state/steps.js";

const OSCILLATOR = { model: "impacting", damping: 0.9, eccentricity: 0.1, half_backlash: 0.6 };
const DESIGN = { name: "drag_torque", units: "N m", values: [3, 4, 5], parameters: { damping: [0.9, 0.7, 0.6], half_backlash: [0.6, 0.5, 0.4] } };
const VARY = [{ parameter: "damping", values: [0.9, 0.8] }, { parameter: "eccentricity", values: [0.1, 0.09, 0.08] }];

test("a design steps along its coordinate, and all its numbers change", () => {
  const steps = stepsOf({ oscillator: OSCILLATOR, design: DESIGN });
  assert.deepEqual(steps.map(({ name, words, values }) => [name, words, values]), [["drag_torque", "drag torque (N m)", [3, 4, 5]]]);
  assert.deepEqual(changesAt(steps, 2), { damping: 0.6, half_backlash: 0.4 });
});

test("of two swept parameters the last one runs fastest", () => {
  const steps = stepsOf({ oscillator: OSCILLATOR, vary: VARY });
  assert.deepEqual(steps.map(({ words }) => words), ["damping δ", "eccentricity ε"]);
  for (let panel = 0; panel < 6; panel += 1) assert.equal(panelAt(steps, placesOf(steps, panel)), panel);
  assert.deepEqual(changesAt(steps, 4), { damping: 0.8, eccentricity: 0.09 });
});

test("one basin has no steps, and a range begins at its start", () => {
  assert.deepEqual(stepsOf({ oscillator: OSCILLATOR }), []);
  const steps = stepsOf({ oscillator: OSCILLATOR, vary: [{ parameter: "damping", start: 0.5, stop: 0.7, count: 3 }] });
  assert.deepEqual(changesAt(steps, 0), { damping: 0.5 });
});
