/** Pictures of one oscillator, one over the other: those of jobs by age, and the preview among them. */

// Largest number of pictures. Older ones stay underneath until a newer one has arrived.
const MOST_PICTURES = 8;

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

  /** All pictures in the order in which they are drawn. A preview covers what is coarser and older than itself. */
  get drawn() {
    const { preview, closer } = this;
    if (!preview) return [...this.jobs, ...closer];
    const finer = this.jobs.findIndex((picture) => picture.cellTime <= preview.cellTime || picture === this.newest);
    return [...(finer < 0 ? [...this.jobs, preview] : this.jobs.toSpliced(finer, 0, preview)), ...closer];
  }

  /** Put the picture of a job on top. Pictures without cells, and the oldest, are removed. */
  add(picture) {
    this.jobs = [...this.jobs.filter((older) => !older.empty).slice(1 - MOST_PICTURES), picture];
    this.closer = [];
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
