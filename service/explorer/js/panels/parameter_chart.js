/** The chart of two parameters beside the plane: where motions are born, graze and end, with a basin behind every point. */

import { element } from "../charts/chart.js";
import { reading } from "../charts/ticks.js";
import { holds } from "../charts/view.js";
import { oscillatorInWords } from "../look/caption.js";
import { sameOscillator } from "../look/screen.js";
import { get, pathOf } from "../net/api.js";
import { by } from "../page/by.js";
import { parameterInWords, valueIn, withValues } from "../state/oscillator.js";
import { ChartPanel } from "./chart_panel.js";
import { around, parametersOf } from "./diagrams.js";
import { curvesOf, fieldIn, FIELDS, shadesOf } from "./parameter_field.js";
import { swatch } from "./swatch.js";

const KIND = "chart";
/** Coarser than usual, as one click asks for it. */
const SIZE = { lines: 2, longest: 2, pixels: 32, departures: 12 };
const COLOURS = {
  "saddle-node": "#1f4fd8", "period doubling": "#b3261e", grazing: "currentColor", "contact loss": "#7a5c00", "upper grazing": "#6b3fa0", release: "#00695c",
};
const OTHER = "#808080";
const HALF = 6;
/** Where a curve has its name: this part of its points from its beginning, whose room is free. */
const PLACES = [0.5, 0.3, 0.7, 0.15, 0.85];
const [WIDE, HIGH] = [150, 14];

/** Path of a curve's sign in a key. */
function lineSign(colour, dashed) {
  const made = element("svg", { viewBox: "0 0 16 16" });
  made.append(element("path", { d: "M1 8H15", stroke: colour, "stroke-width": 2, fill: "none", ...(dashed && { "stroke-dasharray": "4 3" }) }));
  return made;
}

function diamond(x, y) {
  return `M${x} ${y - HALF}L${x + HALF} ${y}L${x} ${y + HALF}L${x - HALF} ${y}Z`;
}

function pointSign() {
  const made = element("svg", { viewBox: "0 0 16 16" });
  made.append(element("path", { d: diamond(8, 8), fill: "#ffffff", stroke: "#111111", "stroke-width": 1.5 }));
  return made;
}

/** The two parameters of a chart, as requests and addresses have them together. @param {string} text */
function pairOf(text) {
  return text.split(",");
}

/**
 * A chart as it is shown: its curves, its points of codimension two, and what machines do.
 * @typedef {import("./chart_panel.js").JobScene & {
 *   curves: import("./parameter_field.js").Curve[], special: any[], machines: any[], pair: string[]
 * }} ParameterScene
 */

export class ParameterChart {
  name = "parameters";
  kind = KIND;
  offer = "Compute this chart";
  words = { label: "Chart of two parameters", act: "Look at this point", does: "looks at the marked point", walks: "Drag along a line for a film of basins; with Shift, a box to zoom into" };
  note = "The plane shows the basin of the point under the pointer. A click keeps it.";
  none = `${this.note} No curve was found.`;

  /**
   * @param {import("./chart_panel.js").Page & {
   *   paint: (name: string) => Paint, walk: (values: Object<string, number>) => void, back: () => void,
   *   turn: (values: Object<string, number>) => void
   * }} page `paint`: of a motion; `walk`: show a basin while the pointer is there; `back`: show what was seen before;
   *   `turn`: look at other values
   */
  constructor(page) {
    this.page = page;
    this.field = /** @type {HTMLSelectElement} */ (by("parameters-field"));
    this.field.append(...Object.entries(FIELDS).map(([value, { words }]) => new Option(words, value)));
    this.selects = ["first", "second"].map((which) => /** @type {HTMLSelectElement} */ (by(`parameters-${which}`)));
    this.panel = new ChartPanel(this, page);
    this.field.addEventListener("change", () => this.panel.repaint());
    by("parameters-ask").addEventListener("click", () => this.#ask());
  }

  get path() {
    return pathOf({ kind: KIND });
  }

  #ask() {
    const oscillator = this.page.oscillator();
    const pair = this.selects.map(({ value }) => value);
    if (!oscillator || pair[0] === pair[1]) return;
    const [x, y] = pair.map((parameter) => around(parameter, valueIn(oscillator, parameter)));
    this.panel.ask({ parameter: pair.join(","), x, y });
  }

  /** @param {Partial<SeenChart>} wanted */
  title({ parameter }) {
    return `Chart of ${pairOf(parameter).map(parameterInWords).join(" and ")}`;
  }

