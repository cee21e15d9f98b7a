import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { knowAdditions } from "../../service/explorer/js/state/additions.js";
import { withOne } from "../../service/explorer/js/state/annotations.js";
import { decode, doubts, encode } from "../../service/explorer/js/state/address.js";

knowAdditions(JSON.parse(readFileSync(new URL("additions.json", import.meta.url), "utf8")));

const REQUEST = {
  oscillator: { model: "impacting", damping: 0.6, eccentricity: 0.1, half_backlash: 0.6 },
  grid: { time: { start: 0, stop: 1, cells: 500 }, velocity: { start: 0, stop: 7, cells: 400 } },
  iterations: 1499,
};
const SPRINGS = { ...REQUEST, oscillator: { ...REQUEST.oscillator, model: "piecewise_linear", stiffness: 1e4, permanent_contact: "one_rotation", allow_no_quiet_solution: true } };
const PROVEN = { ...REQUEST, prove: true };
const WITHIN = { ...REQUEST, prove: { levels: 0, tolerances: { damping: [0.59, 0.61], phase_2: [0, 0.25] } } };
const SWEEP = { ...REQUEST, vary: [{ parameter: "damping", values: [0.5, 0.6, 0.7] }] };

for (const [name, request] of Object.entries({ impacts: REQUEST, springs: SPRINGS, sweep: SWEEP, proven: PROVEN, within: WITHIN })) {
  test(`an address holds the whole of what is seen: ${name}`, () => {
    const seen = {
      job: "abc", panel: 2, request, view: { t0: 0.25, t1: 0.5, v0: 1, v1: 2 }, whole: { t0: 0, t1: 1, v0: 0, v1: 6 },
      layer: "step", palette: "paper", overlays: ["grazing", "saddles"], motions: [[0.5, 3], [0.125, 2]],
      beside: null, part: 0.5, compare: "swipe", machine: null, highlight: "P(1,1,0)", embed: true, axes: "machine",
      charts: {
        diagram: { parameter: "damping", x: [0.55, 0.6], y: [2, 5], job: "ghi" }, orbits: { x: null, y: null, job: "jkl" },
        parameters: { parameter: "damping,eccentricity", x: [0.75, 0.78], y: [0.094, 0.0995], job: "mno" },
        shares: { x: [0.5, 0.6], y: [0, 0.5] }, power: null,
      },
      annotated: { notes: [{ t: 0.3, v: 4.1, label: "a fold, here & “there” +5 %" }, { t: 0.5, v: 2, label: "" }], measures: [{ t0: 0.1, v0: 1, t1: -0.25, v1: 2.5, label: null }, { t0: 0, v0: 1, t1: 1, v1: 2, label: "" }, { t0: 0, v0: 3, t1: 1, v1: 2, label: "a, b" }] },
    };
    assert.deepEqual(decode(encode(seen)), seen);
  });
}

for (const [number, request] of JSON.parse(readFileSync(new URL("full_requests.json", import.meta.url), "utf8")).entries()) {
  test(`an address holds every field of a request, with no value at its default: ${number}`, () => {
    assert.deepEqual(decode(encode({ request })).request, request);
  });
}

test("a basin that is kept beside another has an address of its own within that of the page", () => {
  const beside = { job: "def", panel: 1, request: SPRINGS, motions: [[0.25, 1]] };
  const seen = decode(encode({ job: "abc", request: REQUEST, motions: [[0.5, 3]], beside, part: 0.3, compare: "side" }));
  assert.deepEqual([seen.job, seen.request, seen.motions, seen.part, seen.compare], ["abc", REQUEST, [[0.5, 3]], 0.3, "side"]);
  const { job, panel, request, motions } = seen.beside;
  assert.deepEqual({ job, panel, request, motions }, beside);
});

test("a sweep is written by its values however it was asked for", () => {
  const spaced = { ...REQUEST, vary: [{ parameter: "damping", start: 0.5, stop: 0.7, count: 3 }] };
  assert.deepEqual(decode(encode({ request: spaced })).request.vary, [{ parameter: "damping", values: [0.5, 0.6, 0.7] }]);
});

test("links of earlier versions are read: a job, a basin of a sweep, a window", () => {
  const seen = decode("?job=0123&panel=3&window=0.1,0.2,3,4");
  assert.deepEqual([seen.job, seen.panel, seen.view, seen.request], ["0123", 3, { t0: 0.1, t1: 0.2, v0: 3, v1: 4 }, null]);
});

test("what is usual is not written, and no overlays are something else than the usual ones", () => {
  const usual = decode("");
  assert.equal(encode(usual), "");
  assert.deepEqual(usual.overlays, ["proven", "grazing", "attractors"]);
  assert.deepEqual(decode(encode({ request: REQUEST, overlays: [] })).overlays, []);
});

test("the window of the request itself is not written twice", () => {
  const view = { t0: 0, t1: 1, v0: 0, v1: 7 };
  assert.doesNotMatch(encode({ request: REQUEST, view, whole: view }), /window|whole/);
});

