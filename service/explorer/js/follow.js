/** Following a job until it has ended, through restarts of the service. */

import { get, Refusal, Unreachable } from "./api.js";

const FINAL = ["succeeded", "failed", "cancelled"];
const LIVELY_MS = 250;
const PATIENT_MS = 1000;

/** Whether a job will never change again. */
export function ended(job) {
  return FINAL.includes(job.state);
}

function pause(milliseconds, signal) {
  return new Promise((resolve) => {
    const timer = setTimeout(resolve, milliseconds);
    signal.addEventListener("abort", () => (clearTimeout(timer), resolve()), { once: true });
  });
}

async function placeInQueue(job) {
  const queued = await get("/v1/jobs?state=queued&size=200");
  return queued.jobs.filter((other) => other.created < job.created).length + 1;
}

/**
 * Report a job's state, now and as it changes, the last one being final; a service that is away is waited for.
 * @param {object} job as it was a moment ago
 * @param {(job: object, place: number|null) => Promise<void>|void} report job, and its place in the queue while it waits
 * @param {(error: Error) => void} lost called while the service does not answer
 * @param {AbortSignal} signal
 */
export async function follow(job, report, lost, signal) {
  let fresh = true;
  while (!signal.aborted) {
    try {
      if (!fresh) job = await get(job.links.self);
      fresh = false;
      const place = job.state === "queued" ? await placeInQueue(job) : null;
      if (signal.aborted) return;
      await report(job, place);
      if (ended(job)) return;
      await pause(LIVELY_MS, signal);
    } catch (error) {
      const passing = error instanceof Unreachable || (error instanceof Refusal && error.status >= 500);
      if (!passing) throw error;
      lost(error);
      await pause(PATIENT_MS, signal);
    }
  }
}
