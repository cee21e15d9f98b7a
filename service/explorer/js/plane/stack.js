/** Pictures of one oscillator, one over the other: those of jobs by age, and the preview among them. */

import { same } from "../state/window.js";

// Largest number of pictures. Older ones stay underneath until a newer one has arrived.
const MOST_PICTURES = 8;

/** Whether a window contains another, whatever the period of either. @param {View} view @param {View} other */
function contains(view, other) {
  const width = view.t1 - view.t0, slack = 1e-9 * width;
  const early = other.t0 - view.t0 - Math.floor(other.t0 - view.t0 + slack);
  const across = width >= 1 - slack || early + other.t1 - other.t0 <= width + slack;
  return across && view.v0 <= other.v0 && view.v1 >= other.v1;
}

/** Whether a preview shows all that a newer one does, in cells as small and with names as final. */
export function outdoes(preview, newer) {
  const finer = preview.cellTime <= newer.cellTime && preview.cellVelocity <= newer.cellVelocity;
  return finer && (newer.quick || !preview.quick) && contains(preview.view, newer.view);
}

export class Stack {
  constructor() {
    /** @type {import("./picture.js").Picture[]} */
    this.jobs = [];
    /** @type {import("../look/preview.js").Preview|null} */
    this.preview = null;
    /** @type {import("./picture.js").Picture[]} parts of the newest, of more cells */
    this.closer = [];
  }

  /** The newest picture that has cells, those of jobs before the preview; null if there is none. */
  get top() {
    return this.jobs.findLast((picture) => !picture.empty) ?? this.preview;
  }

  get newest() {
    return this.jobs.at(-1) ?? null;
  }

  /**
   * All pictures in the order in which they are drawn. A preview covers what is coarser and older than itself, but for
   * a finished basin of the same window.
   */
  get drawn() {
    const { preview, closer } = this;
    if (!preview) return [...this.jobs, ...closer];
    const better = (picture) => picture.cellTime <= preview.cellTime || (picture.whole && same(picture.view, preview.view));
    const finer = this.jobs.findIndex((picture) => picture === this.newest || better(picture));
    return [...(finer < 0 ? [...this.jobs, preview] : this.jobs.toSpliced(finer, 0, preview)), ...closer];
  }

  /** Put the picture of a job on top. Pictures without cells, and the oldest, are removed. */
  add(picture) {
    this.jobs = [...this.jobs.filter((older) => !older.empty).slice(1 - MOST_PICTURES), picture];
    this.closer = [];
  }

  /** Show a preview, unless the one that is there shows more. */
  offer(preview) {
    if (!this.preview || !outdoes(this.preview, preview)) this.preview = preview;
  }

  clear() {
    this.jobs = [];
    this.preview = null;
    this.closer = [];
  }

  /** What is known at a point, from the newest picture that has it. */
  at(t, v) {
    for (const picture of this.drawn.toReversed()) {
      const known = picture.at(t, v);
      if (known) return known;
    }
    return null;
  }
}
