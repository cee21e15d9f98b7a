import assert from "node:assert/strict";
import { test } from "node:test";

import { Latest } from "../../service/explorer/js/net/latest.js";

/** Requests that are answered by hand. */
function asked() {
  const open = [], shown = [], failed = [];
  const latest = new Latest(
    (wish, signal) => new Promise((resolve, reject) => open.push({ wish, signal, resolve, reject })),
    (answer) => shown.push(answer),
    (error) => failed.push(error.message),
  );
  return { latest, open, shown, failed };
}

const settled = () => new Promise((resolve) => setImmediate(resolve));

test("one request is under way, and of those that wait only the newest is asked", async () => {
  const { latest, open, shown } = asked();
  for (const wish of [1, 2, 3, 4]) latest.want(wish);
  assert.deepEqual(open.map(({ wish }) => wish), [1]);
  open[0].resolve("one");
  await settled();
  assert.deepEqual(open.map(({ wish }) => wish), [1, 4]);
  open[1].resolve("four");
  await settled();
  assert.deepEqual(shown, ["one", "four"]);
});

test("what was dropped is neither shown nor complained of", async () => {
  const { latest, open, shown, failed } = asked();
  latest.want(1);
  latest.drop();
  assert.ok(open[0].signal.aborted);
  latest.want(2);
  open[0].resolve("one");
  open[1].resolve("two");
  await settled();
  assert.deepEqual([shown, failed], [["two"], []]);
});

test("a failure is said unless something newer waits", async () => {
  const { latest, open, failed } = asked();
  latest.want(1);
  latest.want(2);
  open[0].reject(new Error("first"));
  await settled();
  open[1].reject(new Error("second"));
  await settled();
  assert.deepEqual(failed, ["second"]);
});
