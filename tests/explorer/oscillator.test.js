import assert from "node:assert/strict";
import test from "node:test";

import { decode, encode } from "../../service/explorer/js/state/address.js";
import { harmonicParameters, harmonicsOf, harmonicsText, parameterInWords, valueIn, withValues } from "../../service/explorer/js/state/oscillator.js";

const HARMONICS = [{ order: 2, amplitude: 0.01, phase: 0.25 }, { order: 13, amplitude: 0.0004, phase: 0 }];

test("harmonics are read as they are written", () => {
  assert.deepEqual(harmonicsOf("2: 0.01, 0.25; 13: 0.0004"), HARMONICS);
  assert.deepEqual(harmonicsOf(harmonicsText(HARMONICS)), HARMONICS);
  assert.deepEqual(harmonicsOf(" "), []);
  assert.equal(harmonicsText([{ order: 3, amplitude: 0.5 }, { order: 4, amplitude: 0.25, phase: 0.125 }]), "3: 0.5; 4: 0.25, 0.125");
  assert.deepEqual([undefined, "3: x"].map(harmonicsText), ["", "3: x"]);
});

test("what cannot be read stays text, which the service refuses", () => {
  for (const text of ["2", "2: ", "2: a", "2: 0.1, 0.2, 0.3", "x: 0.1"]) assert.equal(harmonicsOf(text), text);
});

test("numbers of harmonics have names, and values of a sweep are put into them", () => {
  assert.deepEqual(harmonicParameters(HARMONICS), ["amplitude_2", "phase_2", "amplitude_13", "phase_13"]);
  assert.equal(parameterInWords("phase_13"), "phase φ₁₃");
  assert.equal(parameterInWords("damping"), "damping δ");
  const changed = withValues({ damping: 0.6, harmonics: HARMONICS }, { phase_2: 0.5, damping: 0.7 });
  assert.deepEqual([changed.damping, changed.harmonics[0].phase, changed.harmonics[1]], [0.7, 0.5, HARMONICS[1]]);
});

test("an oscillator has a value of each of its parameters, written into requests or not", () => {
  const oscillator = { damping: 0.6, restitution: 0.9, harmonics: HARMONICS };
  const values = ["damping", "restitution", "contact_damping", "amplitude_13", "phase_2", "phase_3"].map((name) => valueIn(oscillator, name));
  assert.deepEqual(values, [0.6, 0.9, 0, 0.0004, 0.25, undefined]);
  assert.equal(valueIn({ damping: 0.6 }, "restitution"), 1);
});

test("an address holds them", () => {
  const grid = { time: { start: 0, stop: 1, cells: 10 }, velocity: { start: 0, stop: 7, cells: 10 } };
  const request = { oscillator: { model: "impacting", damping: 0.6, eccentricity: 0.1, half_backlash: 0.6, restitution: 0.9, harmonics: HARMONICS }, grid, iterations: 101 };
  const seen = decode(encode({ request, view: null, whole: null }));
  assert.deepEqual(seen.request, request);
});
