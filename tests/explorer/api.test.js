import assert from "node:assert/strict";
import { mock, test } from "node:test";

import { get, kindInWords, knowKinds, pathOf, post, Refusal, Unreachable, whenKeyIsNeeded, whole } from "../../service/explorer/js/net/api.js";

const refusal = (status, problem, headers = {}) => new Response(JSON.stringify(problem), { status, headers });

/** What is sent while a service gives these answers one after the other. */
async function sent(answers, ask) {
  const seen = [];
  mock.method(globalThis, "fetch", async (path, { method = "GET", headers = {}, body = null } = {}) => {
    seen.push([method, path, headers.authorization ?? null, body]);
    return answers[seen.length - 1];
  });
  try {
    return { seen, answer: await ask().catch((error) => error) };
  } finally {
    mock.restoreAll();
  }
}

test("each kind of request has the route and the words that the service says", () => {
  knowKinds({ sweep: { path: "/v1/sweeps", title: "Sweep" }, orbits: { path: "/v1/orbits", title: "Periodic orbits" } });
  assert.equal(pathOf({ kind: "orbits" }), "/v1/orbits");
  assert.equal(kindInWords({ kind: "orbits", request: {} }), "Periodic orbits");
  assert.equal(kindInWords({ kind: "sweep", request: { sample: { points: 9 } } }), "Sample of a sweep");
});

test("a refusal has the service's words, errors and time", async () => {
  const problem = { detail: "too many", type: "/problems/too-much", errors: [{ location: ["body"] }] };
  const { answer } = await sent([refusal(429, problem, { "retry-after": "7" })], () => get("/v1/jobs"));
  assert.ok(answer instanceof Refusal);
  assert.deepEqual([answer.message, answer.status, answer.kind, answer.after, answer.errors], ["too many", 429, "too-much", 7, problem.errors]);
  const { answer: bare } = await sent([new Response("it broke", { status: 500 })], () => get("/v1/jobs"));
  assert.deepEqual([bare.message, bare.kind, bare.after, bare.errors], ["the service answered 500", "", 5, []]);
});

test("a key is asked for, told why another is needed, and sent from then on", async () => {
  const why = [];
  whenKeyIsNeeded(async (wrong) => (why.push(wrong), ["one", "two", "three"][why.length - 1]));
  const answers = [refusal(401, { detail: "a key is required" }), refusal(401, { detail: "this key has ended" }), refusal(401, {}), new Response("[3]"), new Response("[4]")];
  const { seen, answer } = await sent(answers, async () => [await post("/v1/basins", { kind: "basin" }), await get("/v1/jobs")]);
  assert.deepEqual(answer, [[3], [4]]);
  assert.deepEqual(why, ["", "this key has ended", "this key is not known"]);
  const body = JSON.stringify({ kind: "basin" });
  assert.deepEqual(seen, [
    ...[null, "Bearer one", "Bearer two", "Bearer three"].map((key) => ["POST", "/v1/basins", key, body]), ["GET", "/v1/jobs", "Bearer three", null],
  ]);
});

test("what is cut is an outage, what is aborted is not", async () => {
  const fails = (name) => whole(async () => {
    throw Object.assign(new Error("cut"), { name });
  }).catch((error) => error);
  assert.ok((await fails("TypeError")) instanceof Unreachable);
  assert.equal((await fails("AbortError")).name, "AbortError");
});
