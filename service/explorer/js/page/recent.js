/** The most recent jobs, to be opened again. */

import { get, kindInWords } from "../net/api.js";
import { oscillatorInWords, windowInWords } from "../look/caption.js";
import { stepsOf } from "../state/steps.js";
import { viewOf } from "../state/window.js";
import { hasCells } from "./still.js";

function ago(moment) {
  const minutes = Math.round((Date.now() - Date.parse(moment)) / 60000);
  if (minutes < 1) return "just now";
  if (minutes < 90) return `${minutes} min ago`;
  return minutes < 2160 ? `${Math.round(minutes / 60)} h ago` : new Date(moment).toLocaleDateString();
}

function inWords(job) {
  const { request, state, created } = job, { oscillator, grid } = request;
  if (!hasCells(job)) return `${kindInWords(job)}: ${state}, ${ago(created)}`;
  const names = stepsOf(request).map(({ name }) => name);
  const swept = names.length ? `sweep of ${names.join(", ")}: ` : "";
  return `${swept}${oscillatorInWords(oscillator)}; ${windowInWords(viewOf(grid))}: ${state}, ${ago(created)}`;
}

/** Fill a list with links to the latest jobs. */
export async function listRecent(list) {
  const { jobs } = await get("/v1/jobs?size=10");
  list.replaceChildren(...jobs.map((job) => {
    const item = document.createElement("li");
    item.append(Object.assign(document.createElement("a"), { href: `?job=${job.id}`, textContent: inWords(job) }));
    return item;
  }));
}
