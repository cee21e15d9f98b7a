/** The address of the page: the whole state of what is seen, so that a link shows it on any service. */

import { additions, maskNames } from "./additions.js";
import { chartFields, chartsIn, unreadCharts } from "./charts.js";
import { annotationFields, annotationsIn, unreadAnnotations } from "./annotations.js";
import { machineIn, machineText } from "./machine.js";
import { harmonicParameters, harmonicsOf, harmonicsText, NUMBERS } from "./oscillator.js";
import { same, viewOf } from "./window.js";

/** What is not written. */
const USUAL = { axes: "model", layer: "solution", palette: "colour_blind", overlays: ["grazing", "attractors"], part: 0.5, compare: "swipe" };
/** What there is to choose from. */
const KNOWN = {
  axes: ["model", "machine"], layer: ["solution", "step", "group", "period", "loudness"], palette: ["colour_blind", "paper"], compare: ["swipe", "side"],
  overlays: ["grazing", "attractors", "preimages", "manifolds", "saddles"],
};
const usualOverlays = () => [...maskNames(), ...USUAL.overlays].join(",");
const isOverlay = (name) => KNOWN.overlays.includes(name) || maskNames().includes(name);
/** What completes an address that names a part of a request. */
const OSCILLATOR = { damping: 0.6, eccentricity: 0.1, half_backlash: 0.6 };
const STIFFNESS = 1000;
const WINDOW = { t0: 0, t1: 1, v0: 0, v1: 7 };
const CELLS = [250, 250];
const ITERATIONS = 1499;
const CONTACTS = ["envelope", "one_rotation"];
const MODELS = { "": "impacting", piecewise_linear: "piecewise_linear" };

/**
 * @typedef {{t0: number, t1: number, v0: number, v1: number}} View
 * @typedef {object} Seen
 * @property {string|null} job
 * @property {number} panel
 * @property {BasinRequest|null} request
 * @property {View|null} view null for the whole
 * @property {View|null} whole the window before zooming; null for that of the request
 * @property {string} axes whether they count units of the model or of the machine
 * @property {string} layer
 * @property {string} palette
 * @property {boolean} embed whether the page is in a frame of another, and shows no head
 * @property {string|null} highlight name of the motion that is highlighted
 * @property {string[]} overlays names of those that are on
 * @property {number[][]} motions departures (t, v) that are followed
 * @property {Partial<Seen>|null} beside what is kept beside it, without a view of its own
 * @property {number} part of the width at which that begins
 * @property {Object<string, string>|null} machine in its own units
 * @property {SeenCharts} charts below the plane
 * @property {import("./annotations.js").Annotated} annotated points with labels, and distances
 * @property {string} compare whether it is swiped over what is seen, or lies side by side with it
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
function requestFields(request) {
  const { oscillator, grid, iterations, vary } = request;
  const fields = [];
  if (oscillator.model === "piecewise_linear") fields.push(["model", "piecewise_linear"]);
  for (const name of NUMBERS) if (oscillator[name] !== undefined) fields.push([name, short(oscillator[name])]);
  if (oscillator.harmonics?.length) fields.push(["harmonics", harmonicsText(oscillator.harmonics).replaceAll(" ", "")]);
  if (oscillator.permanent_contact === "one_rotation") fields.push(["permanent_contact", "one_rotation"]);
  if (oscillator.allow_no_quiet_solution) fields.push(["allow_no_quiet_solution", "true"]);
  fields.push(["grid", windowText(viewOf(grid))], ["cells", `${grid.time.cells},${grid.velocity.cells}`], ["k", String(iterations)]);
  for (const swept of vary ?? []) fields.push(["vary", [swept.parameter, ...valuesOf(swept).map(short)].join(",")]);
  for (const { name, address } of additions) {
    const asked = request[name];
    if (asked) fields.push([name, String(typeof asked === "object" ? asked[address.number] : "true")]);
    for (const [of, ends] of Object.entries(asked?.[address.pairs] ?? {})) fields.push([address.pair, [of, ...ends.map(short)].join(",")]);
  }
  return fields;
}

/** What is asked for beside the labels, as parts of a request. */
function addedIn(query) {
  const asked = additions.filter(({ name }) => query.has(name)).map(({ name, address }) => {
    const number = query.get(name);
    const pairs = query.getAll(address.pair).map((text) => {
      const [of, ...ends] = text.split(",");
      return [of, ends.map(Number)];
    });
    return [name, number === "true" ? true : { [address.number]: Number(number), [address.pairs]: Object.fromEntries(pairs) }];
  });
  return Object.fromEntries(asked);
}

