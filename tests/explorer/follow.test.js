import assert from "node:assert/strict";
import { mock, test } from "node:test";

import { follow } from "../../service/explorer/js/net/follow.js";

const LINKS = { self: "/v1/jobs/7", events: "/v1/jobs/7/events" };
const progress = (tiles_done) => ({ stage: "mapping", tiles_done, tiles_total: 16, basins_done: 0, basins_total: 1 });
const job = (state, tiles_done) => ({ id: "7", state, links: LINKS, created: "2026-01-02", progress: tiles_done === undefined ? null : progress(tiles_done) });
const json = (content) => new Response(JSON.stringify(content));
const refused = (status) => new Response("{}", { status });
const stream = (...chunks) => new Response(new ReadableStream({
  start(controller) {
    for (const chunk of chunks) controller.enqueue(new TextEncoder().encode(chunk));
    controller.close();
  },
}));
const event = (id, content) => `id: ${id}\ndata: ${JSON.stringify(content)}\n\n`;

/** Follow a job of a service that gives these answers one after the other; an Error is a service out of reach. */
async function followed(first, answers) {
  const asked = [], reported = [], lost = [];
  mock.timers.enable({ apis: ["setTimeout", "setInterval"] });
  mock.method(globalThis, "fetch", async (path, { headers } = {}) => {
    const answer = answers[asked.length];
    asked.push([path, headers?.["last-event-id"] ?? null]);
    if (answer instanceof Error) throw answer;
    return answer;
  });
  const report = async ({ state, progress: known }, place) => void reported.push([state, known?.tiles_done ?? null, place]);
  // It waits before it asks again; here that takes no time.
  const away = (error) => (lost.push(error.message), setImmediate(() => mock.timers.tick(1000)));
  try {
    await follow(first, report, away, new AbortController().signal);
    assert.equal(asked.length, answers.length);
    return { asked, reported, lost };
  } finally {
    mock.restoreAll();
    mock.timers.reset();
  }
}

test("a job is followed through outages, from the last event seen to its end", async () => {
  const two = event(2, { state: "running", progress: progress(5) });
  const { asked, reported, lost } = await followed(job("running", 3), [
    refused(500), new TypeError("no network"), json(job("running", 4)),
    // Comments say nothing, what is older than the job is left out, and an event may come in two chunks.
    stream(": hello\n\n", event(1, { state: "running", progress: progress(2) }), two.slice(0, 9), two.slice(9).replaceAll("\n", "\r\n")),
    json(job("running", 6)), stream(event(3, { state: "succeeded", progress: null })), json(job("succeeded")),
  ]);
  assert.deepEqual(asked, [
    [LINKS.events, null], [LINKS.self, null], [LINKS.self, null], [LINKS.events, null], [LINKS.self, null], [LINKS.events, "2"], [LINKS.self, null],
  ]);
  assert.deepEqual(reported, [
    ["running", 3, null], ["running", 4, null], ["running", 5, null], ["running", 6, null], ["succeeded", null, null],
  ]);
  assert.deepEqual(lost, ["the service answered 500", "the service does not answer"]);
});

test("a job that waits is told its place: one more than those before it", async () => {
  const queued = ["2026-01-01", "2026-01-02", "2026-01-03"].map((created) => ({ created }));
  const { reported } = await followed(job("queued"), [json({ jobs: queued }), new Response(null, { status: 204 }), json(job("cancelled"))]);
  assert.deepEqual(reported, [["queued", null, 2], ["cancelled", null, null]]);
});

test("a job that is not there is no outage", async () => {
  await assert.rejects(followed(job("running"), [refused(404)]), /answered 404/);
});
