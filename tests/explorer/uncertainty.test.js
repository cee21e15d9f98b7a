import assert from "node:assert/strict";
import { test } from "node:test";

import { uncertaintyInWords } from "../../service/explorer/js/look/explain.js";

test("an uncertainty exponent is told with its error and what it means", () => {
  const words = uncertaintyInWords({ exponent: 0.301, error: 0.004 });
  assert.match(words, /exponent 0\.301 ± 0\.004/);
  assert.match(words, /2 times fewer are uncertain/);
  assert.match(uncertaintyInWords({ exponent: null, error: null }), /hardly any borders/);
});