function sweptIn(query) {
  return query.getAll("vary").map((text) => {
    const [parameter, ...values] = text.split(",");
    return { parameter, values: values.map(Number) };
  });
}

/** Whether values make a sweep: two or more, ascending. */
function ascends({ values }) {
  return values.length > 1 && values.every((value, i) => Number.isFinite(value) && (i === 0 || value > values[i - 1]));
}

/** Numbers of an oscillator in an address; those that cannot be read are left out. */
function numbersIn(query) {
  return NUMBERS.filter((name) => query.get(name) && Number.isFinite(Number(query.get(name)))).map((name) => [name, Number(query.get(name))]);
}

function cellsOf(query) {
  const cells = numbersOf(query.get("cells"), 2);
  return cells?.every((number) => Number.isInteger(number) && number > 0) ? cells : null;
}

function iterationsOf(query) {
  const k = Number(query.get("k"));
  return Number.isInteger(k) && k > 0 ? k : null;
}

/** Part of the width at which a comparison begins; null where it is none. */
function partOf(query) {
  const part = Number(query.get("part") || NaN);
  return part >= 0 && part <= 1 ? part : null;
}

function requestOf(query) {
  const named = numbersIn(query), window = windowOf(query.get("grid"));
  const all = window && cellsOf(query) && iterationsOf(query);
  if (!all && !named.length && !query.has("model")) return null;
  const grid = window ?? WINDOW;
  const cells = cellsOf(query) ?? CELLS;
  const iterations = iterationsOf(query) ?? ITERATIONS;
  const model = MODELS[query.get("model") ?? ""] ?? "impacting";
  const usual = { ...OSCILLATOR, ...(model === "piecewise_linear" && { stiffness: STIFFNESS }) };
  const oscillator = { model, ...usual, ...Object.fromEntries(named) };
  const harmonics = harmonicsOf(query.get("harmonics") ?? "");
  if (typeof harmonics !== "string" && harmonics.length) oscillator.harmonics = harmonics;
  if (model === "piecewise_linear") oscillator.permanent_contact = CONTACTS.find((rule) => rule === query.get("permanent_contact")) ?? CONTACTS[0];
  if (query.get("allow_no_quiet_solution") === "true") oscillator.allow_no_quiet_solution = true;
  const request = {
    oscillator,
    grid: {
      time: { start: grid.t0, stop: grid.t1, cells: cells[0] },
      velocity: { start: grid.v0, stop: grid.v1, cells: cells[1] },
    },
    iterations,
  };
  const parameters = [...NUMBERS, ...harmonicParameters(oscillator.harmonics)];
  const vary = sweptIn(query).filter((swept) => ascends(swept) && parameters.includes(swept.parameter));
  return vary.length ? { ...request, vary } : { ...request, ...addedIn(query) };
}

/**
 * What an address says that is not known, or lacks, in sentences: it is shown without.
 * @param {string} search
 * @returns {string[]}
 */
