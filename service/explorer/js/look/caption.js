/** What the picture shows, in words. */

import { reading } from "../charts/ticks.js";
import { harmonicsText } from "../state/oscillator.js";

const SYMBOLS = [["damping", "δ"], ["eccentricity", "ε"], ["half_backlash", "β"], ["stiffness", "κ"], ["restitution", "r"], ["contact_damping", "ζ"]];
const MODELS = { impacting: "Impacts", piecewise_linear: "Contacts of finite stiffness" };

function number(value) {
  return typeof value === "number" ? String(Number(value.toPrecision(6))) : "?";
}

/** An oscillator in words, such as "Impacts: δ = 0.6, ε = 0.1, β = 0.6", without numbers that vary, by commas. */
export function oscillatorInWords(oscillator, without = "") {
  const values = SYMBOLS.filter(([name]) => oscillator[name] !== undefined && !without.split(",").includes(name)).map(([name, symbol]) => `${symbol} = ${number(oscillator[name])}`);
  const harmonics = oscillator.harmonics?.length ? [`harmonics ${harmonicsText(oscillator.harmonics)}`] : [];
  return `${MODELS[oscillator.model ?? "impacting"]}: ${[...values, ...harmonics].join(", ")}`;
}

/** A window in words. */
export function windowInWords({ t0, t1, v0, v1 }) {
  const short = (value, width) => String(Number(reading(value, width)));
  return `t from ${short(t0, t1 - t0)} to ${short(t1, t1 - t0)}, v from ${short(v0, v1 - v0)} to ${short(v1, v1 - v0)}`;
}

/** What each layer's colours are. */
const LAYERS = {
  solution: "Colours are the motions that departures end in.",
  step: "Colours are Hsu's steps: how soon the cycle of cells is reached.",
  group: "Colours are Hsu's groups: which cycle of cells is reached.",
  period: "Colours are Hsu's periods: how long the cycle of cells is.",
  loudness: "Colours are the impact power of the motions that departures end in.",
};

/**
 * What a picture shows, in sentences that can stand below it: parameters, window, and what to cite.
 * @param {object} seen
 * @param {Oscillator} seen.oscillator
 * @param {import("../plane/picture.js").Picture} seen.picture on top
 * @param {View} seen.view
 * @param {string} seen.layer
 * @param {number|null} seen.iterations of a job
 * @param {{program: string, paper: string}} seen.cited
 */
export function captionOf({ oscillator, picture, view, layer, iterations, cited }) {
  const { time, velocity } = picture.outline;
  const from = picture.isPreview ? ", a preview" : `, k = ${iterations}`;
  return [
    `Basins of attraction of a rattling gear pair. ${oscillatorInWords(oscillator)}.`,
    `Departures at ${windowInWords(view)}, ${time.cells} × ${velocity.cells} cells${from}.`,
    LAYERS[picture.isPreview && layer !== "loudness" ? "solution" : layer],
    `Computed with ${cited.program}. ${cited.paper}.`,
  ].join(" ");
}

/**
 * Where the picture comes from: {words, kind}.
 * @param {import("../plane/picture.js").Picture|null} picture the picture on top
 * @param {boolean} edited whether the form has been changed since
 * @param {boolean} refused whether the service refuses what the form has now
 * @param {Job|null} job the job of the picture
 */
export function standing(picture, edited, job, refused) {
  if (refused) return { words: `There is no picture of what the request says${picture ? "; this one is of the values above it" : ""}.`, kind: "edited" };
  if (!picture) return { words: "", kind: "none" };
  const { time, velocity } = picture.outline;
  const cells = `${time.cells} × ${velocity.cells} cells`;
  const preview = picture.isPreview ? `${picture.quick ? "First look (what is slow to settle may change)" : "Preview"}, ` : "";
  if (edited) return { words: `${preview}${cells}: edited, not computed.`, kind: "edited" };
  if (preview) return { words: `${preview}${cells}${job ? "" : "; Compute refines it"}.`, kind: "preview" };
  const k = job ? `, k = ${job.request.iterations}` : "";
  return { words: `${cells}${k}.`, kind: picture.outline.complete ? "complete" : "coming" };
}

/**
 * Write the caption of the picture, where it comes from, and the title of the page.
 * @param {{shown: HTMLElement, standing: HTMLElement}} lines
 * @param {object} seen
 * @param {string|null} seen.kind of an analysis, in words
 * @param {Job|null} seen.job
 * @param {Oscillator|null} seen.oscillator
 * @param {import("../plane/picture.js").Picture|null} seen.picture
 * @param {boolean} seen.edited
 * @param {boolean} seen.refused
 * @param {string} seen.doubts about the address
 */
export function showCaption(lines, { kind, job, oscillator, picture, edited, refused, doubts }) {
  const text = kind ?? (oscillator ? oscillatorInWords(oscillator) : "");
  const origin = standing(picture, edited, job, refused);
  const words = [doubts, kind ? "" : origin.words].filter(Boolean).join(" ");
  lines.shown.textContent = text;
  // Readers of the screen would hear the same again.
  if (lines.standing.textContent !== words) lines.standing.textContent = words;
  lines.standing.dataset.kind = origin.kind;
  document.title = text ? `${text} · gear-rattle` : "gear-rattle";
}
