/** A tour of the page in five steps, each beside what it is about. It begins when asked for, and can be left at any time. */

import { besides } from "./beside.js";

/** What each step points at, and says. */
export const STEPS = [
  { at: "#frame", title: "The plane", says: "Each point is a departure: a tooth leaves one side of its backlash at phase t with speed v. Its colour is the motion that it ends in, and the legend has the names." },
  { at: "#turn", title: "The oscillator", says: "Move a slider: the picture follows. Let it go, and the whole picture is computed." },
  { at: "#reading", title: "One motion", says: "Click a point of the plane: a tooth moves below as that motion does, and a sentence says where it ends." },
  { at: "#overlays", title: "Why it is so", says: "The grazing curve, manifolds and saddles lie over the picture; diagrams and periodic orbits come below it." },
  { at: "#away", title: "To take along", says: "Pictures, tables and the code that computes them. The address of this page holds all that is seen: send it to show the same." },
];

export class Tour {
  /**
   * @param {HTMLElement} box a popover with a title, a text, and buttons
   * @param {HTMLElement} begin where the focus returns to
   */
  constructor(box, begin) {
    this.box = box;
    this.begin = begin;
    this.step = 0;
    this.parts = Object.fromEntries(["title", "says", "place", "before", "next", "leave"].map((name) => [name, /** @type {HTMLElement} */ (box.querySelector(`[data-tour=${name}]`))]));
    this.parts.before.addEventListener("click", () => this.#go(this.step - 1));
    this.parts.next.addEventListener("click", () => (this.step === STEPS.length - 1 ? this.leave() : this.#go(this.step + 1)));
    this.parts.leave.addEventListener("click", () => this.leave());
    box.addEventListener("keydown", (event) => event.key === "Escape" && this.leave());
    addEventListener("resize", () => this.target && this.#place());
  }

  start() {
    this.box.showPopover();
    this.#go(0);
  }

  leave() {
    this.target?.classList.remove("pointed");
    this.target = null;
    this.box.hidePopover();
    this.begin.focus();
  }

  #go(step) {
    this.step = step;
    const { at, title, says } = STEPS[step], { parts } = this;
    this.target?.classList.remove("pointed");
    this.target = document.querySelector(at);
    this.target.classList.add("pointed");
    parts.title.textContent = title;
    parts.says.textContent = says;
    parts.place.textContent = `${step + 1} of ${STEPS.length}`;
    /** @type {HTMLButtonElement} */ (parts.before).disabled = step === 0;
    parts.next.textContent = step === STEPS.length - 1 ? "Done" : "Next";
    this.target.scrollIntoView({ block: "nearest" });
    this.#place();
    parts.next.focus({ preventScroll: true });
  }

  #place() {
    besides(this.box, this.target.getBoundingClientRect());
  }
}
