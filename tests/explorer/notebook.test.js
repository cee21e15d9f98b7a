import assert from "node:assert/strict";
import { test } from "node:test";

import { linesBetween } from "../../service/explorer/js/look/python.js";
import { partsOf, withParts } from "../../service/explorer/js/page/notebook.js";
import { decode, encode } from "../../service/explorer/js/state/address.js";
import { OfFrame } from "../../service/explorer/js/state/entries.js";

const OSCILLATOR = { model: "impacting", damping: 0.6, eccentricity: 0.1, half_backlash: 0.6 };
const REQUEST = {
  oscillator: OSCILLATOR,
  grid: { time: { start: 0, stop: 1, cells: 250 }, velocity: { start: 0, stop: 7, cells: 200 } },
  iterations: 1499,
};
const SEEN = decode(encode({ request: REQUEST }));

/** Lines of Python that lead from one view to another, as a notebook notes them. */
function lines(before, now) {
  return linesBetween(before && partsOf(before), partsOf(now));
}

test("what changes is a line of Python for each part, and an address where there is no part for it", () => {
  const stiff = { ...OSCILLATOR, model: "piecewise_linear", stiffness: 1e-7, permanent_contact: "one_rotation", harmonics: [{ order: 2, amplitude: 0.01, phase: 0.25 }, { order: 3, amplitude: 0.004 }] };
  const view = { t0: 0.25, t1: 0.5, v0: 1, v1: 2 };
  const moved = { ...SEEN, request: { ...REQUEST, oscillator: stiff }, view, motions: [[0.5, 3]], highlight: "P(1,1,0)" };
  assert.deepEqual(lines(SEEN, moved), [
    "widget.oscillator = rattle.Oscillator(damping=0.6, eccentricity=0.1, half_backlash=0.6, stiffness=1e-7, permanent_after=1.0, harmonics=((2, 0.01, 0.25), (3, 0.004, 0),))",
    "widget.window = (0.25, 0.5, 1, 2)", "widget.departure = (0.5, 3)", 'widget.solution = "P(1,1,0)"',
  ]);
  assert.deepEqual(lines(moved, { ...moved, motions: [] }), ["widget.departure = None"]);
  const layered = { ...SEEN, layer: "step" };
  assert.deepEqual(lines(SEEN, layered), [`widget.address = "${encode(layered)}"`]);
  assert.deepEqual(lines(null, SEEN), [`widget.address = "${encode(SEEN)}"`]);
  assert.deepEqual(lines(SEEN, { ...SEEN, job: "abc" }), []);
});

test("a part that Python says takes the place of that which is seen, and leaves the others", () => {
  const address = encode({ ...SEEN, job: "abc", layer: "step", motions: [[0.5, 3], [0.1, 2]], highlight: "chaotic" });
  const shown = (parts) => decode(withParts(address, parts));
  const damped = { ...OSCILLATOR, damping: 0.7 };
  assert.deepEqual([shown({ oscillator: damped }).request.oscillator, shown({ oscillator: damped }).job], [damped, null]);
  const zoomed = shown({ window: [0.25, 0.5, 1, 2] });
  assert.deepEqual([zoomed.request.grid.velocity, zoomed.whole], [{ start: 1, stop: 2, cells: 200 }, { t0: 0, t1: 1, v0: 0, v1: 7 }]);
  assert.deepEqual(shown({ departure: [0.2, 1] }).motions, [[0.2, 1], [0.1, 2]]);
  assert.deepEqual([shown({ departure: null }).motions, shown({ solution: null }).highlight, shown({ solution: null }).job], [[], null, "abc"]);
  assert.equal(shown({ solution: "P(1,1,0)" }).layer, "step");
  assert.equal(withParts(address, { address: "?damping=0.7" }), "?damping=0.7");
});

test("a basin of a sweep of another oscillator is a basin", () => {
  const sweep = encode({ ...SEEN, panel: 1, request: { ...REQUEST, vary: [{ parameter: "damping", values: [0.5, 0.6] }] } });
  const { request, panel } = decode(withParts(sweep, { oscillator: OSCILLATOR }));
  assert.deepEqual([request.vary, panel], [undefined, 0]);
});

test("a frame has a history of its own", () => {
  const entries = new OfFrame();
  const turned = [];
  entries.whenTurned(() => turned.push(entries.address));
  entries.write("?a", false);
  entries.write("?b", true);
  entries.write("?c", true);
  entries.turn(-2);
  assert.deepEqual([entries.address, entries.hasEarlier, entries.hasLater], ["?a", false, true]);
  entries.turn(-1);
  entries.turn(1);
  entries.write("?d", true);
  assert.deepEqual([entries.address, entries.hasLater, turned], ["?d", false, ["?a", "?b"]]);
});