export function doubts(search) {
  const query = new URLSearchParams(search);
  const request = requestOf(query);
  const unknown = [];
  for (const name of ["axes", "layer", "palette", "compare"]) if (query.has(name) && !KNOWN[name].includes(query.get(name))) unknown.push(`${name}=${query.get(name)}`);
  for (const name of (query.get("overlays") ?? "").split(",").filter(Boolean)) if (!isOverlay(name)) unknown.push(`overlays=${name}`);
  if (query.has("model") && !(query.get("model") in MODELS) && query.get("model") !== "impacting") unknown.push(`model=${query.get("model")}`);
  for (const name of NUMBERS) if (query.has(name) && !numbersIn(query).some(([known]) => known === name)) unknown.push(`${name}=${query.get(name)}`);
  const { harmonics } = request?.oscillator ?? {};
  const parameters = [...NUMBERS, ...harmonicParameters(harmonics)];
  if (query.get("harmonics") && typeof harmonicsOf(query.get("harmonics")) === "string") unknown.push(`harmonics=${query.get("harmonics")}`);
  if (query.has("permanent_contact") && !CONTACTS.includes(query.get("permanent_contact"))) unknown.push(`permanent_contact=${query.get("permanent_contact")}`);
  for (const name of ["grid", "window", "whole"]) if (query.has(name) && !windowOf(query.get(name))) unknown.push(`${name}=${query.get(name)}`);
  if (query.has("cells") && !cellsOf(query)) unknown.push(`cells=${query.get("cells")}`);
  if (query.has("k") && !iterationsOf(query)) unknown.push(`k=${query.get("k")}`);
  for (const text of query.getAll("motion")) if (!numbersOf(text, 2)) unknown.push(`motion=${text}`);
  if (query.has("part") && partOf(query) === null) unknown.push(`part=${query.get("part")}`);
  unknown.push(...unreadCharts(query), ...unreadAnnotations(query));
  for (const swept of sweptIn(query)) if (!ascends(swept) || !parameters.includes(swept.parameter)) unknown.push(`vary=${[swept.parameter, ...swept.values].join(",")}`);
  const sentences = unknown.length ? [`The address has values that are not known, and is shown without them: ${unknown.join(", ")}.`] : [];
  const lacking = request && !query.has("job") ? [...Object.keys(OSCILLATOR), "grid", "cells", "k"].filter((name) => !query.has(name)) : [];
  if (lacking.length) sentences.push(`The address lacks ${lacking.join(", ")}: the usual values are taken.`);
  return sentences;
}

/** The value if it is known, else the usual one. */
function knownOr(name, value) {
  return KNOWN[name].includes(value) ? value : USUAL[name];
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
    axes: knownOr("axes", query.get("axes")),
    layer: knownOr("layer", query.get("layer")),
    palette: knownOr("palette", query.get("palette")),
    overlays: (query.get("overlays") ?? usualOverlays()).split(",").filter(isOverlay),
    motions,
    highlight: query.get("highlight"),
    embed: query.has("embed"),
    beside: query.get("beside") ? decode(query.get("beside")) : null,
    part: partOf(query) ?? USUAL.part,
    compare: knownOr("compare", query.get("compare")),
    machine: machineIn(query.get("machine")),
    charts: chartsIn(query),
    annotated: annotationsIn(query),
  };
}

/**
 * Address of what is seen.
 * @param {Partial<Seen>} seen
 * @returns {string}
 */
export function encode({ job, panel, request, view, whole, axes, layer, palette, highlight, embed, overlays, motions, beside, part, compare, machine, charts, annotated }) {
  const fields = [];
  if (job) fields.push(["job", job]);
  const numbers = machineText(machine ?? {});
  if (numbers) fields.push(["machine", numbers]);
  if (panel) fields.push(["panel", String(panel)]);
  const asked = request ? viewOf(request.grid) : null;
  if (asked && view && !same(view, whole ?? asked)) fields.push(["window", windowText(view)]);
  if (asked && whole && !same(whole, asked)) fields.push(["whole", windowText(whole)]);
  if (request) fields.push(...requestFields(request));
  if (axes && axes !== USUAL.axes) fields.push(["axes", axes]);
  if (layer && layer !== USUAL.layer) fields.push(["layer", layer]);
  if (palette && palette !== USUAL.palette) fields.push(["palette", palette]);
  if (overlays && overlays.join(",") !== usualOverlays()) fields.push(["overlays", overlays.join(",")]);
  if (embed) fields.push(["embed", "1"]);
  if (highlight) fields.push(["highlight", highlight]);
  for (const motion of motions ?? []) fields.push(["motion", motion.map(short).join(",")]);
  fields.push(...chartFields(charts ?? {}));
  if (annotated) fields.push(...annotationFields(annotated));
  if (beside) fields.push(["beside", encode(beside)]);
  if (beside && part !== undefined && part !== USUAL.part) fields.push(["part", short(part)]);
  if (beside && compare && compare !== USUAL.compare) fields.push(["compare", compare]);
  return fields.length ? `?${fields.map(([name, value]) => `${name}=${encodeURIComponent(value).replaceAll("%2C", ",")}`).join("&")}` : "";
}
