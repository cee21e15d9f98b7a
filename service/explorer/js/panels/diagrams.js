/** Bifurcation diagrams of the oscillator that is seen: charts whose cursor is the slider of their parameter. */

import { Chart } from "../charts/chart.js";
import { reading } from "../charts/ticks.js";
import { ended } from "../jobs/life.js";
import { get, post } from "../net/api.js";
import { follow } from "../net/follow.js";
import { by } from "../page/by.js";
import { inWords } from "../page/say.js";
import { byMotion, markAt, NO_PERIOD } from "./branches.js";
import { swatch } from "./swatch.js";
import { harmonicParameters, NUMBERS, ONLY_IN, parameterInWords, valueIn } from "../state/oscillator.js";

const VALUES = 300;
// Periods of up to half as many impacts are seen.
const KEPT = 24;
const REACH = 0.15;
const LISTED = 12;
const DRAG_PIXELS = 6;
/** Where a range ends that begins at 0. */
const LITTLE = 0.02;

/** Parameters that a diagram may go over. @param {Oscillator} oscillator that is seen */
function parametersOf({ model, harmonics }) {
  const own = NUMBERS.filter((name) => (ONLY_IN[name] ?? model) === model);
  return [...own, ...harmonicParameters(harmonics)];
}

/** Range of a parameter around its value: a phase goes once around, and no loss is more than all or less than none. */
function around(parameter, value) {
  if (parameter.startsWith("phase")) return [0, 1];
  if (parameter === "restitution") return [value * (1 - REACH), Math.min(value * (1 + REACH), 1)];
  if (value === 0) return [0, LITTLE];
  return [value * (1 - REACH), value * (1 + REACH)];
}

export class Diagrams {
  /**
   * @param {object} page
   * @param {() => Oscillator|null} page.oscillator that is seen
   * @param {(name: string) => Paint} page.paint of a motion on the basin
   * @param {(parameter: string, value: number) => void} page.turn look at another value
   */
  constructor(page) {
    this.page = page;
    this.section = by("diagram");
    this.note = by("diagram-note");
    this.following = new AbortController();
    /** @type {{parameter: string, range: number[], kept: number, motions: Map<string, any[]>}|null} */
    this.shown = null;
    new ResizeObserver(() => this.shown && this.draw()).observe(by("diagram-chart"));
  }

