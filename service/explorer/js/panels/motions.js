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
      marks.showDot(departure, name, Boolean(this.followed.get(name)?.kept));
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
   * @param {Departure & {kept?: boolean}} place
   */
  async pick(place, second, exactly = false) {
    if (place.v <= 0) return;
    await this.#pick(place, second, exactly, this.plane.keptAt(place));
  }

  /** Follow a motion of the basin that was kept. @param {import("../plane/half.js").Half} kept */
  pickKept(place, second, kept) {
    return this.#pick(place, second, true, kept);
  }

  async #pick(place, second, exactly, kept) {
    const name = this.followed.size && (second || this.comparing) ? "second" : "first";
    this.#compare(false);
    const start = exactly ? { t: digits(place.t - Math.floor(place.t)), v: digits(place.v) } : this.#rounded(place);
    if (start.v <= 0) return;
    const { era } = this;
    const wish = (this.wish = {});
    await attempt(async () => {
      const motion = { ...await followMotion(kept?.oscillator ?? this.oscillator(), start), kept };
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

  /** Departures that are followed, as [t, v]: of the basin that is seen, or of the one that was kept. */
  startsOf(ofKept) {
    return [...this.followed.values()].filter(({ kept }) => Boolean(kept) === ofKept).map(({ start }) => [start.t, start.v]);
  }

  /** Follow no motion any more of the basin that was kept. */
  forgetKept() {
    for (const [name, { kept }] of this.followed) if (kept) this.followed.delete(name);
    this.#show();
  }

  /** Say again what the cells of the followed motions are: there is another picture. */
  told() {
    for (const line of /** @type {NodeListOf<HTMLElement>} */ (this.section.querySelectorAll("[data-cell]"))) {
      const motion = this.followed.get(line.dataset.cell);
      if (motion) line.textContent = this.#cellOf(motion);
    }
  }

  /** @param {Motion} motion */
  #cellOf({ start, end, kept }) {
    const known = this.plane.at({ ...start, kept: Boolean(kept) });
    return known ? cellInWords(known.solution, end) : "";
  }

  /** Follow motions from the same departures, of the oscillator that is seen now. */
  async renew() {
    const era = ++this.era;
    for (const [name, { start, kept }] of this.followed) {
      if (kept) continue;
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
    this.plane.motions = new Map([...this.followed].map(([name, { departures, kept }]) => [name, { departures, kept }]));
    /** @param {Motion} motion */
    const backlashOf = ({ kept }) => (kept?.oscillator ?? this.oscillator())?.half_backlash;
    this.cursor = showHistories(this.section, backlashOf, this.followed, (at) => this.tooth.seek(at));
    this.told();
    const [name, motion] = [...this.followed].at(-1) ?? ["first", null];
    this.tooth.show(motion, motion && backlashOf(motion), name);
    this.plane.draw();
  }
}
