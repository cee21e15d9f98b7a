/** The tooth: a motion played in its backlash, in step with a cursor on the history and a dot on the basin. */

import { by } from "../page/by.js";
import { departureAt, displacementAt, glowAt, impactsBetween, Clock } from "../tooth/playing.js";
import { drawTooth } from "../tooth/drawing.js";
import { Clicks } from "../tooth/sound.js";

const PERIODS_A_SECOND = 0.6;
const FADE_PERIODS = 0.08;
const LONGEST_FRAME = 0.1;

export class Tooth {
  /**
   * @param {HTMLElement} section
   * @param {(at: number, departure: object|null, name: string) => void} played called at every frame
   */
  constructor(section, played) {
    /** @type {HTMLCanvasElement} */
    this.canvas = section.querySelector("#tooth-canvas");
    this.button = section.querySelector("#play");
    this.sound = section.querySelector("#sound");
    /** @type {HTMLInputElement} */
    this.speed = section.querySelector("#speed");
    this.played = played;
    this.clicks = new Clicks();
    /** @type {Motion|null} */
    this.motion = null;
    this.backlash = 1;
    this.name = "first";
    this.running = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.frame = 0;
    this.button.addEventListener("click", () => this.#run(!this.running));
    this.sound.addEventListener("click", () => {
      this.clicks.toggle();
      this.sound.setAttribute("aria-pressed", String(this.clicks.on));
    });
    this.speed.addEventListener("input", () => this.clock && (this.clock.speed = this.#pace()));
    new ResizeObserver(() => this.#draw()).observe(this.canvas);
    this.#settle(section.querySelector("#tooth"));
  }

  /** On a narrow screen the tooth moves over the plane, which stays in sight. */
  #settle(home) {
    const narrow = matchMedia("(max-width: 50rem)");
    const settle = () => (narrow.matches ? by("frame").append(this.canvas) : home.prepend(this.canvas));
    narrow.addEventListener("change", settle);
    settle();
  }

  #pace() {
    return PERIODS_A_SECOND * 2 ** Number(this.speed.value);
  }

  /** Play a motion as from `followMotion`; null stops. */
  show(motion, backlash, name) {
    cancelAnimationFrame(this.frame);
    this.motion = motion;
    this.canvas.classList.toggle("still", !motion);
    if (!motion) {
      this.played(null, null, "first");
      return;
    }
    this.backlash = backlash;
    this.name = name;
    const { time } = motion.shown;
    this.clock = new Clock(time[0], time.at(-1), this.#pace());
    this.fastest = motion.shown.contacts.reduce((most, { speed }) => Math.max(most, Math.abs(speed)), 0) || 1;
    this.#run(this.running);
    this.#draw();
  }

  /** Move the tooth to a time of its history. */
  seek(at) {
    if (!this.motion) return;
    this.clock.at = Math.min(Math.max(at, this.clock.from), this.clock.to);
    this.#draw();
  }

  #run(on) {
    this.running = on;
    this.button.textContent = on ? "Pause" : "Play";
    cancelAnimationFrame(this.frame);
    let before = null;
    const next = (now) => {
      if (!this.motion || !this.running) return;
      if (before !== null) this.#advance(Math.min((now - before) / 1000, LONGEST_FRAME));
      before = now;
      this.frame = requestAnimationFrame(next);
    };
    if (on && this.motion) this.frame = requestAnimationFrame(next);
  }

  #advance(seconds) {
    const { before, after } = this.clock.run(seconds);
    for (const { speed } of impactsBetween(this.motion.shown, before, after)) this.clicks.click((speed / this.fastest) ** 2);
    this.#draw();
  }

  #draw() {
    if (!this.motion || !this.canvas.clientWidth) return;
    const { shown, departures } = this.motion;
    const { at } = this.clock;
    const glow = glowAt(shown, at, FADE_PERIODS);
    drawTooth(this.canvas, { displacement: displacementAt(shown, at), backlash: this.backlash, glow, name: this.name });
    this.played(at, departureAt(departures, at), this.name);
  }
}
