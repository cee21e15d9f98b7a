/** A job whose result is shown below the plane: asked for, followed with its progress in words, cancelled. */

import { get, post, Refusal } from "../net/api.js";
import { follow } from "../net/follow.js";
import { submit } from "../net/submit.js";
import { inWords } from "../page/say.js";
import { showProgress } from "../page/state.js";
import { ended } from "./life.js";
import { stateInWords } from "./words.js";

export class Computation {
  /**
   * @param {HTMLElement} place of its line
   * @param {object} tell
   * @param {(job: Job) => void} tell.accepted the service has this job for what was asked
   * @param {(job: Job, signal: AbortSignal) => Promise<void>} tell.done
   * @param {(words: string) => void} tell.ended nothing more comes; words where there is no result
   */
  constructor(place, tell) {
    this.tell = tell;
    /** @type {Job|null} */
    this.job = null;
    this.mine = false;
    /** Whether something is asked for or computed. */
    this.busy = false;
    this.following = new AbortController();
    this.words = document.createElement("span");
    this.words.setAttribute("role", "status");
    this.progress = Object.assign(document.createElement("progress"), { max: 1, value: 0, hidden: true });
    this.progress.setAttribute("aria-label", "progress of this chart");
    this.cancel = Object.assign(document.createElement("button"), { type: "button", textContent: "Cancel", hidden: true });
    this.cancel.addEventListener("click", () => post(this.job.links.cancel, {}).catch((error) => this.#say(inWords(error))));
    this.anew = Object.assign(document.createElement("button"), { type: "button", hidden: true });
    this.anew.addEventListener("click", () => this.press());
    this.press = () => {};
    place.replaceChildren(this.words, this.progress, this.cancel, this.anew);
  }

  #say(text) {
    this.words.textContent = text;
  }

  /** Say something, and offer to do something about it; or say no more. */
  offer(text = "", label = "", press = () => {}) {
    this.#say(text);
    this.press = press;
    this.anew.textContent = label;
    this.anew.hidden = !label;
  }

  /** Ask for a result. The job before, if it is this page's and nobody else follows it, is stopped. */
  async ask(path, body) {
    const { signal } = this.#begin();
    this.#say("Asking.");
    try {
      const { job, mine } = await submit(path, body);
      // Something else is wanted meanwhile.
      if (signal.aborted) return withdraw(job, mine);
      this.#take(job, mine, signal);
    } catch (error) {
      if (!signal.aborted) this.#end(inWords(error));
    }
  }

  /** The job of an id; null if this service does not know it. @param {string} id @returns {Promise<Job|null>} */
  async find(id) {
    try {
      return await get(`/v1/jobs/${id}`);
    } catch (error) {
      if (error instanceof Refusal && error.status === 404) return null;
      throw error;
    }
  }

  /** Show what a job computes. @param {Job} job */
  show(job) {
    this.#take(job, false, this.#begin().signal);
  }

  /** Want it no more. */
  drop() {
    this.following.abort();
    if (this.job && !ended(this.job)) withdraw(this.job, this.mine);
    [this.job, this.mine, this.busy] = [null, false, false];
    showProgress(null, this);
    this.offer();
  }

  #begin() {
    this.drop();
    this.busy = true;
    return (this.following = new AbortController());
  }

  #take(job, mine, signal) {
    [this.job, this.mine] = [job, mine];
    this.tell.accepted(job);
    const report = (now, place) => this.#report(now, place, signal);
    const lost = (error) => this.#say(`${inWords(error)}; trying again.`);
    follow(job, report, lost, signal).catch((error) => {
      if (!signal.aborted && error.name !== "AbortError") this.#end(inWords(error));
    });
  }

  async #report(job, place, signal) {
    if (signal.aborted) return;
    this.job = job;
    showProgress(job, this);
    if (!ended(job)) return this.#say(stateInWords(job, place).text);
    if (job.state !== "succeeded") return this.#end(job.state === "cancelled" ? "Cancelled." : stateInWords(job, place).text);
    await this.tell.done(job, signal);
    if (!signal.aborted) this.#end("");
  }

  #end(words) {
    this.busy = false;
    this.offer();
    this.tell.ended(words);
  }
}

// If it cannot be stopped it goes on, and nothing here depends on that.
function withdraw(job, mine) {
  if (mine) post(`${job.links.self}/withdraw`, {}).catch(() => {});
}
