/** The state of a job in words. */

import { grouped } from "../charts/ticks.js";
import { additions } from "../state/additions.js";

const DOING = {
  computing: "computing basins", compiling: "compiling kernels, a minute or so", mapping: "mapping cells", assembling: "finding the motions", labelling: "labelling cells",
  searching: "looking for motions", settling: "following motions", continuing: "continuing orbits",
  tracing: "tracing curves", growing: "growing manifolds", done: "done",
};

function progressInWords({ stage, tiles_done, tiles_total, cells_per_second, seconds_left, basins_done, basins_total }) {
  const words = [`${DOING[stage] ?? additions.find(({ stages }) => stage in stages)?.stages[stage] ?? stage}: ${tiles_done} of ${tiles_total} ${basins_total ? "tiles" : "pieces"}`];
  if (basins_total > 1) words.push(`${basins_done} of ${basins_total} basins complete`);
  if (stage === "mapping" && cells_per_second) words.push(`${grouped(cells_per_second)} cells a second`);
  if (seconds_left > 1) words.push(`about ${Math.ceil(seconds_left)} s left`);
  return words.join(", ");
}

function seconds(job) {
  return ((Date.parse(job.finished) - Date.parse(job.started)) / 1000).toFixed(1);
}

function withPlace(place) {
  return place > 1 ? `Waiting: number ${place} in the queue.` : "Waiting: next in the queue.";
}

/** What a job is doing, and whether that is an error. */
export function stateInWords(job, place) {
  switch (job.state) {
    case "queued":
      return { text: withPlace(place), wrong: false };
    case "running":
      return { text: job.progress ? `${capital(progressInWords(job.progress))}.` : "Beginning.", wrong: false };
    case "cancelling":
      return { text: "Stopping.", wrong: false };
    case "cancelled":
      return { text: "Cancelled; what had been computed is shown.", wrong: false };
    case "failed":
      return { text: `Failed: ${job.error?.detail ?? "see the service's log"}`, wrong: true };
    default:
      return { text: `Complete, in ${seconds(job)} s.`, wrong: false };
  }
}

function capital(text) {
  return text[0].toUpperCase() + text.slice(1);
}
