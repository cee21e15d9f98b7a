/** Bifurcation diagrams of the oscillator that is seen: charts whose cursor is the slider of their parameter. */

import { reading } from "../charts/ticks.js";
import { holds } from "../charts/view.js";
import { oscillatorInWords } from "../look/caption.js";
import { sameOscillator } from "../look/screen.js";
import { get } from "../net/api.js";
import { by } from "../page/by.js";
import { harmonicParameters, NUMBERS, ONLY_IN, parameterInWords, valueIn, withValues } from "../state/oscillator.js";
import { byMotion, markAt, NO_PERIOD } from "./branches.js";
import { ChartPanel } from "./chart_panel.js";
import { swatch } from "./swatch.js";

const VALUES = 300;
// Periods of up to half as many impacts are seen.
const KEPT = 24;
const REACH = 0.15;
const LISTED = 12;
/** A view of less than this part of the values that are there is computed anew. */
const FEW = 0.5;
/** Where a range ends that begins at 0. */
const LITTLE = 0.02;

/** Parameters that a chart may go over. @param {Oscillator} oscillator that is seen */
export function parametersOf({ model, harmonics }) {
  const own = NUMBERS.filter((name) => (ONLY_IN[name] ?? model) === model);
  return [...own, ...harmonicParameters(harmonics)];
}

/** Range of a parameter around its value: a phase goes once around, and no loss is more than all or less than none. */
export function around(parameter, value) {
  if (parameter.startsWith("phase")) return [0, 1];
  if (parameter === "restitution") return [value * (1 - REACH), Math.min(value * (1 + REACH), 1)];
  if (value === 0) return [0, LITTLE];
  return [value * (1 - REACH), value * (1 + REACH)];
}

/**
 * A diagram as it is shown: rows of the table of departures by motion, and how many impacts were kept.
 * @typedef {import("./chart_panel.js").JobScene & {motions: Map<string, any[]>, kept: number}} DiagramScene
 */

function inWords(name, kept) {
  return name === NO_PERIOD ? `no period within ${Math.floor(kept / 2)} impacts: chaos, or longer` : name;
}

export class Diagrams {
  name = "diagram";
  kind = "bifurcation";
  path = "/v1/bifurcations";
  offer = "Compute this diagram";
  words = { label: "Bifurcation diagram", act: "Look at this value", does: "looks at the value of the marked point" };
  note = "Each dot is a departure that lasts. Click to look at a value, drag a box to zoom; a narrow range is computed anew.";

  /**
   * @param {import("./chart_panel.js").Page & {
   *   paint: (name: string) => Paint, turn: (values: Object<string, number>) => void
   * }} page `paint`: of a motion on the basin; `turn`: look at other values
   */
  constructor(page) {
    this.page = page;
    this.panel = new ChartPanel(this, page);
  }

  /** @param {Partial<SeenChart>} wanted */
  title({ parameter }) {
    return `Bifurcation diagram over ${parameterInWords(parameter)}`;
  }

  /** With the digits that an address has. @param {Oscillator} oscillator @param {SeenChart} wanted */
  body(oscillator, { parameter, x }) {
    const [start, stop] = x.map((end) => Number(end.toPrecision(9)));
    return { oscillator, vary: { parameter, start, stop, count: VALUES }, direction: "both", transient: 600, kept: KEPT };
  }

  /** @param {any} job */
  wantedOf({ request: { vary } }) {
    return { parameter: vary.parameter, x: [vary.values[0], vary.values.at(-1)], y: null };
  }

  /** @param {Job} job @param {SeenChart} wanted */
  answers(job, { parameter, x }) {
    const has = this.wantedOf(job);
    return has.parameter === parameter && has.x[0] < x[1] && has.x[1] > x[0];
  }

  /** @param {import("./chart_panel.js").JobScene} scene @param {import("../charts/view.js").ChartView} view */
  seenOf({ parameter, whole }, { x, y }) {
    return { parameter, x, y: String(y) === String(whole.y) ? null : y };
  }

  /** @param {import("./chart_panel.js").JobScene} scene @param {Oscillator} seen */
  isOf({ oscillator, parameter }, seen) {
    return sameOscillator(withValues(oscillator, { [parameter]: 0 }), withValues(seen, { [parameter]: 0 }));
  }

  /**
   * The part that is computed anew where few of the values are seen.
   * @param {import("./chart_panel.js").JobScene} scene
   * @param {import("../charts/view.js").ChartView} view
   */
  finer({ parameter, whole }, { x }) {
    return x[1] - x[0] < FEW * (whole.x[1] - whole.x[0]) ? { parameter, x } : null;
  }

  picked({ x }) {
    this.page.turn({ [/** @type {DiagramScene} */ (this.panel.shown).parameter]: Number(x.toPrecision(6)) });
  }

