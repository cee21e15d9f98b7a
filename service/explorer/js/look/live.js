/** The live picture: previews of whatever oscillator and window are looked at, coarse with quick names first, then finer. */

import { Refusal } from "../net/api.js";
import { Latest } from "../net/latest.js";
import { askPreview } from "./preview.js";

const CELLS = { coarsest: 64, coarse: 96, fine: 128, finest: 256 };
const FEW_ITERATIONS = 61;
// Above this many milliseconds a preview, a moving slider asks for fewer cells.
const SLOW_MS = 130;
// The finest has four times as many cells, and comes only where that takes no longer than some two seconds.
const QUICK_MS = 500;

export class Live {
  /**
   * @param {object} tell
   * @param {(preview: import("./preview.js").Preview) => void} tell.show
   * @param {(error: Error) => void} tell.failed
   * @param {() => boolean} tell.alone whether no job is going to refine the picture
   */
  constructor(tell) {
    this.milliseconds = 0;
    this.latest = new Latest((wish, signal) => this.#ask(wish, signal), (preview, wish) => {
      tell.show(preview);
      const next = this.#finer(wish, tell.alone());
      if (next && !this.latest.next) this.latest.want({ ...wish, detail: next });
    }, (error, wish) => {
      // Its first look is there. One that takes too long is left to a job.
      if (wish.detail === "coarse" || !(error instanceof Refusal)) tell.failed(error);
    });
  }

  #finer({ detail }, alone) {
    if (detail === "coarse") return "fine";
    return detail === "fine" && alone && this.milliseconds < QUICK_MS ? "finest" : null;
  }

  /**
   * Show an oscillator in a window: coarse at once, then finer unless something newer is wanted.
   * @param {Oscillator} oscillator
   * @param {View} view
   */
  want(oscillator, view) {
    // A finer preview under way is of the past, and can take seconds where motions are slow to settle.
    if (this.latest.wish && this.latest.wish.detail !== "coarse") this.latest.drop();
    this.latest.want({ oscillator, view, detail: "coarse" });
  }

  drop() {
    this.latest.drop();
  }

  async #ask({ oscillator, view, detail }, signal) {
    const begun = performance.now();
    const coarse = detail === "coarse";
    const cells = coarse && this.milliseconds > SLOW_MS ? CELLS.coarsest : CELLS[detail];
    // With weak damping a few iterations show nothing that lasts.
    const few = coarse && oscillator.damping >= 0.5 ? FEW_ITERATIONS : null;
    const preview = await askPreview(oscillator, view, { cells, iterations: few, quick: coarse }, signal);
    this.milliseconds = performance.now() - begun;
    return preview;
  }
}
