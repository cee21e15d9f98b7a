import assert from "node:assert/strict";
import test from "node:test";

import { decode, encode } from "../../service/explorer/js/state/address.js";
import { axisUnit, gammaInWords, inUnits, machineIn, machineOf, parts, PUMP, tolerancesIn, writtenOf } from "../../service/explorer/js/state/machine.js";
import { loudnessInWords } from "../../service/explorer/js/look/explain.js";

test("a machine is asked for once all that it needs is written, and pure numbers are numbers", () => {
  const written = { ...PUMP, inertia_ratio: "0.5", mesh_stiffness: "", restitution: "0.8" };
  assert.deepEqual(machineOf(written), { ...PUMP, inertia_ratio: 0.5, restitution: 0.8 });
  assert.equal(machineOf({ ...written, backlash: "" }), null);
});

test("the machine of a job is written in units that make its numbers short, if there are fields for all of them", () => {
  const machine = { speed: 305, inertia: 0.01, inertia_ratio: 1, drag_torque: 0.0942, base_radius: 0.0571, backlash: 61e-6, transmission_error: { 1: { amplitude: 5.2e-6, phase: 0 } }, drag_law: "constant", turns: 1 };
  const written = { speed: "305 rad/s", inertia: "10 g m^2", inertia_ratio: "1", drag_torque: "94.2 mN m", base_radius: "57.1 mm", backlash: "61 um", transmission_error: "5.2 um" };
  assert.deepEqual(writtenOf(machine), written);
  assert.deepEqual(writtenOf({ ...machine, speed: 100 * Math.PI, mesh_stiffness: 3.1e7 }), { ...written, speed: "3000 rpm", mesh_stiffness: "31 N/um" });
  assert.equal(writtenOf({ ...machine, turns: 2 }), null);
  assert.equal(writtenOf({ ...machine, contact_damping: 0.1 }), null);
  assert.equal(writtenOf({ ...machine, transmission_error: { 1: { amplitude: 1e-6, phase: 0 }, 2: { amplitude: 1e-6, phase: 0 } } }), null);
});

test("a machine comes back from an address", () => {
  const there = encode({ machine: PUMP });
  assert.ok(!there.includes(" ") && there.includes("3000_rpm"));
  assert.deepEqual(decode(there).machine, PUMP);
  assert.equal(decode("").machine, null);
  assert.equal(machineIn("nonsense"), null);
  assert.deepEqual(parts("0.01 kg m^2"), { number: "0.01", unit: "kg m^2" });
});

test("units have the prefix that makes a number 1 to 1000", () => {
  assert.deepEqual([0.0204, 4.2, 1234, 3e-6, 0].map((each) => inUnits(each, "W")), ["20.4 mW", "4.2 W", "1.23 kW", "3 µW", "0 W"]);
});

test("what a machine's gamma means is said with the speed at which it reaches 1", () => {
  const answer = { gamma: 0.5238, threshold_speed: 434.1, can_be_quiet: true };
  assert.match(gammaInWords(/** @type {any} */ (answer)), /Γ = 0\.524\. It reaches 1 at 4145 rpm\./);
  assert.doesNotMatch(gammaInWords(/** @type {any} */ (answer)), /never quiet/);
  assert.match(gammaInWords(/** @type {any} */ ({ ...answer, gamma: 1.2, can_be_quiet: false })), /Γ = 1\.2\. It reaches 1 at 4145 rpm\. .* never quiet\./);
  assert.match(gammaInWords(/** @type {any} */ ({ ...answer, threshold_speed: null })), /never/);
});

test("a machine's loudness is in its own units", () => {
  const heard = { impacts_per_period: 2, largest_impact_speed: 0.5, impact_power: 0.1 };
  assert.equal(loudnessInWords(heard, { time: 0.02, speed: 0.1, power: 30 }), "100 impacts a second, the fastest at 50 mm/s, impact power 3 W");
  assert.match(loudnessInWords(heard), /2 impacts a forcing period/);
});

test("tolerances are written one after the other, and limits have one unit", () => {
  const text = "backlash = 120 +- 20 um, normal; restitution=0.8 to 1; base radius = 90 to 110 mm;transmission error = 8 um to 0.01 mm; transmission_error.2.phase = any;";
  assert.deepEqual(tolerancesIn(text), {
    backlash: "120 +- 20 um, normal", restitution: ["0.8", "1"], base_radius: ["90 mm", "110 mm"],
    "transmission_error.1.amplitude": ["8 um", "0.01 mm"], "transmission_error.2.phase": "any",
  });
  for (const wrong of ["backlash", "= 3", "backlash =", "a = b = c"]) assert.throws(() => tolerancesIn(wrong), /write “/);
});

test("an axis of a machine counts units by which its numbers are short", () => {
  assert.deepEqual(axisUnit(1, 0.02, "s"), { factor: 20, unit: "ms" });
  assert.deepEqual(axisUnit(7, 3, "m/s"), { factor: 3, unit: "m/s" });
  const { factor, unit } = axisUnit(0.001, 0.02, "s");
  assert.deepEqual([Number(factor.toPrecision(12)), unit], [20000, "µs"]);
});
