import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { axisTicks, grouped, percent, reading } from "../../service/explorer/js/charts/ticks.js";
import { stateInWords } from "../../service/explorer/js/jobs/words.js";
import { expectedInWords, loudnessInWords, numbersInWords, saddleInWords, solutionInWords } from "../../service/explorer/js/look/explain.js";
import { isBehind } from "../../service/explorer/js/net/follow.js";
import { linesOf } from "../../service/explorer/js/plane/curves.js";
import { keyOf, solutionPixels, usualSpeckle } from "../../service/explorer/js/plane/palette.js";
import { wrapped } from "../../service/explorer/js/plane/wrapping.js";
import { knowAdditions } from "../../service/explorer/js/state/additions.js";

knowAdditions(JSON.parse(readFileSync(new URL("additions.json", import.meta.url), "utf8")));

test("deep in a zoom labels stay short, and the title says what they have in common", () => {
  const from = 3.4012345;
  const { ticks, title } = axisTicks(from, from + 1e-6, 6);
  assert.ok(ticks.length >= 3);
  for (const { label } of ticks) assert.ok(label.length <= 6, label);
  assert.equal(new Set(ticks.map(({ label }) => label)).size, ticks.length);
  const [, common, exponent] = /= ([\d.]+) \+ … × 10⁻(.+)$/.exec(title);
  const power = Number([...exponent].map((digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹".indexOf(digit)).join(""));
  for (const { at, label } of ticks) assert.ok(Math.abs(Number(common) + Number(label) * 10 ** -power - at) < 1e-9);
});

test("a wide axis is labelled plainly", () => {
  const { ticks, title } = axisTicks(0, 7, 7);
  assert.deepEqual(ticks.map(({ label }) => label), ["0", "1", "2", "3", "4", "5", "6", "7"]);
  assert.equal(title, "");
});

test("labels move to the title only where they have more than four digits", () => {
  assert.equal(axisTicks(0, 0.0007, 7).title, "");
  assert.equal(axisTicks(3, 3.0007, 7).title, "");
  // Two ticks, half of 1e-4 apart.
  assert.equal(axisTicks(0.99996, 1.00008, 3).ticks.length, 2);
  assert.match(axisTicks(0.99996, 1.00008, 3).title, /10⁻⁴$/);
});

test("steps below 1 and coordinates have the digits that they need", () => {
  assert.deepEqual(axisTicks(0, 1, 5).ticks.map(({ label }) => label), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
  assert.deepEqual([[1.23456789, 7], [1.23456789, 0.1], [1.23456789, 1e-4], [1.23456789, 1e-30]].map(([at, width]) => reading(at, width)), ["1.235", "1.2346", "1.2345679", "1.234567890000"]);
});

test("shares and counts are written for readers", () => {
  assert.deepEqual([0, 0.00005, 0.0001, 0.12345, 1].map(percent), ["0 %", "< 0.01 %", "0.01 %", "12.35 %", "100.00 %"]);
  assert.deepEqual([0, 999, 1000, 1234567.4].map(grouped), ["0", "999", "1\u202f000", "1\u202f234\u202f567"]);
});

test("a motion is explained in a sentence", () => {
  assert.equal(solutionInWords({ kind: "periodic", name: "P(1,1,0)" }), "P(1,1,0) repeats every forcing period, with 1 contact at +β and no contacts at −β.");
  assert.equal(solutionInWords({ kind: "periodic", name: "P(3,3,2)" }), "P(3,3,2) repeats every 3 forcing periods, with 3 contacts at +β and 2 contacts at −β.");
  assert.match(solutionInWords({ kind: "periodic", name: "P(1,1,0)*" }), /^P\(1,1,0\)\* repeats .* at −β\. In every turn it comes to rest on a wall\.$/);
  assert.match(solutionInWords({ kind: "chaotic", name: "chaotic" }), /never repeats/);
});

test("Hsu's numbers are told as far as a cell has them", () => {
  assert.equal(numbersInWords({ step: 19, group: 3, period: 6 }), "step 19, group 3, period 6");
  assert.equal(numbersInWords({ step: 1, group: -1, period: 0 }), "step 1, in no cycle of cells");
  assert.equal(numbersInWords({ step: 4, group: -2, period: 0 }), "step 4, in no cycle of cells");
  assert.equal(numbersInWords({ step: 2, group: 0, period: 0 }), "step 2, then out of all cells");
});

test("a saddle is named before the cell that it lies on", () => {
  const told = saddleInWords("saddle P(1,1,0)", { kind: "chaotic", name: "chaotic" });
  assert.match(told, /^Saddle P\(1,1,0\): a motion that repeats, but that motions beside it leave\. This cell's centre: Chaos/);
  assert.doesNotMatch(saddleInWords("saddle P(1,1,0)", undefined), /cell/);
});

test("loudness is told in words, and what is undecided is named", () => {
  const chaos = { impacts_per_period: 1.6307, largest_impact_speed: 4.7802, impact_power: 10.702 };
  const soft = { ...chaos, time_in_contact: 0.0314 };
  assert.match(loudnessInWords(soft), /impact power 10\.7, teeth touch 3\.14 % of the time$/);
  assert.match(loudnessInWords({ ...chaos, time_in_contact: 0 }), /impact power 10\.7$/);
  assert.equal(loudnessInWords(chaos), "1.63 impacts a forcing period, the fastest at 4.78, impact power 10.7");
  assert.match(loudnessInWords({ impacts_per_period: 1, largest_impact_speed: 3.77, impact_power: 7.1 }), /^1 impact a/);
  assert.equal(loudnessInWords({ impacts_per_period: 0, largest_impact_speed: 0, impact_power: 0 }), "no impacts");
  assert.equal(loudnessInWords({ impacts_per_period: null, largest_impact_speed: null, impact_power: null }), "");
  assert.doesNotMatch(expectedInWords({ ...chaos, undecided_share: 0 }), /undecided/);
  assert.match(expectedInWords({ ...chaos, undecided_share: 0.05 }), /; 5(\.\d+)? ?% undecided, counted as silent\.$/);
});

test("events older than what is known of a job are behind", () => {
  const progress = (stage, tiles_done, basins_done = 0) => ({ stage, tiles_done, tiles_total: 16, basins_done, basins_total: 1 });
  const job = { state: "running", progress: progress("mapping", 4) };
  assert.ok(isBehind({ state: "queued", progress: null }, job));
  assert.ok(isBehind({ state: "running", progress: null }, job));
  assert.ok(isBehind({ state: "running", progress: progress("mapping", 0) }, job));
  assert.ok(!isBehind({ state: "running", progress: progress("mapping", 4) }, job));
  assert.ok(!isBehind({ state: "succeeded", progress: null }, job));
  assert.ok(!isBehind({ state: "queued", progress: null }, { state: "queued", progress: null }));
  const compiling = { state: "running", progress: progress("compiling", 0) };
  assert.ok(isBehind(compiling, job));
  assert.ok(!isBehind({ state: "running", progress: progress("mapping", 1) }, compiling));
});

test("a job whose workers compile says so", () => {
  const progress = { stage: "compiling", tiles_done: 0, tiles_total: 16, basins_done: 0, basins_total: 1, seconds_left: null };
  assert.equal(stateInWords({ state: "running", progress }).text, "Compiling kernels, a minute or so: 0 of 16 tiles.");
});

test("each state of a job has its words, and only a failure is an error", () => {
  const error = { detail: "tile 3 failed" };
  const told = [
    [{ state: "queued" }, 3, "Waiting: number 3 in the queue."], [{ state: "queued" }, 1, "Waiting: next in the queue."],
    [{ state: "queued" }, null, "Waiting: next in the queue."], [{ state: "running", progress: null }, null, "Beginning."],
    [{ state: "cancelling" }, null, "Stopping."], [{ state: "cancelled" }, null, "Cancelled; what had been computed is shown."],
    [{ state: "failed", error }, null, "Failed: tile 3 failed"], [{ state: "failed", error: null }, null, "Failed: see the service's log"],
  ];
  for (const [job, place, text] of told) assert.deepEqual(stateInWords(job, place), { text, wrong: job.state === "failed" });
});

test("a speed is told where cells are mapped, and where it is known", () => {
  const progress = { stage: "mapping", tiles_done: 3, tiles_total: 16, basins_done: 1, basins_total: 2, seconds_left: null };
  const told = (more) => stateInWords({ state: "running", progress: { ...progress, ...more } }).text;
  assert.equal(told({ cells_per_second: 12345 }), "Mapping cells: 3 of 16 tiles, 1 of 2 basins complete, 12\u202f345 cells a second.");
  assert.doesNotMatch(told({ cells_per_second: null }), /second/);
  assert.doesNotMatch(told({ cells_per_second: 12345, stage: "labelling" }), /second/);
});

test("seconds that are left are rounded up, those that it took to a tenth", () => {
  const progress = { stage: "proving", tiles_done: 3, tiles_total: 16, basins_done: 0, basins_total: 1, seconds_left: 3.2 };
  assert.equal(stateInWords({ state: "running", progress }).text, "Proving cells: 3 of 16 tiles, about 4 s left.");
  const [started, finished] = ["2026-01-01T00:00:00.000Z", "2026-01-01T00:00:01.270Z"];
  assert.equal(stateInWords({ state: "succeeded", started, finished }).text, "Complete, in 1.3 s.");
});

function outline(names) {
  const solutions = names.map((name, number) => ({ number, name, kind: name, colours: { paper: "#804020" }, share: 1 }));
  return { solutions, speckle: [0.85, 1.05, 1.25, 1.45] };
}

test("a motion is known by its name, not by its number", () => {
  const twins = outline(["P(1,1,0)", "P(1,1,0)", "P(1,1,0)"]).solutions;
  assert.deepEqual([0, 1, 2].map((number) => keyOf(twins, number)), ["P(1,1,0)", "P(1,1,0) (2)", "P(1,1,0) (3)"]);
  const { solutions } = outline(["permanent_contact", "P(1,1,0)", "P(1,1,0)"]);
  assert.deepEqual(solutions.map(({ number }) => keyOf(solutions, number)), ["permanent_contact", "P(1,1,0)", "P(1,1,0) (2)"]);
});

test("chaos has its own colour wherever there are no groups, and in most cells everywhere", () => {
  const look = { palette: "paper", highlight: null, ground: "#ffffff", layer: "solution" };
  const known = outline(["permanent_contact", "chaotic"]);
  for (const usual of known.speckle.keys()) {
    // Most chaotic cells are of one group, whatever its number; some are of the next, and quiet ones of a third.
    const group = [...Array(9).fill(usual + 4), ...Array(3).fill(usual + 5), ...Array(20).fill(usual + 6)];
    const solution = [...Array(12).fill(1), ...Array(20).fill(0)];
    assert.equal(usualSpeckle(known, solution, group), usual);
    const pixels = [...solutionPixels(known, look, usual)].map((pixel) => pixel & 255);
    const [plain, ...speckled] = pixels.slice(5);
    assert.equal(plain, 0x80);
    assert.equal(speckled[usual], 0x80);
    assert.equal(new Set(speckled).size, 4);
  }
});

test("a label is broken where there is no room, and never within a value", () => {
  const label = "kept: Impacts: δ = 0.5, ε = 0.1, β = 0.6";
  const lengthOf = (text) => text.length;
  assert.deepEqual(wrapped(label, 100, lengthOf), [label]);
  assert.deepEqual(wrapped(label, 16, lengthOf), ["kept: Impacts:", "δ = 0.5,", "ε = 0.1, β = 0.6"]);
  assert.deepEqual(wrapped(label, 0, lengthOf), ["kept:", "Impacts:", "δ = 0.5,", "ε = 0.1,", "β = 0.6"]);
});

function plot(view) {
  const [left, top, width, height] = [50, 10, 1000, 500];
  return {
    view, left, top, width, height,
    x: (t) => left + ((t - view.t0) / (view.t1 - view.t0)) * width,
    y: (v) => top + ((view.v1 - v) / (view.v1 - view.v0)) * height,
  };
}

test("a curve of many points has no more of them than the screen shows", () => {
  const time = Array.from({ length: 100_000 }, (_, i) => i / 100_000), velocity = time.map(() => 3);
  const points = linesOf(plot({ t0: 0, t1: 1, v0: 0, v1: 7 }), [{ time, velocity }]).reduce((sum, line) => sum + line.length / 2, 0);
  // A point each 0.8 pixels, on the window and a window beside it on each side.
  assert.ok(points <= 3 * (1000 / 0.8) + 8, `${points}`);
});

test("what lies outside the window is left out, and a curve that enters it is whole there", () => {
  const view = { t0: 0.4, t1: 0.6, v0: 3, v1: 4 };
  assert.deepEqual(linesOf(plot(view), [{ time: [0.1, 0.2], velocity: [0.5, 0.6] }]), []);
  for (const [t, v] of [[0.37, 3.5], [0.63, 3.5], [0.5, 2.9], [0.5, 4.1]]) {
    assert.deepEqual(linesOf(plot(view), [{ time: [t, t + 0.001], velocity: [v, v] }]), [], "beside the window, where others are still drawn");
  }
  const [early, late] = [-0.5, 1.5].map((t) => linesOf(plot(view), [{ time: [t - 0.01, t + 0.01], velocity: [3.5, 3.5] }]));
  // A window 0.2 wide on 1000 pixels from 50 on: its middle is at 550.
  for (const lines of [early, late]) {
    assert.deepEqual(lines.map((one) => one.map(Math.round)), [[500, 260, 600, 260]], "a phase before or after the period is a phase of it");
  }
  const [line] = linesOf(plot(view), [{ time: [0, 0.5, 1], velocity: [3.5, 3.5, 3.5] }]);
  assert.equal(line.length, 6, "from the point before the window to the one after it");
});
