import assert from "node:assert/strict";
import { test } from "node:test";

import { worthListing } from "../../service/explorer/js/page/recent.js";

const jobs = (states) => states.map((state, id) => ({ id: String(id), state }));

test("of the latest jobs those are listed that there is something to see of", () => {
  const { listed, left } = worthListing(/** @type {any} */ (jobs(["running", "cancelled", "cancelling", "succeeded", "failed", "queued"])));
  assert.deepEqual(listed.map(({ state }) => state), ["running", "succeeded", "queued"]);
  assert.equal(left, 3);
});

test("zooms that were cancelled do not crowd out what was computed, and older jobs are not counted", () => {
  const states = [...Array(40).fill("cancelled"), ...Array(12).fill("succeeded"), "cancelled"];
  const { listed, left } = worthListing(/** @type {any} */ (jobs(states)));
  assert.deepEqual([listed.length, left], [10, 40]);
});
