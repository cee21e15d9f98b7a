/** Two basins with one view: the one that was kept, swiped over the one that is seen, or side by side with it. */

import { oscillatorInWords } from "../look/caption.js";
import { firstOf } from "../look/screen.js";
import { attempt } from "../page/say.js";
import { Half } from "../plane/half.js";
import { Stack } from "../plane/stack.js";
import { showLegend } from "./legend.js";

const KEYS = "The same keys as beside it: arrows move the cross-hair of both, Enter follows the motion of this one from there.";

export class Comparison {
  /**
   * @param {{button: HTMLButtonElement, range: HTMLInputElement, side: HTMLButtonElement, frame: HTMLElement}} controls
   * @param {import("../plane/plane.js").Plane} plane
   * @param {object} tell
   * @param {() => import("../plane/half.js").Kept|null} tell.seen what is seen and can be kept
   * @param {() => void} tell.changed another basin is kept, or more of it is there
   * @param {() => void} tell.ended nothing is kept any more
   * @param {(error: Error) => void} tell.failed
   */
  constructor(controls, plane, tell) {
    const { button, range, side } = (this.controls = controls);
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
    side.addEventListener("click", () => {
      plane.side = !plane.side;
      this.#arrange();
      tell.changed();
    });
  }

  /** One canvas, or two with the same view. */
  #arrange() {
    const { button, range, side, frame } = this.controls;
    const { plane } = this;
    const there = plane.beside !== null;
    button.setAttribute("aria-pressed", String(there));
    side.setAttribute("aria-pressed", String(plane.side));
    side.hidden = !there;
    range.hidden = !there || plane.side;
    frame.classList.toggle("pair", there && plane.side);
    for (const { canvas, marks, kept } of plane.panes) if (kept) canvas.hidden = marks.hidden = !(there && plane.side);
    plane.panes.at(-1).canvas.setAttribute("aria-label", `${plane.beside?.label ?? ""}. ${KEYS}`);
    plane.draw();
  }

  /** What an address holds of the basin that is kept. @param {number[][]} motions that are followed of it */
  seen(motions) {
    const { beside } = this.plane;
    if (!beside) return {};
    const { job, panel, request, part } = beside;
    return { beside: { job, panel, request, motions }, part, compare: this.plane.side ? "side" : "swipe" };
  }

  /**
   * Keep the basin that an address names, and follow its motions; none where it names none.
   * @param {Partial<import("../state/address.js").Seen>} seen
   * @param {import("./motions.js").Motions} motions
   */
  async open({ beside, part, compare }, motions) {
    if (!beside?.request) return this.drop();
    this.plane.side = compare === "side";
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
    showLegend(place, beside?.picture ?? null, look, pick, null, beside?.request.iterations);
  }

  #keep(kept, stack) {
    this.plane.beside?.close();
    const half = new Half(kept, stack, Number(this.controls.range.value), `kept: ${oscillatorInWords(kept.oscillator)}`, this.tell.failed);
    half.changed = (picture, tile = null) => {
      picture.paint(this.plane.look, this.plane.look.layer === "solution" ? tile : null);
      this.plane.draw();
      if (tile === null) this.tell.changed();
    };
    this.plane.beside = half;
    this.#arrange();
    attempt(() => half.load());
  }

  /** Keep nothing. */
  drop() {
    if (!this.plane.beside) return;
    this.plane.beside.close();
    this.plane.beside = null;
    this.#arrange();
    this.tell.ended();
  }
}
