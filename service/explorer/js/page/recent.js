/** The most recent jobs, to be opened again. */

import { get, kindInWords } from "../net/api.js";
import { oscillatorInWords, windowInWords } from "../look/caption.js";
import { stepsOf } from "../state/steps.js";
import { viewOf } from "../state/window.js";
import { hasCells } from "./still.js";

const MOST = 10;
// Some of these were withdrawn, as a zoom is by the next one.
const LOOKED_AMONG = 100;
const STATES = { succeeded: "complete", running: "running", queued: "waiting" };

function ago(moment) {
  const minutes = Math.round((Date.now() - Date.parse(moment)) / 60000);
  if (minutes < 1) return "just now";
  if (minutes < 90) return `${minutes} min ago`;
  return minutes < 2160 ? `${Math.round(minutes / 60)} h ago` : new Date(moment).toLocaleDateString();
}

function inWords(job) {
  const { request, state, created } = job, { oscillator, grid } = request;
  if (!hasCells(job)) return `${kindInWords(job)}: ${STATES[state]}, ${ago(created)}`;
  const names = stepsOf(request).map(({ name }) => name);
  const swept = names.length ? `sweep of ${names.join(", ")}: ` : "";
  return `${swept}${oscillatorInWords(oscillator)}; ${windowInWords(viewOf(grid))}: ${STATES[state]}, ${ago(created)}`;
}

/**
 * Of the latest jobs those that there is something to see of, or will be, and how many later ones are left out.
 * @param {Job[]} jobs the newest first
 */
export function worthListing(jobs) {
  const listed = jobs.filter(({ state }) => state in STATES).slice(0, MOST);
  const among = listed.length < MOST ? jobs.length : jobs.indexOf(listed.at(-1)) + 1;
  return { listed, left: among - listed.length };
}

/** Fill a list with links to the latest jobs. */
export async function listRecent(list) {
  const { jobs } = await get(`/v1/jobs?size=${LOOKED_AMONG}`);
  const { listed, left } = worthListing(jobs);
  const items = listed.map((job) => {
    const item = document.createElement("li");
    item.append(Object.assign(document.createElement("a"), { href: `?job=${job.id}`, textContent: inWords(job) }));
    return item;
  });
  if (!listed.length) items.push(Object.assign(document.createElement("li"), { textContent: "There are none yet." }));
  if (left) items.push(Object.assign(document.createElement("li"), { className: "note", textContent: `${left} stopped or failed ${left === 1 ? "job is" : "jobs are"} left out.` }));
  list.replaceChildren(...items);
}