  /** Offer a diagram over each parameter of the oscillator that is seen. */
  #offer() {
    const oscillator = this.page.oscillator();
    const parameters = oscillator ? parametersOf(oscillator) : [];
    if (String(parameters) === this.offered) return;
    this.offered = String(parameters);
    by("diagrams").replaceChildren(...parameters.map((parameter) => {
      const symbol = parameterInWords(parameter);
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: `Over ${symbol}` });
      button.title = `Bifurcation diagram over ${symbol}: which motions there are at each value`;
      button.dataset.diagram = parameter;
      button.addEventListener("click", () => this.ask(parameter, around(parameter, valueIn(this.page.oscillator(), parameter))));
      return button;
    }));
  }

  /**
   * Compute a diagram over a range of a parameter.
   * @param {string} parameter
   * @param {number[]} range
   */
  async ask(parameter, [start, stop]) {
    const oscillator = this.page.oscillator();
    if (!oscillator) return;
    this.#begin(parameter);
    try {
      const vary = { parameter, start, stop, count: VALUES };
      await this.show(await post("/v1/bifurcations", { oscillator, vary, direction: "both", transient: 600, kept: KEPT }));
    } catch (error) {
      this.note.textContent = inWords(error);
    }
  }

  #begin(parameter) {
    this.following.abort();
    this.section.hidden = false;
    by("diagram-title").textContent = `Bifurcation diagram over ${parameterInWords(parameter)}`;
    this.note.textContent = "computing…";
  }

  /**
   * Show the diagram of a job once it is computed.
   * @param {any} job
   */
  async show(job) {
    const { parameter, values } = job.request.vary;
    this.#begin(parameter);
    const { signal } = (this.following = new AbortController());
    await follow(job, async (now) => {
      if (!ended(now) || signal.aborted) return;
      if (now.state !== "succeeded") {
        this.note.textContent = now.error?.detail ?? "The diagram was cancelled.";
        return;
      }
      const tables = ["velocity", "impact_period"].map((name) => get(`${now.links.result}.json?table=${name}`));
      const [rows, named] = await Promise.all(tables);
      if (signal.aborted) return;
      this.shown = { parameter, range: [values[0], values.at(-1)], kept: job.request.kept, motions: byMotion(rows, named) };
      this.draw();
      this.note.textContent = "Each dot is a departure that lasts. Click to look at a value, drag over a range to compute it anew.";
      this.section.scrollIntoView({ block: "nearest" });
    }, (error) => (this.note.textContent = inWords(error)), signal);
  }

  /** Draw the diagram, with a line at the value that is seen. */
  draw() {
    const { parameter, range, motions } = this.shown;
    const most = Math.max(...[...motions.values()].flat().map(({ velocity }) => velocity), 1);
    const chart = new Chart(by("diagram-chart"), {
      height: 240, x: range, y: [0, 1.05 * most], xLabel: parameterInWords(parameter), yLabel: "velocity v of departure",
      label: `Velocities of departures that last, over ${parameterInWords(parameter)}`,
    });
    const painted = [...motions].map(([name, rows]) => ({ name, rows, ...this.#paintOf(name) }));
    // What there is less of lies on top.
    painted.sort((one, other) => other.rows.length - one.rows.length);
    for (const { name, rows, colour, texture } of painted) {
      const d = rows.map((row) => markAt(chart.x(row[parameter]), chart.y(row.velocity), texture)).join("");
      const line = chart.add("path", { class: texture ? "points marks" : "points", d, stroke: colour, "data-motion": name });
      line.append(Object.assign(document.createElementNS("http://www.w3.org/2000/svg", "title"), { textContent: name }));
    }
    this.#list(painted);
    this.chart = chart;
    this.here = chart.add("path", { class: "here" });
    this.value = chart.add("text", {});
    this.follow();
    this.#listen(chart, range);
  }

  #paintOf(name) {
    return this.page.paint(name === NO_PERIOD ? "chaotic" : name);
  }

  /** Name the colours under the chart, those that are seen at most values first. */
  #list(painted) {
    const none = `no period within ${Math.floor(this.shown.kept / 2)} impacts: chaos, or longer`;
    const lines = painted.slice(0, LISTED).map(({ name, colour, texture }) => {
      const line = document.createElement("span");
      line.className = "key";
      line.append(swatch(colour, false, texture), name === NO_PERIOD ? none : name);
      return line;
    });
    const more = painted.length > LISTED ? [`and ${painted.length - LISTED} more`] : [];
    by("diagram-motions").replaceChildren(...lines, ...more);
  }

  /** Offer what the oscillator that is seen has, and move the line to its value. */
  follow() {
    this.#offer();
    const oscillator = this.page.oscillator();
    const value = this.shown && oscillator && valueIn(oscillator, this.shown.parameter);
    if (!this.chart || typeof value !== "number") return;
    const [from, to] = this.shown.range;
    const inside = value >= from && value <= to;
    for (const mark of [this.here, this.value]) mark.setAttribute("visibility", inside ? "visible" : "hidden");
    const x = this.chart.x(value);
    this.here.setAttribute("d", `M${x} ${this.chart.y(this.chart.reach[0])}V${this.chart.y(this.chart.reach[1])}`);
    this.value.setAttribute("x", String(x + 4));
    this.value.setAttribute("y", String(this.chart.y(this.chart.reach[1]) + 12));
    this.value.textContent = reading(value, to - from);
  }

  /** @param {Chart} chart @param {number[]} range */
  #listen(chart, [from, to]) {
    const [x, y] = [chart.x(from), chart.y(chart.reach[1])];
    const target = chart.add("rect", { class: "target", x, y, width: chart.x(to) - x, height: chart.y(chart.reach[0]) - y });
    let pressed = null;
    target.addEventListener("pointerdown", (event) => {
      pressed = event.clientX;
      target.setPointerCapture(event.pointerId);
    });
    target.addEventListener("pointerup", (event) => {
      if (pressed === null) return;
      const dragged = Math.abs(event.clientX - pressed) > DRAG_PIXELS;
      /** @type {number[]} */
      const ends = [chart.valueAt(event), chart.valueAt({ clientX: pressed })].sort((a, b) => a - b);
      pressed = null;
      if (dragged) this.ask(this.shown.parameter, [Math.max(ends[0], from), Math.min(ends[1], to)]);
      else this.page.turn(this.shown.parameter, Number(ends[0].toPrecision(6)));
    });
  }
}
