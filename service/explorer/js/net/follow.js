/** Follows a job by its events until it ends, also through restarts of the service. */

import { ended } from "../jobs/life.js";
import { get, Refusal, send, Unreachable, whole } from "./api.js";

const PATIENT_MS = 1000;
const QUEUE_MS = 2000;
const NOTHING_MORE = 204;
const STATES = ["queued", "running", "cancelling", "cancelled", "failed", "succeeded"];

/**
 * Whether an event is older than what is known of its job. A stream begins with the job's first event; the job itself
 * was read a moment ago.
 */
export function isBehind(event, job) {
  const [then, now] = [STATES.indexOf(event.state), STATES.indexOf(job.state)];
  if (then !== now || !job.progress) return then < now;
  const { progress } = event;
  if (!progress) return true;
  if (job.progress.stage === "compiling") return false; // the stage before goes on after it
  const count = ({ basins_done, tiles_done }) => 1e9 * (basins_done ?? 0) + tiles_done;
  return progress.stage === job.progress.stage ? count(progress) < count(job.progress) : progress.tiles_total === job.progress.tiles_total;
}

function pause(signal) {
  return new Promise((/** @type {(value?: any) => void} */ resolve) => {
    const timer = setTimeout(resolve, PATIENT_MS);
    signal.addEventListener("abort", () => (clearTimeout(timer), resolve()), { once: true });
  });
}

async function placeInQueue(job) {
  const queued = await get("/v1/jobs?state=queued&size=200");
  return queued.jobs.filter((other) => other.created < job.created).length + 1;
}

/** Fields of one Server-Sent Event; null for a comment. */
function parse(text) {
  const fields = Object.fromEntries(text.split("\n").map((line) => {
    const at = line.indexOf(":");
    return [line.slice(0, at), line.slice(at + 1).trimStart()];
  }));
  return fields.data ? { id: fields.id, ...JSON.parse(fields.data) } : null;
}

/**
 * The newest event of each chunk that arrives. They are fetched, because an EventSource cannot carry the key.
 * @param {Job} job
 * @param {{id: string|null}} seen the last event seen, kept up to date
 */
async function* eventsOf(job, seen, signal) {
  const headers = seen.id ? { "last-event-id": seen.id } : {};
  const answer = await send(job.links.events, { headers, signal });
  if (answer.status === NOTHING_MORE) return;
  const reader = answer.body.pipeThrough(new TextDecoderStream()).getReader();
  for (let rest = ""; ; ) {
    const { done, value } = await whole(() => reader.read());
    if (done) return;
    const events = (rest + value).replaceAll("\r\n", "\n").split("\n\n");
    rest = events.pop();
    const newest = events.map(parse).filter(Boolean).at(-1);
    if (newest) {
      seen.id = newest.id;
      yield newest;
    }
  }
}

/** Whether an error is temporary: the service is unavailable, or the connection was cut in mid-stream. */
function passes(error) {
  return error instanceof Unreachable || (error instanceof Refusal && error.status >= 500);
}

/**
 * Report a job's state, now and at every change until it is final. If the service is unavailable, wait for it.
 * @param {Job} job as it was a moment ago
 * @param {(job: Job, place: number|null) => Promise<void>|void} report job, and its place in the queue while it waits
 * @param {(error: Error) => void} lost called while the service does not answer
 * @param {AbortSignal} signal
 */
export async function follow(job, report, lost, signal) {
  const seen = { id: null };
  const waiting = setInterval(async () => {
    if (job.state !== "queued") return clearInterval(waiting);
    const place = await placeInQueue(job).catch(() => null);
    if (place && job.state === "queued" && !signal.aborted) report(job, place);
  }, QUEUE_MS);
  signal.addEventListener("abort", () => clearInterval(waiting), { once: true });
  try {
    for (let fresh = true; !signal.aborted; fresh = false) {
      try {
        if (!fresh) job = await get(job.links.self);
        await report(job, job.state === "queued" ? await placeInQueue(job) : null);
        if (ended(job)) return;
        let behind = true;
        for await (const event of eventsOf(job, seen, signal)) {
          behind &&= isBehind(event, job);
          if (behind) continue;
          // What is written when a job ends, as its time, is in the job and not in the event.
          if (ended(event)) break;
          job = { ...job, state: event.state, progress: event.progress ?? job.progress };
          await report(job, null);
        }
      } catch (error) {
        if (signal.aborted) return;
        if (!passes(error)) throw error;
        lost(error);
        await pause(signal);
      }
    }
  } finally {
    clearInterval(waiting);
  }
}
