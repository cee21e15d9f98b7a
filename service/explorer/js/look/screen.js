/** The pictures that are seen: previews of what is looked at, and the basins of jobs as they are computed. */

import { Picture } from "../plane/picture.js";
import { ended, hasStore } from "../jobs/life.js";
import { Unreachable } from "../net/api.js";
import { Latest } from "../net/latest.js";
import { additions } from "../state/additions.js";
import { harmonicsText, NUMBERS, USUAL, withValues } from "../state/oscillator.js";
import { changesAt, stepsOf } from "../state/steps.js";
import { partTaken } from "./estimate.js";
import { Live } from "./live.js";

const FIELDS = ["model", ...NUMBERS, "harmonics", "permanent_contact"];
const DEFAULTS = { model: "impacting", permanent_contact: "envelope", ...USUAL };

/** Whether two oscillators of requests are the same. */
export function sameOscillator(one, other) {
  const stiff = one?.model === "piecewise_linear";
  const value = (oscillator, name) => (name === "harmonics" ? harmonicsText(oscillator.harmonics) : oscillator[name] ?? DEFAULTS[name]);
  return Boolean(one && other) && FIELDS.every((name) => (!stiff && name === "permanent_contact") || value(one, name) === value(other, name));
}

/** Oscillator of a request's first basin. @param {BasinRequest} request */
export function firstOf(request) {
  return withValues(request.oscillator, changesAt(stepsOf(request), 0));
}

export class Screen {
  /**
   * @param {import("../plane/plane.js").Plane} plane
   * @param {object} tell
   * @param {() => void} tell.changed another picture, or more of it, is seen
   * @param {() => void} tell.turned another oscillator is seen
   * @param {() => void} tell.left it is one that nobody has computed yet
   * @param {(error: Error) => void} tell.failed a preview could not be had
   * @param {() => boolean} tell.alone whether no job computes what is seen
   */
  constructor(plane, tell) {
    this.plane = plane;
    this.tell = tell;
    /** Oscillator of the pictures that are seen. */
    this.oscillator = null;
    /** Oscillator that was last asked for, and whether a slider still changes it. */
    this.wanted = null;
    this.moving = false;
    this.live = new Live({ show: (preview) => this.#arrived(preview), failed: (error) => this.#failed(error), alone: tell.alone });
    this.parts = new Latest((pictures, signal) => this.#fetch(pictures, signal), () => tell.changed(), (error) => tell.failed(error));
    /** What has not been asked for, or was not answered. */
    this.unseen = null;
    this.panel = 0;
    this.opened = null;
    /** How many times as long the last preview took as on a machine that does nothing else. */
    this.busy = 1;
  }

  /** Look at an oscillator in a window: a preview of it comes at once. */
  look(oscillator, view, moving = false) {
    [this.wanted, this.moving, this.unseen] = [oscillator, moving, null];
    this.live.want(oscillator, view);
  }

  /** Show more of a finished large basin where it is zoomed; whether it has more cells there than are shown. */
  closer(view) {
    this.parts.drop();
    const pictures = this.opened?.closer(view) ?? [];
    this.plane.closer(pictures);
    if (pictures.length) this.parts.want(pictures);
    return pictures.length > 0;
  }

  async #fetch(pictures, signal) {
    for (const picture of pictures) {
      await picture.refresh(true, (tile) => {
        if (!signal.aborted) this.plane.arrived(picture, tile);
      }, signal);
    }
  }

  /**
   * Which part of a request's iterations its cells take, by the preview of the same machine: those that settle end early.
   * Null where there is none.
   * @param {BasinRequest} request
   * @returns {number|null}
   */
  partOf(request) {
    const { preview } = this.plane.stack;
    if (!preview || preview.quick || additions.some(({ name }) => request[name]) || !sameOscillator(preview.oscillator, firstOf(request))) return null;
    return partTaken(preview.outline.solutions, preview.iterations / request.iterations);
  }

  /** Look at an oscillator once the service is known to take it. */
  propose(oscillator) {
    this.unseen = oscillator;
  }

  /** The service takes what was proposed; whether there was anything. */
  confirm() {
    const { unseen } = this;
    if (unseen) this.look(unseen, this.plane.view);
    return unseen !== null;
  }

  #failed(error) {
    if (error instanceof Unreachable) this.unseen = this.wanted;
    this.tell.failed(error);
  }

  #arrived(preview) {
    // While a slider moves, every picture is a little late. Afterwards only what is wanted is shown.
    if (!this.moving && !sameOscillator(preview.oscillator, this.wanted)) return;
    if (this.#turn(preview.oscillator)) this.tell.left();
    this.plane.preview(preview);
    // A quick one takes 30 ms, no longer than others may have the processor for.
    if (!preview.quick) this.busy = preview.busy;
    this.tell.changed();
  }

  /** Show an oscillator from now on; pictures of another one go. Returns whether it is another. */
  #turn(oscillator) {
    if (sameOscillator(oscillator, this.oscillator)) return false;
    const first = this.oscillator === null;
    this.oscillator = oscillator;
    this.plane.stack.clear();
    this.opened = null;
    this.plane.draw();
    if (!first) this.tell.turned();
    return true;
  }

  /** Begin with the pictures of a job, at one of its basins. */
  begin(job, panel) {
    this.panel = panel;
    this.opened = null;
    const oscillator = withValues(job.request.oscillator, changesAt(stepsOf(job.request), panel));
    [this.wanted, this.moving] = [oscillator, false];
    this.#turn(oscillator);
    return oscillator;
  }

  /** Show no pictures: what is shown has no cells. */
  clear() {
    this.live.drop();
    this.parts.drop();
    this.oscillator = this.wanted = this.opened = null;
    this.plane.clear();
  }

  /** Draw a job as far as it is computed; its picture, or null while there is none. */
  async draw(job, signal) {
    if (!hasStore(job)) return null;
    const picture = this.opened ?? (await this.#open(job, signal));
    if (!picture || signal.aborted) return null;
    this.opened = picture;
    await picture.refresh(ended(job), (tile) => {
      if (!signal.aborted) this.plane.arrived(picture, tile);
    }, signal);
    if (signal.aborted) return null;
    this.plane.draw();
    this.tell.changed();
    if (ended(job)) this.closer(this.plane.view);
    return picture;
  }

  async #open(job, signal) {
    try {
      const picture = await Picture.open(job.id, this.panel);
      if (!signal.aborted) this.plane.show(picture);
      return picture;
    } catch (error) {
      // The store of a cancelled job may have passed to the next job of the same request.
      if (error.kind === "not-ready") return null;
      throw error;
    }
  }
}
