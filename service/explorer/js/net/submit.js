/** Sends the request of a job. */

import { ended } from "../jobs/life.js";
import { send, whole } from "./api.js";

/**
 * Submit a request. The same request may belong to another client's job: only one that is new is `mine`, to be withdrawn.
 * @param {string} path
 * @param {object} body
 * @returns {Promise<{job: Job, mine: boolean}>}
 */
export async function submit(path, body) {
  const headers = { "content-type": "application/json" };
  const answer = await send(path, { method: "POST", headers, body: JSON.stringify(body) });
  const job = await whole(() => answer.json());
  return { job, mine: !ended(job) && Date.parse(job.created) >= Date.parse(answer.headers.get("date")) - 1000 };
}
