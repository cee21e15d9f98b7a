/** The part of the menu that makes films: what runs, from where to where, its progress, and an end to it. */

import { NUMBERS, parameterInWords, valueIn } from "../state/oscillator.js";
import { stepsOf } from "../state/steps.js";
import { attempt } from "../page/say.js";
import { animated } from "./animate.js";
import { ofSlider, ofSweep, ofTooth } from "./frames.js";
import { recorded } from "./record.js";
import { endsAbout, framesIn, timesOf, valuesBetween } from "./values.js";

const FRAME_MS = 125;
/** How frames become a file, by the ending of its name. */
const FORMATS = { WebM: recorded, GIF: animated };
const SWEEP = "the sweep", TOOTH = "the tooth";

export class Filming {
  /** @param {(film: Blob, name: string) => void} save */
  constructor(save) {
    this.save = save;
    /** @type {AbortController|null} */
    this.running = null;
    this.place = Object.assign(document.createElement("fieldset"), { className: "paper film" });
    this.what = Object.assign(document.createElement("select"), { name: "film.of" });
    this.format = Object.assign(document.createElement("select"), { name: "film.as" });
    this.format.append(...Object.keys(FORMATS).map((name) => new Option(name)));
    this.fields = Object.fromEntries([["from", "From"], ["to", "To"], ["count", "Frames"]].map(([name]) => [name, Object.assign(document.createElement("input"), { name: `film.${name}`, inputMode: "decimal", autocomplete: "off" })]));
    this.fields.count.value = "24";
    this.button = Object.assign(document.createElement("button"), { type: "button" });
    this.told = Object.assign(document.createElement("p"), { className: "note" });
    this.told.setAttribute("role", "status");
    const labelled = (words, field) => {
      const label = Object.assign(document.createElement("label"), { textContent: words });
      label.append(field);
      return label;
    };
    this.place.append(
      Object.assign(document.createElement("legend"), { textContent: "Film" }), labelled("Of", this.what),
      ...Object.entries({ From: this.fields.from, To: this.fields.to, Frames: this.fields.count }).map(([words, field]) => labelled(words, field)), labelled("As", this.format), this.button, this.told,
    );
    this.what.addEventListener("change", () => this.#ends());
    this.button.addEventListener("click", () => (this.running ? this.running.abort() : attempt(() => this.#film())));
    this.#show();
  }

  /** Offer what is seen now. @param {{plane: any, job: Job|null, motions: any, oscillator: Oscillator|null, title: string, overlays: string[]}} seen */
  offer(seen) {
    this.place.hidden = !seen.oscillator || !seen.plane.picture;
    if (this.running || this.place.hidden) return;
    this.seen = seen;
    const turned = NUMBERS.filter((name) => typeof valueIn(seen.oscillator, name) === "number");
    const steps = seen.job?.state === "succeeded" && seen.job.request.grid ? stepsOf(seen.job.request).length : 0;
    const options = [...turned.map((name) => [name, parameterInWords(name)]), ...(steps ? [[SWEEP, SWEEP]] : []), ...(seen.motions.followed.has("first") ? [[TOOTH, TOOTH]] : [])];
    const before = this.what.value;
    this.what.replaceChildren(...options.map(([value, words]) => new Option(words, value)));
    if (options.some(([value]) => value === before)) this.what.value = before;
    this.#ends();
  }

  #ends() {
    const value = valueIn(this.seen.oscillator, this.what.value);
    const slider = typeof value === "number";
    for (const field of [this.fields.from, this.fields.to]) field.disabled = !slider;
    this.fields.count.disabled = this.what.value === SWEEP;
    const { from, to } = slider ? endsAbout(value) : { from: "", to: "" };
    [this.fields.from.value, this.fields.to.value] = [from, to];
  }

  #show(words = "") {
    this.button.textContent = this.running ? "Stop" : "Make the film";
    this.told.textContent = words;
  }

  /** Frames, and how many there will be. @returns {[AsyncIterable<HTMLCanvasElement>|Iterable<HTMLCanvasElement>, number]} */
  #frames(signal) {
    const { seen, what, fields } = this;
    if (what.value === SWEEP) return [ofSweep(seen, signal), stepsOf(seen.job.request).reduce((product, { values }) => product * values.length, 1)];
    const count = framesIn(Number(fields.count.value));
    if (what.value === TOOTH) {
      const motion = seen.motions.followed.get("first");
      return [ofTooth(seen, motion, timesOf(motion, count)), count];
    }
    const values = valuesBetween({ from: fields.from.value, to: fields.to.value, count: fields.count.value });
    return [ofSlider(seen, what.value, values, signal), count];
  }

  async #film() {
    this.running = new AbortController();
    const { signal } = this.running;
    const format = this.format.value;
    try {
      const [frames, count] = this.#frames(signal);
      const made = [];
      this.#show(`Frame 1 of ${count}.`);
      for await (const frame of frames) {
        signal.throwIfAborted();
        made.push(frame);
        this.#show(made.length < count ? `Frame ${made.length + 1} of ${count}.` : "Writing the film.");
      }
      this.save(await FORMATS[format](made, FRAME_MS, signal), `gear-rattle.${format.toLowerCase()}`);
      this.running = null;
      this.#show("The film is saved.");
    } catch (error) {
      this.running = null;
      this.#show(error.name === "AbortError" ? "Stopped." : "");
      throw error;
    }
  }
}
