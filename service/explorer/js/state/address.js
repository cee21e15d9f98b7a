/** The address of the page: the whole state of what is seen, so that a link shows it on any service. */

import { harmonicsOf, harmonicsText, NUMBERS } from "./oscillator.js";
import { same, viewOf } from "./window.js";

/** What is not written. */
const USUAL = { layer: "solution", palette: "colour_blind", overlays: "proven,grazing,attractors", part: 0.5 };
const MODELS = { "": "impacting", piecewise_linear: "piecewise_linear" };

/**
 * @typedef {{t0: number, t1: number, v0: number, v1: number}} View
 * @typedef {object} Seen
 * @property {string|null} job
 * @property {number} panel
 * @property {BasinRequest|null} request
 * @property {View|null} view null for the whole
 * @property {View|null} whole the window before zooming; null for that of the request
 * @property {string} layer
 * @property {string} palette
 * @property {string[]} overlays names of those that are on
 * @property {number[][]} motions departures (t, v) that are followed
 * @property {Partial<Seen>|null} beside what is kept beside it, without a view of its own
 * @property {number} part of the width at which that begins
 */

function short(number) {
  return String(Number(number.toPrecision(12)));
}

function numbersOf(text, count) {
  const numbers = (text ?? "").split(",").map(Number);
  return text && numbers.length === count && numbers.every(Number.isFinite) ? numbers : null;
}

function windowOf(text) {
  const numbers = numbersOf(text, 4);
  if (!numbers) return null;
  const [t0, t1, v0, v1] = numbers;
  return t0 < t1 && v0 < v1 ? { t0, t1, v0, v1 } : null;
}

/** A window as addresses have it. */
export function windowText({ t0, t1, v0, v1 }) {
  return [t0, t1, v0, v1].map(short).join(",");
}

/** @param {Swept} swept */
function valuesOf({ values, start, stop, count }) {
  return values ?? Array.from({ length: count }, (_, i) => start + ((stop - start) * i) / Math.max(count - 1, 1));
}

/** @param {BasinRequest} request */
function requestFields({ oscillator, grid, iterations, vary, prove }) {
  const fields = [];
  if (oscillator.model === "piecewise_linear") fields.push(["model", "piecewise_linear"]);
  for (const name of NUMBERS) if (oscillator[name] !== undefined) fields.push([name, short(oscillator[name])]);
  if (oscillator.harmonics?.length) fields.push(["harmonics", harmonicsText(oscillator.harmonics).replaceAll(" ", "")]);
  if (oscillator.permanent_contact === "one_rotation") fields.push(["permanent_contact", "one_rotation"]);
  if (oscillator.allow_no_quiet_solution) fields.push(["allow_no_quiet_solution", "true"]);
  fields.push(["grid", windowText(viewOf(grid))], ["cells", `${grid.time.cells},${grid.velocity.cells}`], ["k", String(iterations)]);
  for (const swept of vary ?? []) fields.push(["vary", [swept.parameter, ...valuesOf(swept).map(short)].join(",")]);
  const { levels, tolerances } = typeof prove === "object" ? prove : { levels: "true", tolerances: {} };
  if (prove) fields.push(["prove", String(levels)]);
  for (const [name, ends] of Object.entries(tolerances)) fields.push(["tolerance", [name, ...ends.map(short)].join(",")]);
  return fields;
}

/** What is to be proven, as a part of a request. */
function proofOf(query) {
  const levels = query.get("prove");
  if (levels === null) return {};
  if (levels === "true") return { prove: true };
  const tolerances = query.getAll("tolerance").map((text) => {
    const [name, ...ends] = text.split(",");
    return [name, ends.map(Number)];
  });
  return { prove: { levels: Number(levels), tolerances: Object.fromEntries(tolerances) } };
}

function requestOf(query) {
  const grid = windowOf(query.get("grid"));
  const cells = numbersOf(query.get("cells"), 2);
  const iterations = Number(query.get("k"));
  if (!grid || !cells || !iterations) return null;
  const model = MODELS[query.get("model") ?? ""] ?? "impacting";
  const oscillator = { model };
  for (const name of NUMBERS) if (query.has(name)) oscillator[name] = Number(query.get(name));
  const harmonics = harmonicsOf(query.get("harmonics") ?? "");
  if (typeof harmonics !== "string" && harmonics.length) oscillator.harmonics = harmonics;
  if (model === "piecewise_linear") oscillator.permanent_contact = query.get("permanent_contact") ?? "envelope";
  if (query.get("allow_no_quiet_solution") === "true") oscillator.allow_no_quiet_solution = true;
  const request = {
    oscillator,
    grid: {
      time: { start: grid.t0, stop: grid.t1, cells: cells[0] },
      velocity: { start: grid.v0, stop: grid.v1, cells: cells[1] },
    },
    iterations,
  };
  const vary = query.getAll("vary").map((text) => {
    const [parameter, ...values] = text.split(",");
    return { parameter, values: values.map(Number) };
  });
  return vary.length ? { ...request, vary } : { ...request, ...proofOf(query) };
}

/**
 * What an address shows.
 * @param {string} search
 * @returns {Seen}
 */
export function decode(search) {
  const query = new URLSearchParams(search);
  const motions = query.getAll("motion").map((text) => numbersOf(text, 2)).filter((each) => each !== null);
  return {
    job: query.get("job"),
    panel: Number(query.get("panel")) || 0,
    request: requestOf(query),
    view: windowOf(query.get("window")),
    whole: windowOf(query.get("whole")),
    layer: query.get("layer") ?? USUAL.layer,
    palette: query.get("palette") ?? USUAL.palette,
    overlays: (query.get("overlays") ?? USUAL.overlays).split(",").filter(Boolean),
    motions,
    beside: query.get("beside") ? decode(query.get("beside")) : null,
    part: query.has("part") ? Number(query.get("part")) : USUAL.part,
  };
}

/**
 * Address of what is seen.
 * @param {Partial<Seen>} seen
 * @returns {string}
 */
export function encode({ job, panel, request, view, whole, layer, palette, overlays, motions, beside, part }) {
  const fields = [];
  if (job) fields.push(["job", job]);
  if (panel) fields.push(["panel", String(panel)]);
  const asked = request ? viewOf(request.grid) : null;
  if (asked && view && !same(view, whole ?? asked)) fields.push(["window", windowText(view)]);
  if (asked && whole && !same(whole, asked)) fields.push(["whole", windowText(whole)]);
  if (request) fields.push(...requestFields(request));
  if (layer && layer !== USUAL.layer) fields.push(["layer", layer]);
  if (palette && palette !== USUAL.palette) fields.push(["palette", palette]);
  if (overlays && overlays.join(",") !== USUAL.overlays) fields.push(["overlays", overlays.join(",")]);
  for (const motion of motions ?? []) fields.push(["motion", motion.map(short).join(",")]);
  if (beside) fields.push(["beside", encode(beside)]);
  if (beside && part !== undefined && part !== USUAL.part) fields.push(["part", short(part)]);
  return fields.length ? `?${fields.map(([name, value]) => `${name}=${encodeURIComponent(value).replaceAll("%2C", ",")}`).join("&")}` : "";
}
