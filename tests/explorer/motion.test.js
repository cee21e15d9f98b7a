import assert from "node:assert/strict";
import { afterEach, test } from "node:test";

import { followMotion } from "../../service/explorer/js/net/motion.js";

const OSCILLATOR = { model: "impacting", damping: 0.6, eccentricity: 0.1, half_backlash: 0.6 };
const QUIET = { kind: "permanent_contact", name: "permanent contact", points: [] };
const { fetch } = globalThis;

/** A service whose motions fall quiet at a time; the periods that it was asked for. */
function service(quietFrom) {
  const asked = [];
  globalThis.fetch = async (_, { body }) => {
    const { periods } = JSON.parse(body);
    asked.push(periods);
    const found = periods > quietFrom ? quietFrom : null;
    return new Response(JSON.stringify({ time: [0, periods], contacts: [], permanent_from: found }));
  };
  return asked;
}

afterEach(() => (globalThis.fetch = fetch));

test("a motion that takes long to settle is shown before its end is known", async () => {
  const asked = service(100), seen = [];
  const motion = await followMotion(OSCILLATOR, { t: 0, v: 1, solution: QUIET }, (early) => {
    seen.push([early.ends, asked.length]);
  });
  assert.deepEqual(seen, [["is followed for 300 forcing periods", 1]]);
  assert.deepEqual(asked, [15, 300]);
  assert.match(motion.ends, /^ends in permanent contact after 0 impacts, 100\.00 forcing periods/);
  assert.deepEqual(motion.shown.time, [0, 15]);
});

test("a motion that settles soon is asked for and shown once", async () => {
  const asked = service(3);
  const motion = await followMotion(OSCILLATOR, { t: 0, v: 1, solution: QUIET }, () => assert.fail("shown twice"));
  assert.deepEqual(asked, [15]);
  assert.match(motion.ends, /3\.00 forcing periods/);
});
