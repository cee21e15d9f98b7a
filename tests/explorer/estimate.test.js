import assert from "node:assert/strict";
import { test } from "node:test";

import { busyness, partTaken, secondsInWords } from "../../service/explorer/js/look/estimate.js";

test("cells that settle take a preview's iterations, the others all of them", () => {
  const solutions = [{ kind: "permanent_contact", share: 0.7 }, { kind: "periodic", share: 0.05 }, { kind: "chaotic", share: 0.25 }];
  const part = partTaken(solutions, 127 / 1499);
  assert.ok(Math.abs(part - (0.25 + (0.75 * 127) / 1499)) < 1e-12);
  assert.equal(partTaken(solutions, 3), 1, "never more than all");
});

test("what is known by a preview is about so long, and the service's own number is the most", () => {
  assert.equal(secondsInWords(39, 0.3, 1), "About 12 s of computing.");
  assert.equal(secondsInWords(39, null, 1.2), "Up to about 47 s of computing.");
  assert.equal(secondsInWords(600, 0.5, 1), "About 5 minutes of computing.");
  assert.equal(secondsInWords(3, 0.3, 1), "Less than a second of computing.");
});

test("on a busy machine it takes as many times longer as the preview did, and that is said", () => {
  assert.equal(busyness("wall;dur=1200.0, cpu;dur=300.0"), 4);
  assert.equal(busyness(null), 1);
  assert.equal(busyness("wall;dur=20.0, cpu;dur=20.1"), 1, "never less than alone");
  assert.equal(secondsInWords(6, 0.5, 4), "About 12 s of computing: the machine is busy.");
});
