/** Carries out what the state machine of jobs says: submits, follows, withdraws, cancels. */

import { get, pathOf, post, Refusal } from "../net/api.js";
import { follow } from "../net/follow.js";
import { submit } from "../net/submit.js";
import { inWords } from "../page/say.js";
import { stepsOf } from "../state/steps.js";
import { BEGINNING, ended, step } from "./life.js";

function kindOf(request) {
  return request.kind ?? (stepsOf(request).length ? "sweep" : "basin");
}

export class Jobs {
  /**
   * @param {object} tell
   * @param {(life: import("./life.js").Life) => void} tell.changed the life of the job has changed
   * @param {(job: Job) => void} tell.begun another job is shown
   * @param {(job: Job, signal: AbortSignal) => Promise<void>} tell.drawn draw the job as it is now
   */
  constructor(tell) {
    this.tell = tell;
    this.life = BEGINNING;
    this.following = new AbortController();
  }

  get job() {
    return this.life.job;
  }

  ask(request) {
    this.#take({ type: "ask", request });
  }

  cancel() {
    this.#take({ type: "cancel" });
  }

  leave() {
    if (this.life.phase !== "idle") this.#take({ type: "leave" });
  }

  /**
   * Open a job by its id.
   * @param {string} id
   * @param {BasinRequest|null} again what is asked for where the service does not know it, or it was cancelled
   */
  async open(id, again) {
    try {
      const job = await get(`/v1/jobs/${id}`);
      this.#take({ type: "open", job, request: again });
    } catch (error) {
      if (!(again && error instanceof Refusal && error.status === 404)) throw error;
      this.ask(again);
    }
  }

  /** Follow the same job with another way to draw it. */
  again() {
    if (this.job) this.#follow(this.job);
  }

  #take(event) {
    const [life, effects] = step(this.life, event);
    this.life = life;
    for (const effect of effects) this.#carryOut(effect);
    this.tell.changed(this.life);
  }

  #carryOut(effect) {
    const { job } = effect;
    if (effect.do === "submit") this.#submit(effect);
    else if (effect.do === "follow") this.tell.begun(job), this.#follow(job);
    else if (effect.do === "unfollow") this.following.abort();
    // If it cannot be stopped it goes on, and nothing here depends on that.
    else if (effect.do === "withdraw") post(`${job.links.self}/withdraw`, {}).catch(() => {});
    else if (effect.do === "cancel") post(job.links.cancel, {}).catch((error) => this.#take({ type: "lost", message: inWords(error) }));
    else if (effect.do === "wait") setTimeout(() => this.#take({ type: "waited", turn: effect.turn }), 1000 * effect.seconds);
  }

  async #submit({ request, turn }) {
    try {
      const { kind: _, ...body } = request;
      this.#take({ type: "accepted", turn, ...(await submit(pathOf({ kind: kindOf(request) }), body)) });
    } catch (error) {
      const after = error instanceof Refusal && error.status === 429 ? error.after : null;
      this.#take({ type: "refused", turn, message: `${inWords(error)}.`.replace("..", "."), after });
    }
  }

  #follow(job) {
    this.following.abort();
    const { signal } = (this.following = new AbortController());
    const report = async (now, place) => {
      if (signal.aborted) return;
      // That it is complete is said once the picture is.
      if (!ended(now)) this.#take({ type: "report", job: now, place });
      await this.tell.drawn(now, signal);
      if (!signal.aborted) this.#take({ type: "report", job: now, place });
    };
    const lost = (error) => this.#take({ type: "lost", message: `${inWords(error)}; trying again.` });
    follow(job, report, lost, signal).catch((error) => {
      if (!signal.aborted && error.name !== "AbortError") this.#take({ type: "lost", message: inWords(error) });
    });
  }
}
