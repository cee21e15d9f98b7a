import assert from "node:assert/strict";
import { test } from "node:test";

import { outdoes, Stack } from "../../service/explorer/js/plane/stack.js";

const WHOLE = { t0: 0, t1: 1, v0: 0, v1: 7 };

/** A picture of so many cells each way. */
function picture(cells, view = WHOLE, more = {}) {
  return { view, cellTime: (view.t1 - view.t0) / cells, cellVelocity: (view.v1 - view.v0) / cells, quick: false, empty: false, whole: false, ...more };
}

test("a coarse preview does not replace a finer one of what it shows", () => {
  const fine = picture(256), stack = new Stack();
  stack.offer(fine);
  for (const coarse of [picture(96, WHOLE, { quick: true }), picture(128), picture(64, { t0: 0.2, t1: 0.7, v0: 1, v1: 4 })]) stack.offer(coarse);
  assert.equal(stack.preview, fine);
});

test("a preview of other places, of smaller cells or with final names is shown", () => {
  const fine = picture(256);
  const zoom = { t0: 0.2, t1: 0.4, v0: 1, v1: 2 };
  for (const newer of [picture(96, { ...WHOLE, v1: 14 }), picture(96, zoom), picture(256, { t0: 0.9, t1: 1.1, v0: 0, v1: 1 })]) {
    const stack = new Stack();
    stack.offer(fine);
    stack.offer(newer);
    assert.equal(stack.preview, newer);
  }
  assert.ok(!outdoes(picture(256, WHOLE, { quick: true }), picture(128)));
  assert.ok(!outdoes(picture(256, zoom), picture(96)));
  // A period of it begins at any phase; of less than a period the phases count.
  assert.ok(outdoes(fine, picture(96, { t0: 0.6, t1: 1.6, v0: 0, v1: 7 })));
  assert.ok(outdoes(picture(256, zoom), picture(64, { t0: 1.2, t1: 1.4, v0: 1, v1: 2 })));
  assert.ok(!outdoes(picture(256, zoom), picture(64, { t0: 0.3, t1: 0.5, v0: 1, v1: 2 })));
});

test("a finished basin is not covered by a preview of its window, but by one of a part of it", () => {
  const finished = picture(60, WHOLE, { whole: true }), coming = picture(500, WHOLE, { empty: true });
  const stack = new Stack();
  stack.jobs = [finished, coming];
  const over = (preview) => ((stack.preview = preview), stack.drawn.indexOf(preview) > stack.drawn.indexOf(finished));
  assert.ok(!over(picture(96, WHOLE, { quick: true })));
  assert.ok(over(picture(96, { t0: 0.2, t1: 0.4, v0: 1, v1: 2 })));
  finished.whole = false;
  assert.ok(over(picture(96)));
});