  /** With the digits that an address has. @param {Oscillator} oscillator @param {SeenChart} wanted */
  body(oscillator, { parameter, x, y }) {
    const [first, second] = pairOf(parameter).map((name, i) => {
      const [start, stop] = [x, y][i].map((end) => Number(end.toPrecision(9)));
      return { parameter: name, start, stop };
    });
    return { oscillator, first, second, ...SIZE };
  }

  /** @param {any} job */
  wantedOf({ request: { first, second } }) {
    return { parameter: `${first.parameter},${second.parameter}`, x: [first.start, first.stop], y: [second.start, second.stop] };
  }

  /** @param {Job} job @param {SeenChart} wanted */
  answers(job, { parameter, x, y }) {
    const has = this.wantedOf(job);
    const meets = (one, other) => one[0] < other[1] && other[0] < one[1];
    return has.parameter === parameter && meets(has.x, x) && meets(has.y, y);
  }

  /** @param {import("./chart_panel.js").JobScene} scene @param {import("../charts/view.js").ChartView} view */
  seenOf({ parameter }, { x, y }) {
    return { parameter, x, y };
  }

  /** @param {import("./chart_panel.js").JobScene} scene @param {Oscillator} seen */
  isOf({ oscillator, parameter }, seen) {
    const none = Object.fromEntries(pairOf(parameter).map((name) => [name, 0]));
    return sameOscillator(withValues(oscillator, none), withValues(seen, none));
  }

  /** A chart takes too long to be computed anew by itself. */
  finer() {
    return null;
  }

  /** What is offered where a part is seen. */
  part = "Compute this part";

