/** Up to two followed motions, drawn on the basin and below it. */

import { showHistories } from "../charts/history.js";
import { reading } from "../charts/ticks.js";
import { cellInWords } from "../look/explain.js";
import { followMotion } from "../net/motion.js";
import { attempt } from "../page/say.js";
import { Tooth } from "./tooth.js";

/** As many digits as an address holds. */
function digits(number) {
  return Number(number.toPrecision(12));
}

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

  /**
   * Follow the motion from a point: from one that was clicked, rounded to the digits that are shown, or exactly from
   * one that is given in numbers.
   */
  async pick(place, second, exactly = false) {
    if (place.v <= 0) return;
    const name = this.followed.size && (second || this.comparing) ? "second" : "first";
    this.#compare(false);
    const start = exactly ? { t: digits(place.t - Math.floor(place.t)), v: digits(place.v) } : this.#rounded(place);
    if (start.v <= 0) return;
    const { era } = this;
    const wish = (this.wish = {});
    await attempt(async () => {
      const motion = await followMotion(this.oscillator(), start);
      // Another motion may have been clicked meanwhile.
      if (era !== this.era || (name === "first" && wish !== this.wish)) return;
      if (name === "first") this.followed.delete("second");
      this.followed.set(name, motion);
      this.#show();
      this.changed();
    });
  }

  /** The departure that the numbers under the plane name. */
  #rounded({ t, v }) {
    const { t0, t1, v0, v1 } = this.plane.view;
    return { t: Number(reading(t - Math.floor(t), t1 - t0)) % 1, v: Number(reading(v, v1 - v0)) };
  }

  /** Departures that are followed, as [t, v]. */
  get starts() {
    return [...this.followed.values()].map(({ start }) => [start.t, start.v]);
  }

  /** Say again what the cells of the followed motions are: there is another picture. */
  told() {
    for (const line of /** @type {NodeListOf<HTMLElement>} */ (this.section.querySelectorAll("[data-cell]"))) {
      const motion = this.followed.get(line.dataset.cell);
      if (motion) line.textContent = this.#cellOf(motion);
    }
  }

  #cellOf({ start, end }) {
    const known = this.plane.at(start.t, start.v);
    return known ? cellInWords(known.solution, end) : "";
  }

  /** Follow motions from the same departures, of the oscillator that is seen now. */
  async renew() {
    const era = ++this.era;
    for (const [name, { start }] of this.followed) {
      const motion = await followMotion(this.oscillator(), start).catch(() => null);
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
    this.told();
    const [name, motion] = [...this.followed].at(-1) ?? ["first", null];
    this.tooth.show(motion, backlash, name);
    this.plane.draw();
  }
}
