/** The most recent jobs, to be opened again. */

import { get } from "../net/api.js";
import { hasCells, kindInWords } from "./still.js";

function told(job) {
  const { request: { oscillator, vary }, state } = job;
  if (!hasCells(job)) return `${kindInWords(job)}: ${state}`;
  const what = vary
    ? `sweep of ${vary.map(({ parameter }) => parameter).join(", ")}`
    : `δ ${oscillator.damping}, ε ${oscillator.eccentricity}`;
  return `${what}: ${state}`;
}

/** Fill a list with links to the latest jobs. */
export async function listRecent(list) {
  const { jobs } = await get("/v1/jobs?size=10");
  list.replaceChildren(...jobs.map((job) => {
    const item = document.createElement("li");
    item.append(Object.assign(document.createElement("a"), { href: `?job=${job.id}`, textContent: told(job) }));
    return item;
  }));
}