  /** @returns {Promise<DiagramScene>} */
  async sceneOf(job) {
    const { oscillator, kept } = job.request;
    const { parameter, x } = this.wantedOf(job);
    const [rows, named] = await Promise.all(["velocity", "impact_period"].map((name) => get(`${job.links.result}.json?table=${name}`)));
    const motions = byMotion(rows, named);
    const points = [...motions].flatMap(([name, rows]) => rows.map((row) => ({ x: row[parameter], y: row.velocity, name })));
    const most = points.reduce((highest, { y }) => Math.max(highest, y), 1);
    const symbol = parameterInWords(parameter);
    const scene = {
      id: job.id, job: job.id, oscillator, parameter, kept, motions, points, whole: { x, y: [0, 1.05 * most] },
      title: `${this.title({ parameter })}. ${oscillatorInWords(oscillator, parameter)}`, file: `bifurcation-${job.id.slice(0, 8)}`,
      xLabel: symbol, yLabel: "velocity v of departure",
      words: (point, { x: [x0, x1], y: [y0, y1] }) =>
        `${symbol} = ${reading(point.x, x1 - x0)}   v = ${reading(point.y, y1 - y0)}   ${inWords(point.name, kept)}`,
      draw: (chart) => this.#draw(scene, chart),
      table: () => [[parameter, "velocity", "motion"], ...points.map(({ x: value, y, name }) => [value, y, name])],
      key: (view) => this.#painted(scene)
        .filter(({ rows }) => rows.some((row) => holds(view, { x: row[parameter], y: row.velocity })))
        .map(({ name, colour, texture }) => ({ sign: swatch(colour, false, texture), name: inWords(name, kept) })),
    };
    return scene;
  }

  /** Its motions with their colours. What there is less of comes last, and lies on top. @param {DiagramScene} scene */
  #painted({ motions }) {
    const painted = [...motions].map(([name, rows]) => ({ name, rows, ...this.page.paint(name === NO_PERIOD ? "chaotic" : name) }));
    return painted.sort((one, other) => other.rows.length - one.rows.length);
  }

  /** @param {DiagramScene} scene @param {import("../charts/chart.js").Chart} chart */
  #draw(scene, chart) {
    const [from, to] = chart.range;
    for (const { name, rows, colour, texture } of this.#painted(scene)) {
      const seen = rows.filter((row) => row[scene.parameter] >= from && row[scene.parameter] <= to);
      const d = seen.map((row) => markAt(chart.x(row[scene.parameter]), chart.y(row.velocity), texture)).join("");
      chart.add("path", { class: texture ? "points marks" : "points", d, stroke: colour, "data-motion": name });
    }
    this.#list(scene.key({ x: chart.range, y: chart.reach }));
    this.drawn = chart;
    this.here = chart.add("path", { class: "here" });
    this.value = chart.add("text", {});
    this.#moveLine();
  }

  /** Name the colours under the chart, those that are seen at most values first. */
  #list(key) {
    const lines = key.slice(0, LISTED).map(({ sign, name }) => {
      const line = Object.assign(document.createElement("span"), { className: "key" });
      line.append(sign, name);
      return line;
    });
    const more = key.length > LISTED ? [`and ${key.length - LISTED} more`] : [];
    by("diagram-motions").replaceChildren(...lines, ...more);
  }

  /** Another picture is seen: offer what its oscillator has, and move the line to its value. */
  follow() {
    this.#parameters();
    if (this.panel.shown && this.drawn) this.#moveLine();
  }

  #moveLine() {
    const { drawn: chart, here, value: text } = this;
    const oscillator = this.page.oscillator();
    const value = oscillator && valueIn(oscillator, this.panel.shown.parameter);
    const [[from, to], [bottom, top]] = [chart.range, chart.reach];
    const inside = typeof value === "number" && value >= from && value <= to;
    for (const mark of [here, text]) mark.setAttribute("visibility", inside ? "visible" : "hidden");
    if (!inside) return;
    const x = chart.x(value);
    here.setAttribute("d", `M${x} ${chart.y(bottom)}V${chart.y(top)}`);
    text.setAttribute("x", String(x + 4));
    text.setAttribute("y", String(chart.y(top) + 12));
    text.textContent = reading(value, to - from);
  }

  /** Offer a diagram over each parameter of the oscillator that is seen. */
  #parameters() {
    const oscillator = this.page.oscillator();
    const parameters = oscillator ? parametersOf(oscillator) : [];
    if (String(parameters) === this.offered) return;
    this.offered = String(parameters);
    by("diagrams").replaceChildren(...parameters.map((parameter) => {
      const symbol = parameterInWords(parameter);
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: `Over ${symbol}` });
      button.title = `Bifurcation diagram over ${symbol}: which motions there are at each value`;
      button.dataset.diagram = parameter;
      button.addEventListener("click", () => this.panel.ask({ parameter, x: around(parameter, valueIn(this.page.oscillator(), parameter)) }));
      return button;
    }));
  }
}
