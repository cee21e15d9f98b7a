import assert from "node:assert/strict";
import { test } from "node:test";

import { BEGINNING, step } from "../../service/explorer/js/jobs/life.js";

const REQUEST = { oscillator: { damping: 0.6 } };
const OTHER = { oscillator: { damping: 0.5 } };

function job(id, state = "queued", fields = {}) {
  return { id, state, request: REQUEST, links: {}, progress: null, ...fields };
}

/** Life after events, and all effects on the way. */
function live(events, life = BEGINNING) {
  const effects = [];
  for (const event of events) {
    const [next, more] = step(life, event);
    life = next;
    effects.push(...more);
  }
  return { life, effects, did: effects.map(({ do: name, job: of }) => (of ? `${name} ${of.id}` : name)) };
}

const FIRST = [{ type: "ask", request: REQUEST }, { type: "accepted", turn: 1, job: job("a"), mine: true }];

test("in the beginning there is no job, nor is one this page's", () => {
  const { phase, job: of, mine, withdrawn, place, notice } = BEGINNING;
  assert.deepEqual([phase, of, mine, withdrawn, place, notice], ["idle", null, false, [], null, ""]);
});

test("a request is submitted, and its job followed", () => {
  const { life, did } = live(FIRST);
  assert.deepEqual(did, ["submit", "follow a"]);
  assert.equal(life.phase, "following");
});

test("the older job is withdrawn only once the newer request is accepted", () => {
  const asked = live([...FIRST, { type: "ask", request: OTHER }]);
  assert.deepEqual(asked.did, ["submit", "follow a", "submit"]);
  assert.equal(asked.life.job.id, "a", "it is shown meanwhile");
  const { did, life } = live([{ type: "accepted", turn: 2, job: job("b"), mine: true }], asked.life);
  assert.deepEqual(did, ["follow b", "withdraw a"]);
  assert.equal(life.job.id, "b");
});

test("a refusal leaves the running job alone, stays, and is tried again after the time that it names", () => {
  const refused = live([...FIRST, { type: "ask", request: OTHER }, { type: "refused", turn: 2, message: "too much.", after: 7 }]);
  assert.ok(!refused.did.some((name) => name.startsWith("withdraw")));
  assert.deepEqual(refused.effects.at(-1), { do: "wait", seconds: 7, turn: 2 });
  const reported = live([{ type: "report", job: job("a", "running"), place: null }], refused.life);
  assert.match(reported.life.notice, /too much\. Trying again in 7 s/);
  const again = live([{ type: "waited", turn: 2 }], reported.life);
  assert.deepEqual(again.effects, [{ do: "submit", request: OTHER, turn: 2 }]);
  const accepted = live([{ type: "accepted", turn: 2, job: job("b"), mine: true }], again.life);
  assert.equal(accepted.life.notice, "");
});

test("a refusal that names no time is not tried again", () => {
  const { effects, life } = live([{ type: "ask", request: REQUEST }, { type: "refused", turn: 1, message: "too large.", after: null }]);
  assert.deepEqual(effects.map(({ do: name }) => name), ["submit"]);
  assert.equal(life.phase, "refused");
  assert.equal(life.notice, "too large.");
});

test("answers to older requests are dropped, and their jobs withdrawn", () => {
  const { did, life } = live([
    { type: "ask", request: REQUEST },
    { type: "ask", request: OTHER },
    { type: "accepted", turn: 1, job: job("a"), mine: true },
    { type: "refused", turn: 1, message: "late", after: null },
    { type: "accepted", turn: 2, job: job("b"), mine: true },
  ]);
  assert.deepEqual(did, ["submit", "submit", "withdraw a", "follow b"]);
  assert.equal(life.notice, "");
});

test("the time after a refusal does not bring back what was asked before something newer", () => {
  const { did } = live([
    { type: "ask", request: REQUEST }, { type: "refused", turn: 1, message: "later.", after: 1 },
    { type: "ask", request: OTHER }, { type: "waited", turn: 1 },
  ]);
  assert.deepEqual(did, ["submit", "wait", "submit"]);
});

