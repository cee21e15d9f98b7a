import assert from "node:assert/strict";
import { test } from "node:test";

import { proofInWords, REASONS } from "../../service/explorer/js/look/explain.js";
import { Proof } from "../../service/explorer/js/plane/proof.js";

const QUIET = { kind: "permanent_contact", name: "permanent contact" };
const RATTLE = { kind: "periodic", name: "P(1,1,0)" };
const CHAOS = { kind: "chaotic", name: "chaotic" };

/** A proof of cells as [parts, reason]. */
function proofOf(cells) {
  const proof = new Proof(cells.length);
  cells.forEach(([parts, reason], i) => {
    proof.proven[i] = parts;
    proof.reason[i] = reason;
  });
  return proof;
}

test("shares are counted by motion and by reason, and add up to one", () => {
  const proof = proofOf([[64, 0], [48, 3], [0, 2], [64, 0], [0, 1]]);
  const { proven, reasons, tried } = proof.shares(Int16Array.from([0, 0, 1, 1, 1]), 3);
  assert.deepEqual(proven, [(64 + 48) / 320, 64 / 320, 0]);
  assert.deepEqual(reasons.map(({ share }) => share), [64 / 320, 64 / 320, 16 / 320, 0]);
  assert.deepEqual(reasons.map(({ reason }) => reason), [1, 2, 3, 4]);
  assert.ok(tried);
  const all = [...proven, ...reasons.map(({ share }) => share)].reduce((sum, each) => sum + each, 0);
  assert.ok(Math.abs(all - 1) < 1e-12);
});

test("cells that are not here do not count, and those not tried yet are not proven", () => {
  const proof = proofOf([[64, 0], [64, 0]]);
  assert.deepEqual(proof.shares(Int16Array.from([0, -1]), 1).proven, [1]);
  const fresh = new Proof(2);
  const { proven, tried } = fresh.shares(Int16Array.from([0, 0]), 1);
  assert.deepEqual([proven, tried], [[0], false]);
  assert.deepEqual(fresh.at(0), { parts: 0, reason: null });
  assert.equal(fresh.unproven(0), 1);
});

test("without any cell there are no shares, and no NaN", () => {
  assert.deepEqual(new Proof(0).shares(new Int16Array(0), 2).proven, [0, 0]);
});

test("a proven cell says what all of its departures come to", () => {
  const whole = proofOf([[64, 0]]).at(0);
  assert.equal(proofInWords(whole, QUIET), "Proven: every departure of this cell falls quiet.");
  assert.equal(proofInWords(whole, RATTLE), "Proven: every departure of this cell ends in P(1,1,0).");
  assert.match(proofInWords(whole, CHAOS), /comes to rattle for ever/);
});

test("a cell that is not proven says why, and how much of it is", () => {
  const proof = proofOf([[0, 3], [48, 2], [0, 255]]);
  assert.match(proofInWords(proof.at(0), QUIET), /^Not proven: this cell straddles grazing/);
  assert.match(proofInWords(proof.at(1), QUIET), /^Proven for 48 of 64 parts of this cell\. The rest spreads too wide/);
  assert.equal(proofInWords(proof.at(2), QUIET), "Not proven: it was not tried yet.");
  assert.deepEqual(Object.keys(REASONS), ["1", "2", "3", "4"]);
});
