/** Up to two followed motions, drawn on the basin and below it. */

import { showHistories } from "../charts/history.js";
import { followMotion } from "../net/motion.js";
import { attempt } from "../page/say.js";
import { Tooth } from "./tooth.js";

export class Motions {
  /**
   * @param {HTMLElement} section
   * @param {import("../plane/plane.js").Plane} plane
   * @param {import("../plane/marks.js").Marks} marks
   * @param {() => Oscillator|null} oscillator of the visible basin, as in a request
   * @param {() => void} changed called when other motions are followed
   */
  constructor(section, plane, marks, oscillator, changed) {
    this.section = section;
    this.plane = plane;
    this.oscillator = oscillator;
    this.changed = changed;
    /** @type {(at: number|null) => void} */
    this.cursor = () => {};
    this.tooth = new Tooth(section, (at, departure, name) => {
      this.cursor(at);
      marks.showDot(departure, name);
    });
    /** @type {Map<string, Motion>} */
    this.followed = new Map();
    this.era = 0;
    this.second = section.querySelector("#second");
    this.second.addEventListener("click", () => this.#compare(!this.comparing));
    section.querySelector("#forget").addEventListener("click", () => (this.forget(), this.changed()));
  }

  get comparing() {
    return this.second.getAttribute("aria-pressed") === "true";
  }

  #compare(on) {
    this.second.setAttribute("aria-pressed", String(on));
  }

  /** Follow the motion from the centre of the cell at a point, or from the point itself. */
  async pick(place, second, exactly = false) {
    if (place.v <= 0) return;
    const name = this.followed.size && (second || this.comparing) ? "second" : "first";
    this.#compare(false);
    const known = this.plane.at(place.t, place.v);
    const start = exactly || !known ? { ...known, ...place } : known;
    start.t -= Math.floor(start.t);
    const { era } = this;
    let begun = false;
    const show = (motion) => {
      // Its end comes later, perhaps when another motion has been clicked.
      if (era !== this.era || (begun && this.followed.get(name)?.start !== start)) return;
      if (name === "first" && !begun) this.followed.delete("second");
      begun = true;
      this.followed.set(name, motion);
      this.#show();
      this.changed();
    };
    await attempt(async () => show(await followMotion(this.oscillator(), start, show)));
  }

  /** Departures that are followed, as [t, v]. */
  get starts() {
    return [...this.followed.values()].map(({ start }) => [start.t, start.v]);
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

  /** Follow motions from the same departures, of the oscillator that is seen now. */
  async renew() {
    const era = ++this.era;
    for (const [name, { start }] of this.followed) {
      const { t, v } = start;
      const motion = await followMotion(this.oscillator(), { t, v }).catch(() => null);
      if (era !== this.era || !motion) return;
      this.followed.set(name, motion);
      this.#show();
    }
  }

  /** Remove all motions. */
  forget() {
    if (!this.followed.size) return;
    this.era++;
    this.followed.clear();
    this.#show();
  }

  #show() {
    this.plane.motions = new Map([...this.followed].map(([name, { departures }]) => [name, departures]));
    const backlash = this.oscillator()?.half_backlash;
    this.cursor = showHistories(this.section, backlash, this.followed, (at) => this.tooth.seek(at));
    const [name, motion] = [...this.followed].at(-1) ?? ["first", null];
    this.tooth.show(motion, backlash, name);
    this.plane.draw();
  }
}