test("a job that was cancelled is asked for again where its request is known", () => {
  const { did, life } = live([{ type: "open", job: job("a", "cancelled"), request: REQUEST }]);
  assert.deepEqual(did, ["submit"]);
  assert.equal(life.request, REQUEST);
  assert.deepEqual(live([{ type: "open", job: job("a", "cancelled"), request: null }]).did, ["follow a"]);
});

test("a job that is being cancelled is asked for again, too", () => {
  assert.deepEqual(live([{ type: "open", job: job("a", "cancelling"), request: REQUEST }]).did, ["submit"]);
});

test("a job that this page has withdrawn, and opens again before it stops, is asked for anew as it does", () => {
  const left = [...FIRST, { type: "ask", request: OTHER }, { type: "accepted", turn: 2, job: job("b"), mine: true }];
  const back = live([...left, { type: "open", job: job("a", "running"), request: REQUEST }]);
  const stopping = { type: "report", job: job("a", "cancelling"), place: null };
  const again = live([stopping, { type: "report", job: job("a", "cancelled"), place: null }], back.life);
  assert.deepEqual(again.effects, [{ do: "submit", request: REQUEST, turn: 4 }]);
  const cancelled = live([{ type: "cancel" }, stopping], back.life);
  assert.deepEqual(cancelled.did, ["cancel a"], "somebody's own cancellation stays");
});

test("a job of somebody else is never withdrawn", () => {
  const shared = [{ type: "open", job: job("a", "running"), request: REQUEST }];
  const { did } = live([...shared, { type: "ask", request: OTHER }, { type: "accepted", turn: 2, job: job("b"), mine: true }]);
  assert.ok(!did.includes("withdraw a"));
  assert.ok(!live([...shared, { type: "leave" }]).did.includes("withdraw a"));
});

test("a job that has ended needs no withdrawal", () => {
  const { did } = live([...FIRST, { type: "report", job: job("a", "succeeded"), place: null }, { type: "leave" }]);
  assert.ok(!did.includes("withdraw a"));
});

test("asking for the same again keeps the job", () => {
  const again = [{ type: "ask", request: REQUEST }, { type: "accepted", turn: 2, job: job("a", "running"), mine: false }];
  const { did, life } = live([...FIRST, ...again]);
  assert.ok(!did.includes("withdraw a"));
  assert.ok(live([{ type: "leave" }], life).did.includes("withdraw a"), "it is still this page's");
  const opened = live([{ type: "open", job: job("a", "running"), request: REQUEST }, again[0]]).life;
  assert.equal(live([{ ...again[1], turn: opened.turn }], opened).life.mine, false, "nor does it become this page's");
});

test("somebody else's job that is shown after one's own is not one's own", () => {
  const shared = live([...FIRST, { type: "ask", request: OTHER }, { type: "accepted", turn: 2, job: job("b", "running"), mine: false }]);
  assert.ok(shared.did.includes("withdraw a"));
  const left = live([{ type: "ask", request: REQUEST }, { type: "accepted", turn: 3, job: job("c"), mine: true }], shared.life);
  assert.deepEqual(left.did, ["submit", "follow c"]);
});

test("leaving lets go of the job, and of what is on its way", () => {
  const { did, life } = live([...FIRST, { type: "ask", request: OTHER }, { type: "leave" }, { type: "accepted", turn: 2, job: job("b"), mine: true }]);
  assert.deepEqual(did.slice(3), ["unfollow", "withdraw a", "withdraw b"]);
  assert.equal(life.phase, "idle");
});

test("an outage is said, and forgotten with the next report", () => {
  const lost = live([...FIRST, { type: "lost", message: "does not answer" }]);
  assert.equal(lost.life.notice, "does not answer");
  assert.equal(live([{ type: "report", job: job("a", "running"), place: null }], lost.life).life.notice, "");
});

test("reports of another job are not shown", () => {
  assert.equal(live([...FIRST, { type: "report", job: job("z", "failed"), place: null }]).life.job.state, "queued");
});
