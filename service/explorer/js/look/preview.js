/** A small basin that the service computes at once: a picture of one tile, complete when it comes. */

import { sendJson, whole } from "../net/api.js";
import { Picture } from "../plane/picture.js";
import { busyness } from "./estimate.js";
import { UNSETTLED } from "./explain.js";
import { axesOf } from "../state/window.js";

const LABELLED = 3;

/** Quick names leave open what a finer picture decides. */
function notYet(solution) {
  return solution.kind === "undecided" ? { ...solution, name: UNSETTLED } : solution;
}

function outlineOf(answer, quick) {
  const { time, velocity, grazing, missing_colour, expected } = answer;
  const solutions = quick ? answer.solutions.map(notYet) : answer.solutions;
  return {
    parameters: {}, time, velocity, solutions, expected, grazing, missing_colour, complete: true, speckle: [1],
    tiles: { rows: velocity.cells, columns: time.cells, down: 1, across: 1, first: 0, states: [LABELLED] }, levels: [],
  };
}

export class Preview extends Picture {
  /**
   * @param {PreviewAnswer} answer as from `/v1/previews`
   * @param {Oscillator} oscillator that it is of
   * @param {boolean} quick whether slow motions are named by what a few thousand impacts show
   * @param {number} busy how many times as long it took as on a machine that does nothing else
   */
  constructor(answer, oscillator, quick, busy) {
    super(null, 0, outlineOf(answer, quick));
    this.oscillator = oscillator;
    this.quick = quick;
    this.busy = busy;
    this.iterations = answer.iterations;
    const bytes = Uint8Array.from(atob(answer.labels), (letter) => letter.charCodeAt(0));
    for (let row = 0; row < this.height; row++) {
      // Speeds increase upwards, pixel rows downwards.
      this.solution.set(bytes.subarray(row * this.width, (row + 1) * this.width), (this.height - 1 - row) * this.width);
    }
    this.there.add(0);
    this.settled.add(0);
  }

  /**
   * What a place ends in. A preview has none of Hsu's numbers, and its cells are too coarse to start from the middle.
   * @returns {Known|null}
   */
  at(t, v) {
    const known = super.at(t, v);
    return known && { solution: known.solution, t, v };
  }

  /** Paint what cells end in, or how loud that is: a preview has no numbers to paint. */
  paint(look, tile = null) {
    super.paint({ ...look, layer: look.layer === "loudness" ? "loudness" : "solution" }, tile);
  }

  get isPreview() {
    return true;
  }
}

/**
 * Ask for a preview.
 * @param {Oscillator} oscillator as in a request
 * @param {View} view
 * @param {object} how
 * @param {number} how.cells each way
 * @param {number|null} how.iterations null for the service's own choice
 * @param {boolean} how.quick
 * @param {AbortSignal} signal
 */
export async function askPreview(oscillator, view, { cells, iterations, quick }, signal) {
  const grid = axesOf(view, { time: cells, velocity: cells });
  const body = { oscillator, grid, quick, ...(iterations ? { iterations } : {}) };
  const answer = await sendJson("/v1/previews", body, { signal });
  return new Preview(await whole(() => answer.json()), oscillator, quick, busyness(answer.headers.get("server-timing")));
}
