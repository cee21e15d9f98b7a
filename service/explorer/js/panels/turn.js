/** Sliders of the oscillator: while one moves, the picture follows. */

import { ONLY_IN, USUAL } from "../state/oscillator.js";
import { refusedBy, shadesOf, stopAt } from "./track.js";

/** @type {{name: string, label: string, least: number, most: number, step: number, means: string, logarithmic?: boolean}[]} */
const SLIDERS = [
  { name: "damping", label: "Damping δ", least: 0.05, most: 1.2, step: 0.001, means: "less of it and the gear rattles more" },
  { name: "eccentricity", label: "Eccentricity ε", least: 0, most: 0.25, step: 0.0005, means: "how strongly the gear is driven" },
  { name: "half_backlash", label: "Half backlash β", least: 0.05, most: 1.5, step: 0.005, means: "half the play between the teeth" },
  { name: "stiffness", label: "Stiffness κ", least: 10, most: 1e6, logarithmic: true, step: 0.01, means: "of the teeth in contact" },
  { name: "restitution", label: "Restitution r", least: 0.5, most: 1, step: 0.005, means: "how much of its speed an impact leaves" },
  { name: "contact_damping", label: "Contact damping ζ", least: 0, most: 0.9, step: 0.005, means: "energy that the teeth lose in contact" },
];

function toSlider({ logarithmic = false }, value) {
  return logarithmic ? Math.log10(Math.max(value, 1e-9)) : value;
}

function fromSlider({ logarithmic = false }, place) {
  return logarithmic ? Number((10 ** place).toPrecision(3)) : place;
}

export class Turn {
  /**
   * @param {HTMLElement} place
   * @param {(name: string, value: number) => void} moving called while a slider moves
   * @param {() => void} rested called when it is let go
   */
  constructor(place, moving, rested) {
    this.place = place;
    this.rows = new Map();
    for (const slider of SLIDERS) {
      const row = document.createElement("label");
      row.className = "turn";
      row.hidden = true;
      row.title = `${slider.label}: ${slider.means}`;
      const input = Object.assign(document.createElement("input"), { type: "range", step: slider.step });
      input.dataset.turn = slider.name;
      const value = document.createElement("output");
      const track = Object.assign(document.createElement("span"), { className: "track" });
      track.append(input);
      row.append(Object.assign(document.createElement("span"), { textContent: slider.label }), value, track);
      place.append(row);
      this.rows.set(slider.name, { slider, row, input, value, track, parts: [], why: "", before: 0 });
      input.addEventListener("input", () => this.#move(slider.name, moving));
      input.addEventListener("change", () => rested());
    }
    this.note = Object.assign(document.createElement("p"), { className: "note" });
    this.note.setAttribute("role", "status");
    place.append(this.note);
  }

  /** The thumb of a slider is moved: as far as the service takes its values. */
  #move(name, moving) {
    const row = this.rows.get(name);
    const { slider, input, parts, why, before } = row;
    const [min, max] = [Number(input.min), Number(input.max)];
    const valueAt = (place) => fromSlider(slider, place);
    const { place, stopped } = stopAt(parts, { min, max, step: slider.step, valueAt }, Number(input.value), before);
    if (stopped) input.value = place;
    const text = stopped ? `${slider.label} stops here: ${why}.` : "";
    if (this.note.textContent !== text) this.note.textContent = text;
    if (place === before) return;
    row.before = place;
    this.#write(name, valueAt(place));
    moving(name, valueAt(place));
  }

  #write(name, value) {
    const { value: output, input } = this.rows.get(name);
    output.textContent = String(Number(value.toPrecision(6)));
    input.setAttribute("aria-valuetext", output.textContent);
  }

  /** Show the values of an oscillator; a value outside a slider's range widens it. */
  show(oscillator) {
    for (const [name, row] of this.rows) {
      const { slider, input } = row;
      const value = oscillator[name] ?? (ONLY_IN[name] === (oscillator.model ?? "impacting") ? USUAL[name] : undefined);
      row.row.hidden = typeof value !== "number";
      if (row.row.hidden) continue;
      input.min = toSlider(slider, Math.min(slider.least, value));
      input.max = toSlider(slider, Math.max(slider.most, value));
      if (document.activeElement !== input || Number(input.value) !== toSlider(slider, value)) input.value = toSlider(slider, value);
      row.before = Number(input.value);
      this.#write(name, value);
      this.#shade(row);
    }
  }

  /** Keep sliders out of what the bounds that apply refuse. */
  bound(bounds) {
    for (const row of this.rows.values()) {
      const bound = bounds.find(({ field }) => field === row.slider.name);
      [row.parts, row.why] = bound ? [refusedBy(bound), bound.why] : [[], ""];
      this.#shade(row);
    }
  }

  #shade({ slider, input, track, parts }) {
    const [min, max] = [Number(input.min), Number(input.max)];
    track.querySelectorAll(".refused").forEach((shade) => shade.remove());
    for (const [from, to] of shadesOf(parts, { min, max, placeOf: (value) => toSlider(slider, value) })) {
      const shade = Object.assign(document.createElement("span"), { className: "refused" });
      // The middle of a thumb keeps half of its width from either end of its track.
      shade.style.left = `calc(${from} * (100% - 1rem) + ${from > 0 ? 0.5 : 0}rem)`;
      shade.style.right = `calc(${1 - to} * (100% - 1rem) + ${to < 1 ? 0.5 : 0}rem)`;
      track.append(shade);
    }
  }
}
