import assert from "node:assert/strict";
import { test } from "node:test";

import { byMotion, markAt } from "../../service/explorer/js/panels/branches.js";

test("points of a diagram go by the motion at their value, not by the one that their branch began with", () => {
  const point = (visit, velocity) => ({ visit, seed: 0, kept: 0, velocity, seed_name: "P(4,4,2)" });
  const named = [{ visit: 0, seed: 0, name: "P(4,4,2)" }, { visit: 1, seed: 0, name: "no period seen" }, { visit: 2, seed: 0, name: "permanent contact" }];
  const motions = byMotion([point(0, 4.7), point(1, 4.1), point(1, 3.9), point(2, null)], named);
  assert.deepEqual([...motions].map(([name, rows]) => [name, rows.length]), [["no period seen", 2], ["P(4,4,2)", 1]]);
});

test("motions come in the order in which they take colours, without those that are not known", () => {
  const names = ["P(10,12,3)", "P(4,4,2)", "no period seen", "", "P(3,4,2)"];
  const rows = names.map((_, visit) => ({ visit, seed: 0, velocity: 1 }));
  const named = names.map((name, visit) => ({ visit, seed: 0, name, impact_period: 1 }));
  assert.deepEqual([...byMotion(rows, named).keys()], ["no period seen", "P(3,4,2)", "P(4,4,2)", "P(10,12,3)"]);
});

test("where there are too many motions for names, those that repeat are not called chaos", () => {
  const rows = [0, 1, 2].map((visit) => ({ visit, seed: 0, velocity: 1 }));
  const named = [4, 0, 1].map((impact_period, visit) => ({ visit, seed: 0, impact_period }));
  assert.deepEqual([...byMotion(rows, named).keys()], ["no period seen", "repeats after 1 impact", "repeats after 4 impacts"]);
});

test("where colours come again, marks differ", () => {
  assert.equal(new Set([0, 1, 2, 3].map((texture) => markAt(10, 20, texture))).size, 4);
});
