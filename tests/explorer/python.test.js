import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { pythonOf } from "../../service/explorer/js/look/python.js";
import { knowAdditions } from "../../service/explorer/js/state/additions.js";

knowAdditions(JSON.parse(readFileSync(new URL("additions.json", import.meta.url), "utf8")));

const GRID = { time: { start: 0.2, stop: 0.6, cells: 50 }, velocity: { start: 1, stop: 3, cells: 40 } };

test("the Python of a basin has its parameters, its window and k", () => {
  const oscillator = { model: "piecewise_linear", damping: 0.6, stiffness: 1000, permanent_contact: "envelope", allow_no_quiet_solution: true };
  assert.equal(pythonOf({ oscillator, grid: GRID, iterations: 61 }), `import rattle

basin = rattle.basin(
    damping=0.6, stiffness=1000, permanent_contact="envelope", allow_no_quiet_solution=True,
    cells=(50, 40), time=(0.2, 0.6), velocity=(1, 3),
    iterations=61,
)
basin.rattle.plot()`);
});

test("the Python of a sweep names the values that are swept once", () => {
  const vary = [{ parameter: "damping", values: [0.5, 0.6] }];
  const text = pythonOf({ oscillator: { model: "impacting", damping: 0.6, eccentricity: 0.1 }, grid: GRID, iterations: 61, vary });
  assert.match(text, /rattle\.sweep\(\n {4}damping=\[0\.5, 0\.6\], eccentricity=0\.1,/);
});

test("the Python of a machine has its numbers in SI in place of those of the model", () => {
  const machine = { speed: 305, backlash: 61e-6, transmission_error: { 1: { amplitude: 5.2e-6, phase: 0 }, 2: { amplitude: 1e-6, phase: 0.25 } }, drag_law: "constant", turns: 1 };
  const oscillator = { model: "piecewise_linear", damping: 0.1, stiffness: 1000, harmonics: [{ order: 2, amplitude: 0.1 }], permanent_contact: "one_rotation" };
  const text = pythonOf({ machine, oscillator, grid: GRID, iterations: 61 });
  const pair = 'rattle.GearPair(speed=305, backlash=0.000061, drag_law="constant", turns=1, transmission_error={1: 0.0000052, 2: {"amplitude": 0.000001, "phase": 0.25}})';
  assert.ok(text.includes(`    machine=${pair}, permanent_contact="one_rotation",\n    cells=`), text);
  const vary = [{ parameter: "damping", values: [0.1, 0.2] }];
  assert.ok(pythonOf({ machine, oscillator, grid: GRID, iterations: 61, vary }).includes('permanent_contact="one_rotation", damping=[0.1, 0.2],'));
});

test("the Python of a proof has its levels and tolerances", () => {
  const request = { oscillator: { model: "impacting", damping: 0.6 }, grid: GRID, iterations: 61 };
  assert.match(pythonOf({ ...request, prove: true }), /iterations=61,\n {4}prove=True,\n\)/);
  const prove = { levels: 1, tolerances: { damping: [0.59, 0.61] } };
  assert.match(pythonOf({ ...request, prove }), /prove=True,\n {4}levels=1,\n {4}tolerances=\{"damping": \(0\.59, 0\.61\)\},\n\)/);
});
