import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { maskInWords } from "../../service/explorer/js/look/explain.js";
import { Masked } from "../../service/explorer/js/plane/masked.js";
import { knowAdditions, maskOf } from "../../service/explorer/js/state/additions.js";
const additions = JSON.parse(readFileSync(new URL("additions.json", import.meta.url), "utf8"));
const [{ mask }] = additions;

const QUIET = { kind: "permanent_contact", name: "permanent contact" };
const RATTLE = { kind: "periodic", name: "P(1,1,0)" };
const CHAOS = { kind: "chaotic", name: "chaotic" };

/** A mask over cells as [parts, reason]. */
function over(cells) {
  const masked = new Masked(mask, cells.length);
  cells.forEach(([parts, reason], i) => {
    masked.clear[i] = parts;
    masked.reason[i] = reason;
  });
  return masked;
}

test("a basin has the mask that its outline has the field of", () => {
  knowAdditions(additions);
  assert.equal(maskOf({ proof: true }), mask);
  assert.equal(maskOf({ proof: false }), null);
  assert.equal(maskOf({}), null);
});

test("shares are counted by motion and by reason, and add up to one", () => {
  const masked = over([[64, 0], [48, 3], [0, 2], [64, 0], [0, 1]]);
  const { clear, reasons, tried } = masked.shares(Int16Array.from([0, 0, 1, 1, 1]), 3);
  assert.deepEqual(clear, [(64 + 48) / 320, 64 / 320, 0]);
  assert.deepEqual(reasons.map(({ share }) => share), [64 / 320, 64 / 320, 16 / 320, 0, 0]);
  assert.deepEqual(reasons.map(({ reason }) => reason), [1, 2, 3, 4, 5]);
  assert.ok(tried);
  const all = [...clear, ...reasons.map(({ share }) => share)].reduce((sum, each) => sum + each, 0);
  assert.ok(Math.abs(all - 1) < 1e-12);
});

test("cells that are not here do not count, and those not tried yet are not proven", () => {
  const masked = over([[64, 0], [64, 0]]);
  assert.deepEqual(masked.shares(Int16Array.from([0, -1]), 1).clear, [1]);
  const fresh = new Masked(mask, 2);
  const { clear, tried } = fresh.shares(Int16Array.from([0, 0]), 1);
  assert.deepEqual([clear, tried], [[0], false]);
  assert.deepEqual(fresh.at(0), { parts: 0, reason: null });
  assert.equal(fresh.veiled(0), 1);
});

test("without any cell there are no shares, and no NaN", () => {
  assert.deepEqual(new Masked(mask, 0).shares(new Int16Array(0), 2).clear, [0, 0]);
});

test("a proven cell says what all of its departures come to", () => {
  const whole = over([[64, 0]]).at(0);
  assert.equal(maskInWords(whole, QUIET, mask), "Proven: every departure of this cell falls quiet.");
  assert.equal(maskInWords(whole, RATTLE, mask), "Proven: every departure of this cell ends in P(1,1,0).");
  assert.match(maskInWords(whole, CHAOS, mask), /comes to rattle for ever/);
});

test("a cell that is not proven says why, and how much of it is", () => {
  const masked = over([[0, 3], [48, 2], [0, 255]]);
  assert.match(maskInWords(masked.at(0), QUIET, mask), /^Not proven: this cell straddles grazing/);
  assert.match(maskInWords(masked.at(1), QUIET, mask), /^Proven for 48 of 64 parts of this cell\. The rest spreads too wide/);
  assert.equal(maskInWords(masked.at(2), QUIET, mask), "Not proven: it was not tried yet.");
});
