/** Shows the state of a job. */

import { stateInWords } from "../jobs/words.js";
import { say } from "./say.js";

/** Show the life of the job: a refusal before anything else. */
export function showState({ phase, job, place, notice }, { progress, cancel }) {
  if (notice) say(notice, true);
  else if (phase === "asking") say("Asking.");
  else if (job) {
    const { text, wrong } = stateInWords(job, place);
    say(text, wrong);
  } else say("");
  showProgress(job, { progress, cancel });
}

/** Show how far a job is, and whether it can be cancelled. */
export function showProgress(job, { progress, cancel }) {
  progress.hidden = !job || job.state !== "running" || !job.progress;
  if (!progress.hidden) {
    progress.max = job.progress.tiles_total;
    progress.value = job.progress.tiles_done;
  }
  cancel.hidden = !job || ["succeeded", "failed", "cancelled", "cancelling"].includes(job.state);
}
