import assert from "node:assert/strict";
import { test } from "node:test";

import { faultInWords, fieldsOf } from "../../service/explorer/js/panels/faults.js";

const told = (location, message, written = "") => faultInWords({ location: ["body", ...location], message }, written);

test("each error of a request belongs to its fields", () => {
  assert.deepEqual(fieldsOf(["body", "oscillator", "damping"]), ["damping"]);
  assert.deepEqual(fieldsOf(["body", "oscillator", "harmonics", 0, "order"]), ["harmonics"]);
  assert.deepEqual(fieldsOf(["body", "grid", "time", "stop"]), ["time.stop"]);
  assert.deepEqual(fieldsOf(["body", "grid", "time"]), ["time.start", "time.stop"]);
  assert.deepEqual(fieldsOf(["body", "vary", 0, "count"]), ["vary.count"]);
  assert.deepEqual(fieldsOf(["body", "vary", 0, "values", 0]), ["vary.start", "vary.stop"]);
  assert.deepEqual(fieldsOf(["body", "iterations"]), ["iterations"]);
  for (const whole of [["body"], ["body", "grid"], ["body", "oscillator"]]) assert.deepEqual(fieldsOf(whole), []);
});

test("types and settings of the service are not told", () => {
  assert.equal(told(["oscillator", "harmonics"], "Input should be a valid tuple", "abc"), "write order: amplitude, phase; as in 2: 0.01, 0.25; 3: 0.004");
  assert.equal(told(["oscillator", "harmonics", 1, "order"], "Input should be greater than or equal to 2"), "the order of harmonic 2 must be at least 2");
  assert.equal(told(["oscillator", "harmonics", 0, "order"], "Input should be a valid integer"), "the order of harmonic 1 must be a whole number");
  assert.equal(told(["oscillator", "harmonics"], "order 2 is there twice: add the two up"), "order 2 is there twice: add the two up");
  assert.equal(told(["oscillator", "damping"], "Input should be a valid number", "much"), "not a valid number: write one as 0.6");
  assert.equal(told(["grid", "time", "cells"], "Input should be a valid integer", "10.5"), "not a whole number: write one as 500");
  assert.equal(told(["iterations"], "Input should be a valid integer", ""), "not a whole number: write one as 500");
  assert.equal(told(["oscillator", "half_backlash"], "Input should be greater than 0", "0"), "must be above 0");
  assert.equal(told(["oscillator", "restitution"], "Input should be less than or equal to 1", "2"), "must be at most 1");
  assert.equal(told([], "9 cells or points are more than the limit of 4 (RATTLE_MAX_CELLS)"), "9 cells or points are more than the limit of 4");
  assert.doesNotMatch(told(["oscillator", "eccentricity"], "eccentricity must be below 0.19: beyond it there is no quiet solution; allow_no_quiet_solution takes it all the same", "0.3"), /_/);
});
