/** Sliders of the oscillator: while one moves, the picture follows. */

import { ONLY_IN, USUAL } from "../state/oscillator.js";

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
      row.append(Object.assign(document.createElement("span"), { textContent: slider.label }), value, input);
      place.append(row);
      this.rows.set(slider.name, { slider, row, input, value, most: slider.most });
      input.addEventListener("input", () => {
        const now = fromSlider(slider, Number(input.value));
        this.#write(slider.name, now);
        moving(slider.name, now);
      });
      input.addEventListener("change", () => rested());
    }
  }

  #write(name, value) {
    const { value: output, input } = this.rows.get(name);
    output.textContent = String(Number(value.toPrecision(6)));
    input.setAttribute("aria-valuetext", output.textContent);
  }

  /** Show the values of an oscillator; a value outside a slider's range widens it. */
  show(oscillator) {
    for (const [name, { slider, row, input, most }] of this.rows) {
      const value = oscillator[name] ?? (ONLY_IN[name] === (oscillator.model ?? "impacting") ? USUAL[name] : undefined);
      row.hidden = typeof value !== "number";
      if (row.hidden) continue;
      input.min = toSlider(slider, Math.min(slider.least, value));
      input.max = toSlider(slider, Math.max(most, value));
      if (document.activeElement !== input || Number(input.value) !== toSlider(slider, value)) input.value = toSlider(slider, value);
      this.#write(name, value);
    }
  }

  /** Keep sliders below the bounds that apply. */
  bound(bounds) {
    for (const { field, below } of bounds) {
      const row = this.rows.get(field);
      if (row) row.most = below === null ? row.slider.most : Math.min(row.slider.most, Math.floor(below / row.slider.step - 1e-6) * row.slider.step);
    }
  }
}
