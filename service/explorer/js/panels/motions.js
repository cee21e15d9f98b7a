/** Up to two followed motions, drawn on the basin and below it. */

import { showHistories } from "../charts/history.js";
import { followMotion } from "../net/motion.js";
import { attempt } from "../page/say.js";

export class Motions {
  /**
   * @param {HTMLElement} section
   * @param {import("../plane/plane.js").Plane} plane
   * @param {() => object} oscillator of the visible basin, as in a request
   */
  constructor(section, plane, oscillator) {
    this.section = section;
    this.plane = plane;
    this.oscillator = oscillator;
    this.followed = new Map();
    this.era = 0;
    this.second = section.querySelector("#second");
    this.second.addEventListener("click", () => this.#compare(!this.comparing));
    section.querySelector("#forget").addEventListener("click", () => this.forget());
  }

  get comparing() {
    return this.second.getAttribute("aria-pressed") === "true";
  }

  #compare(on) {
    this.second.setAttribute("aria-pressed", String(on));
  }

  /** Follow the motion from the centre of the cell at a point. */
  async pick(place, second) {
    if (place.v <= 0) return;
    const name = this.followed.size && (second || this.comparing) ? "second" : "first";
    this.#compare(false);
    const start = this.plane.at(place.t, place.v) ?? { ...place };
    start.t -= Math.floor(start.t);
    const { era } = this;
    await attempt(async () => {
      const motion = await followMotion(this.oscillator(), start);
      if (era !== this.era) return;
      if (name === "first") this.followed.delete("second");
      this.followed.set(name, motion);
      this.#show();
    });
  }

  /** Follow motions again whose cells were not computed yet, once they are. */
  async again() {
    const { era } = this;
    for (const [name, { start }] of this.followed) {
      const known = start.solution ? null : this.plane.at(start.t, start.v);
      if (!known) continue;
      const motion = await followMotion(this.oscillator(), known);
      if (era !== this.era) return;
      this.followed.set(name, motion);
      this.#show();
    }
  }

  /** Remove all motions. */
  forget() {
    this.era++;
    this.followed.clear();
    this.#show();
  }

  #show() {
    this.plane.motions = new Map([...this.followed].map(([name, { departures }]) => [name, departures]));
    showHistories(this.section, this.oscillator()?.half_backlash, this.followed);
    this.plane.draw();
  }
}
