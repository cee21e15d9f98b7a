/** Two basins with one view: the one that was kept, swiped over the one that is seen. Each half is a whole plane. */

import { oscillatorInWords } from "../look/caption.js";
import { firstOf } from "../look/screen.js";
import { attempt } from "../page/say.js";
import { Half } from "../plane/half.js";
import { Stack } from "../plane/stack.js";
import { showLegend } from "./legend.js";

export class Comparison {
  /**
   * @param {{button: HTMLButtonElement, range: HTMLInputElement}} controls
   * @param {import("../plane/plane.js").Plane} plane
   * @param {object} tell
   * @param {() => import("../plane/half.js").Kept|null} tell.seen what is seen and can be kept
   * @param {() => void} tell.changed another basin is kept, or more of it is there
   * @param {() => void} tell.ended nothing is kept any more
   * @param {(error: Error) => void} tell.failed
   */
  constructor({ button, range }, plane, tell) {
    this.controls = { button, range };
    this.plane = plane;
    this.tell = tell;
    button.addEventListener("click", () => {
      const kept = plane.beside === null && plane.picture !== null ? tell.seen() : null;
      if (kept) this.#keep(kept, plane.stack);
      else this.drop();
      tell.changed();
    });
    range.addEventListener("input", () => {
      plane.beside.part = Number(range.value);
      plane.draw();
    });
    range.addEventListener("change", () => tell.changed());
  }

  /** What an address holds of the basin that is kept. @param {number[][]} motions that are followed of it */
  seen(motions) {
    const { beside } = this.plane;
    if (!beside) return {};
    const { job, panel, request, part } = beside;
    return { beside: { job, panel, request, motions }, part };
  }

  /**
   * Keep the basin that an address names, and follow its motions; none where it names none.
   * @param {Partial<import("../state/address.js").Seen>} seen
   * @param {import("./motions.js").Motions} motions
   */
  async open({ beside, part }, motions) {
    if (!beside?.request) return this.drop();
    const { request, job, panel } = beside;
    this.controls.range.value = String(part);
    this.#keep({ oscillator: firstOf(request), request, job, panel }, new Stack());
    this.plane.beside.look(this.plane.view);
    for (const [t, v] of beside.motions) await motions.pickKept({ t, v }, true, this.plane.beside);
  }

  /** Show the legend of the basin that is kept under its label. */
  showLegend({ label, place }, pick) {
    const { beside, look } = this.plane;
    label.hidden = !beside;
    label.textContent = beside?.label ?? "";
    showLegend(place, beside?.picture ?? null, look, pick);
  }

  #keep(kept, stack) {
    const { button, range } = this.controls;
    this.plane.beside?.close();
    const half = new Half(kept, stack, Number(range.value), `kept: ${oscillatorInWords(kept.oscillator)}`, this.tell.failed);
    half.changed = (picture, tile = null) => {
      picture.paint(this.plane.look, this.plane.look.layer === "solution" ? tile : null);
      this.plane.draw();
      if (tile === null) this.tell.changed();
    };
    this.plane.beside = half;
    button.setAttribute("aria-pressed", "true");
    range.hidden = false;
    attempt(() => half.load());
    this.plane.draw();
  }

  /** Keep nothing. */
  drop() {
    const { button, range } = this.controls;
    if (!this.plane.beside) return;
    this.plane.beside.close();
    this.plane.beside = null;
    button.setAttribute("aria-pressed", "false");
    range.hidden = true;
    this.plane.draw();
    this.tell.ended();
  }
}
