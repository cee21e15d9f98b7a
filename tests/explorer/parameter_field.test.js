import assert from "node:assert/strict";
import { test } from "node:test";

import { curvesOf, fieldIn, shadesOf } from "../../service/explorer/js/panels/parameter_field.js";
import { parametersIn } from "../../service/explorer/js/state/charts.js";

const PAIR = ["damping", "eccentricity"];

function row(damping, response) {
  return { curve_damping: damping, curve_eccentricity: 0.1, curve_response: response };
}

test("rows of all curves follow each other, and a folding part is dashed and touches those beside it", () => {
  const told = [{ kind: "saddle-node", orbit: "P(1,1,0)", says: "born", points: 2 }, { kind: "grazing", orbit: "P(1,1,0)", says: "touches", points: 5 }];
  const rows = [row(0.5, null), row(0.6, null), row(0.7, 1), row(0.71, 2), row(0.72, -3), row(0.73, -1), row(0.74, 4)];
  const [born, graze] = curvesOf(told, rows, PAIR);
  assert.deepEqual(born.parts.map(({ words, dashed, places }) => [words, dashed, places.map(({ x }) => x)]), [["saddle-node of P(1,1,0)", false, [0.5, 0.6]]]);
  assert.deepEqual(graze.parts.map(({ words, dashed, places }) => [words, dashed, places.map(({ x }) => x)]), [
    ["grazing of P(1,1,0)", false, [0.7, 0.71]], ["folding grazing of P(1,1,0)", true, [0.71, 0.72, 0.73, 0.74]], ["grazing of P(1,1,0)", false, [0.74]],
  ]);
  assert.ok(graze.places.every(({ curve }) => curve.says === "touches"));
});

const MACHINES = [
  { damping: 0.5, eccentricity: 0.1, exponent: 0.2, quiet_share: 0.25, motion: "chaotic" },
  { damping: 0.6, eccentricity: 0.1, exponent: -0.1, quiet_share: 1, motion: "permanent contact" },
  { damping: 0.7, eccentricity: 0.1, exponent: null, quiet_share: null, motion: "" },
];

test("chaos and order have colours of their own, and a machine that is not followed none", () => {
  const { colours, key } = shadesOf("exponent", MACHINES, () => "");
  assert.equal(colours[2], "");
  assert.deepEqual(key.map(({ name }) => name), ["exponent −0.200", "exponent +0.200: chaos"]);
  assert.equal(colours[0], key[1].colour);
  assert.notEqual(colours[1], key[0].colour);
  const quiet = shadesOf("quiet_share", MACHINES, () => "");
  assert.equal(quiet.colours[1], quiet.key[1].colour);
  const named = shadesOf("motion", MACHINES, (name) => `colour of ${name}`);
  assert.deepEqual(named.colours, ["colour of chaotic", "colour of permanent contact", ""]);
  assert.deepEqual(named.key.map(({ name }) => name), ["chaotic", "permanent contact"]);
});

test("a place is described by the machine that is nearest to it", () => {
  const scene = { machines: MACHINES, pair: PAIR, whole: { x: [0.45, 0.75], y: [0.05, 0.15] } };
  assert.equal(fieldIn("exponent", scene, { x: 0.54, y: 0.12 }), "Largest exponent +0.200 per period: chaos.");
  assert.equal(fieldIn("quiet_share", scene, { x: 0.56, y: 0.12 }), "100 % of departures fall quiet.");
  assert.equal(fieldIn("motion", scene, { x: 0.5, y: 0.1 }), "What most departures end in that do not fall quiet: chaotic.");
  assert.equal(fieldIn("motion", scene, { x: 0.74, y: 0.1 }), "");
});

test("an address names two different parameters and what is seen of both", () => {
  assert.deepEqual(parametersIn("damping,phase_2,0.5,0.6,0,1"), { parameter: "damping,phase_2", x: [0.5, 0.6], y: [0, 1] });
  for (const text of ["damping,damping,0.5,0.6,0,1", "damping,0.5,0.6,0,1", "damping,eccentricity,0.5,0.6", "damping,eccentricity,0.6,0.5,0,1", "damping,backlash,0.5,0.6,0,1"]) {
    assert.equal(parametersIn(text), null, text);
  }
});
