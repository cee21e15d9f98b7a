/** Two basins with one view: the one that was kept, swiped over the one that is seen. */

import { oscillatorInWords } from "../look/caption.js";

export class Comparison {
  /**
   * @param {{button: HTMLButtonElement, range: HTMLInputElement}} controls
   * @param {import("../plane/plane.js").Plane} plane
   * @param {import("../look/screen.js").Screen} screen
   */
  constructor({ button, range }, plane, screen) {
    button.addEventListener("click", () => {
      const on = plane.beside === null && plane.picture !== null;
      const label = on ? `kept: ${oscillatorInWords(screen.oscillator)}` : "";
      plane.beside = on ? { pictures: [...plane.stack.drawn], part: Number(range.value), label } : null;
      button.setAttribute("aria-pressed", String(on));
      range.hidden = !on;
      plane.draw();
    });
    range.addEventListener("input", () => {
      plane.beside.part = Number(range.value);
      plane.draw();
    });
  }
}
