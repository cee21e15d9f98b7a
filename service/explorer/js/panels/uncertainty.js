/** How uncertain the final motion is in the window of a finished basin: a number, computed on request. */

import { uncertaintyInWords } from "../look/explain.js";
import { get } from "../net/api.js";
import { by } from "../page/by.js";
import { inWords } from "../page/say.js";

const LEAST_CELLS = 33;

export class Uncertainty {
  /** @param {() => import("../plane/picture.js").Picture|null} picture that is seen */
  constructor(picture) {
    this.picture = picture;
    /** What the words are of. */
    this.told = "";
    this.button = Object.assign(document.createElement("button"), { type: "button", id: "uncertainty", textContent: "How uncertain is the end?" });
    this.button.title = "Final-state uncertainty exponent of this basin";
    this.note = Object.assign(document.createElement("p"), { className: "note" });
    this.note.setAttribute("role", "status");
    this.button.addEventListener("click", () => this.#ask());
    by("explain").append(this.button);
    by("explain").after(this.note);
    this.follow();
  }

  get #of() {
    const { job, panel } = this.picture() ?? {};
    return job ? `/v1/jobs/${job}/uncertainty?panel=${panel}` : "";
  }

  /** Another picture may be seen: only a finished basin has this number. */
  follow() {
    const picture = this.picture();
    const { time, velocity, complete } = picture?.outline ?? {};
    this.button.disabled = !this.#of || !complete || Math.min(time.cells, velocity.cells) < LEAST_CELLS;
    if (this.told !== this.#of) this.note.textContent = this.told = "";
  }

  async #ask() {
    const address = (this.told = this.#of);
    this.note.textContent = "Counting.";
    const words = await get(address).then(uncertaintyInWords, inWords);
    if (address === this.told) this.note.textContent = words;
  }
}
