/**
 * The life of the job that the page shows, as a state machine: `step(life, event)` returns the next life and the effects
 * to carry out. It knows neither the network nor the page.
 *
 *     idle -> asking -> following -> ended
 *                ^  \-> refused
 *                +---------- ask, at any time
 *
 * Rules. A new request is submitted first; only once it is accepted does the older job lose its follower here. A job is
 * withdrawn only if this page has submitted it, and the service stops it only if nobody else follows it. Answers to
 * older requests are dropped. A refusal stays until something newer is accepted. A job that this page has withdrawn may
 * be opened again before it stops, or as it does: then its request is asked for anew.
 */

const FINAL = ["succeeded", "failed", "cancelled"];
const STOPPED = ["cancelling", "cancelled"];

/**
 * @typedef {object} Life
 * @property {"idle"|"asking"|"following"|"ended"|"refused"} phase
 * @property {number} turn number of the newest request; answers to others are stale
 * @property {BasinRequest|null} request the newest request
 * @property {Job|null} job the job that is shown
 * @property {boolean} mine whether this page has submitted it
 * @property {string[]} withdrawn ids of the jobs that this page has withdrawn
 * @property {number|null} place of the job in the queue
 * @property {boolean} [lost] whether the notice is about an outage
 * @property {string} notice a refusal, or that the service does not answer
 * @typedef {{do: string, [field: string]: any}} Effect
 */

/** @type {Life} */
export const BEGINNING = { phase: "idle", turn: 0, request: null, job: null, mine: false, withdrawn: [], place: null, notice: "" };

/** Whether a job can no longer change. */
export function ended(job) {
  return FINAL.includes(job.state);
}

/** Whether a job has a store: it has one once it has reported progress. One whose result was there already reports none. */
export function hasStore({ state, progress }) {
  return Boolean(progress) || state === "succeeded";
}

function phaseOf(job) {
  return ended(job) ? "ended" : "following";
}

/** Show another job, and let go of the older one if it was this page's. */
function changeTo(life, job, mine) {
  const kept = life.job?.id === job.id;
  const older = life.job && !kept && life.mine && !ended(life.job) ? [{ do: "withdraw", job: life.job }] : [];
  const next = { ...life, phase: phaseOf(job), job, mine: mine || (kept && life.mine), place: null, notice: "" };
  return [next, [{ do: "follow", job }, ...older]];
}

const STEPS = {
  /** Somebody asks for a basin or an analysis. */
  ask(life, { request }) {
    const turn = life.turn + 1;
    return [{ ...life, phase: "asking", turn, request }, [{ do: "submit", request, turn }]];
  },

  accepted(life, { turn, job, mine }) {
    if (turn !== life.turn) return [life, mine && job.id !== life.job?.id ? [{ do: "withdraw", job }] : []];
    return changeTo(life, job, mine);
  },

  refused(life, { turn, message, after }) {
    if (turn !== life.turn) return [life, []];
    const phase = life.job ? phaseOf(life.job) : "refused";
    const again = after === null ? "" : ` Trying again in ${after} s.`;
    const effects = after === null ? [] : [{ do: "wait", seconds: after, turn }];
    return [{ ...life, phase, notice: message + again }, effects];
  },

  /** The time that a refusal named is over. */
  waited(life, { turn }) {
    if (turn !== life.turn) return [life, []];
    return [{ ...life, phase: "asking" }, [{ do: "submit", request: life.request, turn }]];
  },

  /** An address or a list names a job. One that was cancelled is asked for again, if its request is known. */
  open(life, { job, request }) {
    const next = { ...life, request, turn: life.turn + 1 };
    if (STOPPED.includes(job.state) && request) return STEPS.ask(next, { request });
    return changeTo(next, job, false);
  },

  report(life, { job, place }) {
    if (life.job?.id !== job.id) return [life, []];
    const late = STOPPED.includes(job.state) && life.withdrawn.includes(job.id);
    if (late && life.request && life.phase !== "asking") return STEPS.ask({ ...life, job }, life);
    const phase = life.phase === "asking" ? "asking" : phaseOf(job);
    const notice = life.lost ? "" : life.notice;
    return [{ ...life, job, place, phase, notice, lost: false }, []];
  },

  /** The service does not answer; its follower goes on trying. */
  lost(life, { message }) {
    return [{ ...life, notice: message, lost: true }, []];
  },

  cancel(life) {
    const next = { ...life, withdrawn: life.withdrawn.filter((id) => id !== life.job?.id) };
    return [next, life.job && !ended(life.job) ? [{ do: "cancel", job: life.job }] : []];
  },

  /** Another oscillator is looked at, for which nothing has been asked yet. */
  leave(life) {
    const older = life.job && life.mine && !ended(life.job) ? [{ do: "withdraw", job: life.job }] : [];
    return [{ ...BEGINNING, withdrawn: life.withdrawn, turn: life.turn + 1 }, [{ do: "unfollow" }, ...older]];
  },
};

/**
 * Next life and effects after an event.
 * @param {Life} life
 * @param {{type: string, [field: string]: any}} event
 * @returns {[Life, Effect[]]}
 */
export function step(life, event) {
  const [next, effects] = STEPS[event.type](life, event);
  const withdrawn = effects.filter((effect) => effect.do === "withdraw").map(({ job }) => job.id);
  return [{ ...next, withdrawn: [...next.withdrawn, ...withdrawn] }, effects];
}
