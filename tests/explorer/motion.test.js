import assert from "node:assert/strict";
import { afterEach, test } from "node:test";

import { cellInWords, underPointer } from "../../service/explorer/js/look/explain.js";
import { endInWords, followMotion } from "../../service/explorer/js/net/motion.js";

const OSCILLATOR = { model: "impacting", damping: 0.6, eccentricity: 0.1, half_backlash: 0.6 };
const CHAOTIC = /** @type {any} */ ({ kind: "chaotic", name: "chaotic", points: [] });
const QUIET = { kind: "permanent_contact", name: "permanent contact", periods: 13.531, impacts: 36, first: null };
const RATTLES = { kind: "rattling", name: null, periods: 1000, impacts: 1637, first: null };
const PERIODIC = { kind: "periodic", name: "P(1,1,0)", periods: 58.25, impacts: 61, first: { name: "P(2,2,1)", periods: 14.85 } };
const { fetch } = globalThis;

afterEach(() => (globalThis.fetch = fetch));

test("a sentence says what the followed motion does, whatever its cell is", async () => {
  const asked = [];
  globalThis.fetch = async (path, { body }) => {
    asked.push([path, JSON.parse(body).start]);
    return new Response(JSON.stringify({ time: [0, 15], contacts: [], permanent_from: 13.531, end: QUIET }));
  };
  const motion = await followMotion(OSCILLATOR, /** @type {any} */ ({ t: 0.0233, v: 2.584, solution: CHAOTIC }));
  assert.equal(motion.ends, "ends in permanent contact after 36 impacts, 13.53 forcing periods (then bounces ever lower)");
  assert.deepEqual(asked, [["/v1/trajectories?end=true", { time: 0.0233, velocity: 2.584 }]]);
});

test("a motion that has settled on nothing still rattles, and one beside a saddle leaves it", () => {
  assert.equal(endInWords("impacting", RATTLES), "still rattles after 1637 impacts, 1000 forcing periods");
  assert.match(endInWords("impacting", PERIODIC), /^nearly repeats P\(2,2,1\) for 14\.85 forcing periods, leaves it, and ends in P\(1,1,0\) after 61 impacts, 58\.25 /);
  assert.match(endInWords("impacting", { ...QUIET, impacts: 1, periods: 2 }), /after 1 impact, 2 forcing periods/);
  assert.match(endInWords("piecewise_linear", QUIET), /contact never ends/);
});

test("of a cell it is said that it is its centre, and only where it does otherwise", () => {
  const orbit = /** @type {any} */ ({ kind: "periodic", name: "P(1,1,0)" });
  assert.equal(cellInWords(CHAOTIC, QUIET), " This cell's centre rattles chaotically without end.");
  assert.equal(cellInWords(orbit, QUIET), " This cell's centre ends in P(1,1,0).");
  assert.equal(cellInWords(orbit, PERIODIC), "");
  assert.equal(cellInWords({ ...CHAOTIC, kind: "permanent_contact", name: "permanent_contact" }, QUIET), "");
  assert.match(underPointer(CHAOTIC), /^This cell's centre: /);
});

test("an impact leaves a part of its speed", async () => {
  const contacts = [{ time: 1, wall: 1, direction: "impact", speed: 2 }, { time: 2, wall: -1, direction: "impact", speed: 1 }];
  globalThis.fetch = async () => new Response(JSON.stringify({ time: [0, 15], contacts, permanent_from: null, end: RATTLES }));
  const { departures } = await followMotion({ ...OSCILLATOR, restitution: 0.5 }, { t: 0, v: 3 });
  assert.deepEqual(departures, [{ t: 0, v: 3 }, { t: 1, v: 1 }]);
  const elastic = await followMotion(OSCILLATOR, { t: 0, v: 3 });
  assert.deepEqual(elastic.departures, [{ t: 0, v: 3 }, { t: 1, v: 2 }]);
});
