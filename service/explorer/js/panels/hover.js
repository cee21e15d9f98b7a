/** The motion from under the pointer, drawn at once, and in words. */

import { Latest } from "../net/latest.js";
import { briefMotion } from "../net/motion.js";
import { maskInWords, numbersInWords, planeInWords, saddleInWords, underPointer } from "../look/explain.js";
import { reading } from "../charts/ticks.js";
import { inUnits } from "../state/machine.js";

const REST_MS = 30;

export class Hover {
  /**
   * @param {import("../plane/plane.js").Plane} plane
   * @param {import("../plane/marks.js").Marks} marks
   * @param {(place: Departure) => Oscillator|null} oscillator of the half in which a place is
   * @param {(oscillator: Oscillator|null) => Scales|null} scales one unit of the model in SI, where a machine is seen
   * @param {HTMLElement} line
   */
  constructor(plane, marks, oscillator, scales, line) {
    this.scales = scales;
    this.plane = plane;
    this.marks = marks;
    this.oscillator = oscillator;
    this.line = line;
    this.place = null;
    const show = (departures, wish) => wish === this.place && this.marks.showHovered(departures, wish.kept);
    this.latest = new Latest((wish, signal) => briefMotion(this.oscillator(wish), wish, signal), show, () => {});
  }

  /** The pointer is at a place of the plane; null when it has left. @param {Place|null} place */
  at(place) {
    clearTimeout(this.timer);
    this.marks.showPointer(place);
    if (!place) {
      this.latest.drop();
      this.marks.showHovered(null);
      if (this.place) this.left = this.place;
      this.place = null;
      return;
    }
    this.place = place;
    this.read();
    if (place.v > 0 && this.oscillator(place)) this.timer = setTimeout(() => this.latest.want(place), REST_MS);
  }

  /** Say what is known of the place last pointed at; at first, what the plane shows. */
  read() {
    const place = this.place ?? this.left;
    if (!place) {
      this.line.textContent = planeInWords(this.plane.look.layer);
      return;
    }
    const { t0, t1, v0, v1 } = this.plane.view;
    const known = this.plane.at(place);
    const phase = place.t - Math.floor(place.t);
    const scales = this.scales(this.oscillator(place));
    const si = scales ? ` (${inUnits(phase * scales.time, "s")}, ${inUnits(place.v * scales.speed, "m/s")})` : "";
    const where = `t = ${reading(phase, t1 - t0)}   v = ${reading(place.v, v1 - v0)}${si}`;
    const saddle = this.plane.saddleAt(place);
    const there = saddle ?? (known ? known.solution.name + (known.step === undefined ? "" : `   ${numbersInWords(known)}`) : "not known yet");
    const besides = known?.clear ? ` ${maskInWords(known.clear, known.solution, known.mask)}` : "";
    const means = saddle ? saddleInWords(saddle, known?.solution) : known ? underPointer(known.solution) + besides : "";
    this.line.textContent = `${this.plane.keptAt(place) ? "kept: " : ""}${where}   ${there}${this.#besides(place)}\n${means}`;
  }

  /** What the other basin has at the same place, where both are seen as a whole. @param {Place} place */
  #besides(place) {
    const { plane } = this;
    if (!plane.beside || !plane.side) return "";
    const other = plane.at({ ...place, kept: !place.kept });
    return `   ${place.kept ? "seen" : "kept"} there: ${other ? other.solution.name : "not known yet"}`;
  }
}