  #valuesAt({ x, y }) {
    const scene = /** @type {ParameterScene} */ (this.panel.shown);
    const values = [x, y].map((value) => Number(value.toPrecision(9)));
    return Object.fromEntries(scene.pair.map((name, i) => [name, values[i]]));
  }

  /** A click is where it is. A point of a chart is not of one machine, but of the edge between two. */
  picked(_, __, at) {
    this.page.turn(this.#valuesAt(at));
  }

  walked(place) {
    this.page.walk(this.#valuesAt(place));
  }

  left() {
    this.page.back();
  }

  /** @returns {Promise<ParameterScene>} */
  async sceneOf(job) {
    const { oscillator } = job.request;
    const { parameter, x, y } = this.wantedOf(job);
    const pair = pairOf(parameter);
    const { pixels } = job.request;
    const { result } = job.links;
    const [told, rows, machines] = await Promise.all([get(result), get(`${result}.json?table=curve_point`), pixels ? get(`${result}.json?table=exponent`) : []]);
    const curves = curvesOf(told.curves, rows, pair);
    const special = told.points.map(({ values, ...point }) => ({ ...point, x: values[0], y: values[1] }));
    const [xLabel, yLabel] = pair.map(parameterInWords);
    const scene = {
      id: job.id, job: job.id, oscillator, parameter, pair, curves, special, machines, whole: { x, y },
      points: [...special, ...curves.flatMap((curve) => curve.places)],
      title: `${this.title({ parameter })}. ${oscillatorInWords(oscillator, parameter)}`, file: `chart-${job.id.slice(0, 8)}`,
      xLabel, yLabel,
      words: (point, view) => `${this.#where(point, pair, view)}. ${point.says ?? point.curve.says}`,
      place: (at, view) => `${this.#where(at, pair, view)}. ${fieldIn(this.field.value, scene, at)}`,
      draw: (chart) => this.#draw(scene, chart),
      table: () => [["what", "orbit", ...pair], ...special.map((each) => [each.kind, each.orbit, each.x, each.y]), ...curves.flatMap((curve) => curve.places.map((at) => [curve.kind, curve.orbit, at.x, at.y]))],
      key: (view) => this.#key(scene, view),
    };
    return scene;
  }

  #where({ x, y }, pair, { x: [x0, x1], y: [y0, y1] }) {
    return `${parameterInWords(pair[0])} = ${reading(x, x1 - x0)}, ${parameterInWords(pair[1])} = ${reading(y, y1 - y0)}`;
  }

  /** @param {ParameterScene} scene @param {import("../charts/view.js").ChartView} view */
  #key({ curves, special, machines }, view) {
    const seen = new Map();
    for (const curve of curves) {
      for (const { words, dashed, places } of curve.parts) {
        if (places.some((place) => holds(view, place))) seen.set(words, { sign: lineSign(COLOURS[curve.kind] ?? OTHER, dashed), name: words });
      }
    }
    for (const point of special) if (holds(view, point)) seen.set(point.kind, { sign: pointSign(), name: point.kind });
    const shades = shadesOf(this.field.value, machines, (name) => this.page.paint(name).colour);
    return [...seen.values(), ...shades.key.map(({ colour, name }) => ({ sign: swatch(colour), name }))];
  }

  /** @param {ParameterScene} scene @param {import("../charts/chart.js").Chart} chart */
  #draw(scene, chart) {
    this.#drawMachines(scene, chart);
    for (const curve of scene.curves) {
      for (const { dashed, places } of curve.parts) {
        const stroke = COLOURS[curve.kind] ?? OTHER;
        chart.line(places.map(({ x }) => x), places.map(({ y }) => y), { class: "line", stroke, "data-curve": curve.kind, ...(dashed && { "stroke-dasharray": "6 4" }) });
      }
    }
    this.#nameCurves(scene, chart);
    for (const { x, y, kind } of scene.special) chart.add("path", { class: "special", d: diamond(chart.x(x), chart.y(y)), "data-point": kind });
    this.#list(scene.key({ x: chart.range, y: chart.reach }));
    this.drawn = chart;
    this.here = chart.add("path", { class: "here" });
    this.#moveCross();
  }

  /** What machines do, below: one path for each colour. */
  #drawMachines({ machines, pair }, chart) {
    if (!machines.length) return;
    const { colours } = shadesOf(this.field.value, machines, (name) => this.page.paint(name).colour);
    const steps = pair.map((name) => stepOf(machines.map((row) => row[name])));
    const paths = new Map();
    machines.forEach((row, i) => {
      if (!colours[i]) return;
      const [x0, x1] = [-0.5, 0.5].map((part) => chart.x(row[pair[0]] + part * steps[0]));
      const [y0, y1] = [-0.5, 0.5].map((part) => chart.y(row[pair[1]] + part * steps[1]));
      paths.set(colours[i], `${paths.get(colours[i]) ?? ""}M${x0.toFixed(1)} ${y0.toFixed(1)}H${x1.toFixed(1)}V${y1.toFixed(1)}H${x0.toFixed(1)}Z`);
    });
    for (const [fill, d] of paths) chart.add("path", { class: "machines", d, fill, stroke: fill, "stroke-width": 0.5 });
  }

  /** Names along the curves where there is room for them. */
  #nameCurves({ curves }, chart) {
    const named = [];
    for (const { kind, orbit, places } of curves) {
      const spots = PLACES.map((part) => places[Math.round(part * (places.length - 1))]).filter((place) => holds({ x: chart.range, y: chart.reach }, place));
      const free = spots.map((place) => ({ x: chart.x(place.x), y: chart.y(place.y) })).find((spot) => !named.some((each) => Math.abs(each.x - spot.x) < WIDE && Math.abs(each.y - spot.y) < HIGH));
      if (!free) continue;
      named.push(free);
      chart.add("text", { class: "name", x: free.x + 6, y: free.y - 4 }, `${kind} of ${orbit}`);
    }
  }

  #list(key) {
    by("parameters-key").replaceChildren(...key.map(({ sign, name }) => {
      const line = Object.assign(document.createElement("span"), { className: "key" });
      line.append(sign, name);
      return line;
    }));
  }

  /** Another picture is seen: offer what its oscillator has, and move the cross to its values. */
  follow() {
    this.#parameters();
    if (this.panel.shown && this.drawn) this.#moveCross();
  }

  #moveCross() {
    const { drawn: chart, here } = this;
    const oscillator = this.page.oscillator();
    const [x, y] = /** @type {ParameterScene} */ (this.panel.shown).pair.map((name) => oscillator && valueIn(oscillator, name));
    const inside = typeof x === "number" && typeof y === "number" && holds({ x: chart.range, y: chart.reach }, { x, y });
    here.setAttribute("visibility", inside ? "visible" : "hidden");
    if (inside) here.setAttribute("d", `M${chart.x(x)} ${chart.y(chart.reach[0])}V${chart.y(chart.reach[1])}M${chart.x(chart.range[0])} ${chart.y(y)}H${chart.x(chart.range[1])}`);
  }

  /** Offer the pairs of parameters of the oscillator that is seen, where the service has charts. */
  #parameters() {
    const oscillator = this.page.oscillator();
    by("parameters-choice").hidden = !oscillator || !this.path;
    const parameters = oscillator ? parametersOf(oscillator) : [];
    if (String(parameters) === this.offered) return;
    this.offered = String(parameters);
    this.selects.forEach((select, i) => {
      const before = select.value;
      select.replaceChildren(...parameters.map((name) => new Option(parameterInWords(name), name)));
      select.value = parameters.includes(before) ? before : parameters[i] ?? "";
    });
  }
}

/** Distance of neighbouring values. */
function stepOf(values) {
  const all = [...new Set(values)].sort((a, b) => a - b);
  return all.length > 1 ? (all.at(-1) - all[0]) / (all.length - 1) : 0;
}