test("what is no window, no motion or no request is left out", () => {
  const seen = decode("?window=1,0,3,4&motion=a,b&motion=0.5&grid=0,1,0&cells=5,5&k=7");
  assert.deepEqual([seen.view, seen.motions, seen.request], [null, [], null]);
});

test("what is not known falls back to what is usual, and is said", () => {
  const search = "?palette=bar&layer=foo&overlays=grazing,moon&damping=x&vary=damping,0.6";
  const seen = decode(search);
  assert.deepEqual([seen.palette, seen.layer, seen.overlays, seen.request], ["colour_blind", "solution", ["grazing"], null]);
  const [sentence, ...more] = doubts(search);
  for (const part of ["palette=bar", "layer=foo", "overlays=moon", "damping=x", "vary=damping,0.6"]) assert.ok(sentence.includes(part), part);
  assert.deepEqual(more, []);
  assert.deepEqual(doubts(encode({ request: SWEEP, layer: "step", palette: "paper", overlays: ["saddles"] })), []);
});

test("a partial address is completed: it shows the machine that it names", () => {
  const { request } = decode("?damping=0.3&eccentricity=0.05");
  assert.deepEqual(request.oscillator, { model: "impacting", damping: 0.3, eccentricity: 0.05, half_backlash: 0.6 });
  assert.deepEqual(request.grid.velocity, { start: 0, stop: 7, cells: 250 });
  assert.match(doubts("?damping=0.3&eccentricity=0.05")[0], /lacks half_backlash, grid, cells, k/);
  assert.equal(decode("?model=piecewise_linear").request.oscillator.stiffness, 1000);
});

test("a sweep of one value is none", () => {
  assert.equal(decode(encode({ request: REQUEST }) + "&vary=damping,0.6").request.vary, undefined);
});

test("a chart in an address needs a parameter that there is and ranges that rise; else it is left out, and told", () => {
  const wrong = ["diagram=speed,0,1", "diagram=damping,0.6,0.5", "diagram=damping,0.5", "diagram=damping,a,b", "orbits=yes", "shares=0,1,1,0"];
  for (const field of wrong) {
    const { charts } = decode(`?${field}`);
    assert.deepEqual([charts.diagram, charts.orbits, charts.shares], [null, null, null], field);
    assert.ok(doubts(`?${field}`)[0].includes(field), field);
  }
  const search = "?diagram=phase_2,0,1&orbits=1&orbits_job=x&power=0.5,0.6,0,1";
  assert.deepEqual(doubts(search), []);
  assert.deepEqual(decode(search).charts.diagram, { parameter: "phase_2", x: [0, 1], y: null, job: null });
  assert.deepEqual(decode(search).charts.orbits, { x: null, y: null, job: "x" });
});

test("nothing to say is no address", () => {
  assert.equal(encode({}), "");
});

test("whatever an address cannot mean is named, and the usual is taken", () => {
  const bad = "?damping=0.6&eccentricity=0.1&half_backlash=0.6&grid=0,1,7,0&cells=0,5&k=1.5&window=a&harmonics=x&permanent_contact=ever&motion=1&part=9&vary=nonsense,1,2&vary=damping,0.5";
  const [sentence] = doubts(bad);
  for (const text of ["grid=0,1,7,0", "cells=0,5", "k=1.5", "window=a", "harmonics=x", "permanent_contact=ever", "motion=1", "part=9", "vary=nonsense,1,2", "vary=damping,0.5"]) assert.ok(sentence.includes(text), text);
  const { request, view, motions, part } = decode(bad);
  assert.deepEqual([request.grid.velocity.stop, request.grid.time.cells, request.iterations, request.vary, view, motions, part], [7, 250, 1499, undefined, null, [], 0.5]);
  assert.equal(decode("?model=piecewise_linear&permanent_contact=ever").request.oscillator.permanent_contact, "envelope");
  assert.deepEqual(decode("?damping=0.6&harmonics=2:0.01&vary=phase_2,0,0.5").request.vary, [{ parameter: "phase_2", values: [0, 0.5] }]);
});

test("an address that names no oscillator is completed, and says so", () => {
  const [sentence] = doubts("?grid=0,1,0,7&cells=50,50&k=61");
  assert.match(sentence, /lacks damping, eccentricity, half_backlash/);
  assert.equal(decode("?grid=0,1,0,7&cells=50,50&k=61").request.oscillator.damping, 0.6);
});

test("annotations that cannot be read are left out and told, and there are at most twenty of each", () => {
  const written = "?note=0.3,x,here&note=0.3&note=0.25,4,kept&measure=1,2,3&measure=0.1,1,0.2,2";
  const { annotated } = decode(written);
  assert.match(doubts(written)[0], /: note=0.3,x,here, note=0.3, measure=1,2,3\.$/);
  assert.deepEqual(annotated, { notes: [{ t: 0.25, v: 4, label: "kept" }], measures: [{ t0: 0.1, v0: 1, t1: 0.2, v1: 2, label: null }] });
  const many = `?${"note=0.5,1&".repeat(30)}`;
  assert.equal(decode(many).annotated.notes.length, 20);
  assert.equal(withOne(decode(many).annotated.notes, { t: 0, v: 0, label: "" }).length, 20);
});
