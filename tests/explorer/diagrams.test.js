import assert from "node:assert/strict";
import { test } from "node:test";

import { byMotion } from "../../service/explorer/js/panels/branches.js";

test("points of a diagram go by the motion at their value, not by the one that their branch began with", () => {
  const point = (visit, velocity) => ({ visit, seed: 0, kept: 0, velocity, seed_name: "P(4,4,2)" });
  const named = [{ visit: 0, seed: 0, name: "P(4,4,2)" }, { visit: 1, seed: 0, name: "no period seen" }, { visit: 2, seed: 0, name: "permanent contact" }];
  const motions = byMotion([point(0, 4.7), point(1, 4.1), point(1, 3.9), point(2, null)], named);
  assert.deepEqual([...motions].map(([name, rows]) => [name, rows.length]), [["P(4,4,2)", 1], ["no period seen", 2]]);
});
