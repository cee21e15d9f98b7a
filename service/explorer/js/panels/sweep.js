/** A sweep: a slider for each of its steps; the share of each solution and the impact power over the last one. */

import { Instrument } from "../charts/instrument.js";
import { percent, reading } from "../charts/ticks.js";
import { get } from "../net/api.js";
import { panelAt, placesOf } from "../state/steps.js";
import { swatch } from "./swatch.js";

const ROOM = 0.012;
const WORDS = { act: "Open this basin", does: "opens the basin of the marked point" };

function slider({ words, values }, at, moved) {
  const line = document.createElement("label");
  line.className = "slider";
  const name = Object.assign(document.createElement("span"), { textContent: words });
  const input = Object.assign(document.createElement("input"), { type: "range", min: "0", max: String(values.length - 1), step: "1" });
  input.value = String(at);
  const value = document.createElement("output");
  const tell = () => {
    value.textContent = String(Number(values[input.value].toPrecision(6)));
    input.setAttribute("aria-valuetext", value.textContent);
  };
  tell();
  input.addEventListener("input", () => (tell(), moved(Number(input.value))));
  line.append(name, input, value);
  return line;
}

/** Which of some values is closest to another. */
function closest(values, wanted) {
  const distances = values.map((value) => Math.abs(value - wanted));
  return distances.indexOf(Math.min(...distances));
}

export class Sweep {
  /**
   * @param {HTMLElement} section
   * @param {(panel: number) => void} open
   * @param {() => void} changed what an address holds of its charts has changed
   */
  constructor(section, open, changed) {
    this.section = section;
    this.open = open;
    /** Basins that were complete when the shares were fetched. */
    this.charted = 0;
    this.result = null;
    /** What an address shows of its charts, until they are there. @type {{[chart: string]: SeenChart|null}} */
    this.wanted = {};
    const chart = (id, label) => new Instrument(section.querySelector(id), { label, ...WORDS }, { moved: changed, picked: ({ x }) => this.#openAt(x) });
    this.charts = { shares: chart("#shares", "Share of each motion"), power: chart("#loudness", "Expected impact power") };
  }

  #openAt(value) {
    const places = placesOf(this.steps, this.panel);
    this.open(panelAt(this.steps, places.with(-1, closest(this.steps.at(-1).values, value))));
  }

  /** What an address holds of its charts: what they are zoomed to. */
  get seen() {
    if (this.section.hidden) return { shares: null, power: null };
    const of = (name) => {
      const { scene, zoomed, view } = this.charts[name];
      return scene ? (zoomed ? view : null) : this.wanted[name] ?? null;
    };
    return { shares: of("shares"), power: of("power") };
  }

  /** Show what an address says of its charts. @param {{[chart: string]: SeenChart|null}} seen */
  look(seen) {
    this.wanted = seen;
    for (const [name, chart] of Object.entries(this.charts)) if (chart.scene) chart.look(seen[name]?.x ? seen[name] : null);
  }

  hide() {
    this.section.hidden = true;
    this.steps = this.result = null;
    this.#clear();
  }

  #clear() {
    this.wanted = {};
    for (const chart of Object.values(this.charts)) chart.clear();
  }

  /** Show the sliders of a sweep at one of its basins. */
  show(steps, panel) {
    this.section.hidden = false;
    [this.steps, this.panel, this.result] = [steps, panel, null];
    this.#clear();
    const places = placesOf(steps, panel);
    const sliders = steps.map((each, axis) => slider(each, places[axis], (at) => this.open(panelAt(steps, places.with(axis, at)))));
    this.section.querySelector("#sliders").replaceChildren(...sliders);
  }

  /**
   * Fetch the shares of the basins that are complete, if there are more of them, and draw them.
   * @param {Job} job
   * @param {import("../plane/picture.js").Picture} picture
   * @param {string} palette
   */
  async refresh(job, picture, palette) {
    const done = job.progress.basins_done;
    const { steps } = this;
    if (!this.result || this.charted !== done) {
      const result = await get(job.links.result);
      if (steps !== this.steps) return;
      [this.result, this.charted] = [result, done];
    }
    this.repaint(picture, palette);
  }

  /** Draw the shares that are known in the colours of a palette. */
  repaint(picture, palette) {
    if (this.steps && this.result && picture) this.draw(this.result, picture.outline, palette);
  }

  /** Move to a basin that was opened elsewhere. Sliders keep the focus. */
  moveTo(panel) {
    this.panel = panel;
    const places = placesOf(this.steps, panel);
    this.section.querySelectorAll("input").forEach((input, axis) => {
      if (Number(input.value) === places[axis]) return;
      input.value = String(places[axis]);
      input.dispatchEvent(new Event("input"));
    });
  }

  /**
   * Draw shares and impact power over the last parameter, at the current values of the others.
   * @param {{basins: any[]}} result as from `/result`
   * @param {Outline} outline whose colours are used
   * @param {string} palette
   */
  draw(result, outline, palette) {
    const { values } = this.steps.at(-1);
    const places = placesOf(this.steps, this.panel);
    const row = values.map((_, at) => result.basins[panelAt(this.steps, places.with(-1, at))]);
    this.#show("shares", this.#sharesOf(row, outline, palette));
    this.#show("power", this.#powerOf(row));
  }

  #show(name, scene) {
    const chart = this.charts[name];
    const view = chart.scene ? null : this.wanted[name];
    chart.show(scene, view?.x ? /** @type {any} */ (view) : null);
  }

  /** What both charts have. */
  #scene(name, title, yLabel, points, most) {
    const { words, values } = this.steps.at(-1);
    const [least, last] = [Math.min(...values), Math.max(...values)];
    // Marks of the first and the last basin are seen as a whole.
    const ends = [least - ROOM * (last - least), last + ROOM * (last - least)];
    return {
      id: name, title: `${title} over ${words}`, file: `sweep-${name}`, whole: { x: ends, y: [0, most] }, xLabel: words, yLabel, points,
    };
  }

  #sharesOf(row, outline, palette) {
    const { words, values, name: swept } = this.steps.at(-1);
    const lines = outline.solutions.map((solution) => {
      const shares = row.map(({ complete, shares: known }) =>
        complete ? known.find((each) => each.solution === solution.number)?.share ?? null : null);
      return { name: solution.name, stroke: solution.colours[palette], texture: solution.textures[palette], shares };
    }).filter(({ shares }) => shares.some((share) => share !== null));
    const points = lines.flatMap(({ name, shares }) => shares.flatMap((y, i) => (y === null ? [] : [{ x: values[i], y, name }])));
    return {
      ...this.#scene("shares", "Share of each motion", "share", points, 1),
      words: ({ x, y, name }) => `${words} = ${Number(x.toPrecision(6))}   ${percent(y)}   ${name}`,
      draw: (chart) => {
        for (const { name, stroke, shares } of lines) {
          chart.line(values, shares, { class: "halo" });
          chart.line(values, shares, { class: "line", stroke, "data-motion": name });
          shares.forEach((share, i) => {
            if (share !== null) chart.add("circle", { cx: chart.x(values[i]), cy: chart.y(share), r: 3.5, fill: stroke, stroke: "rgb(128 128 128)" });
          });
        }
        this.#mark(chart);
      },
      table: () => [[swept, "share", "motion"], ...points.map(({ x, y, name }) => [x, y, name])],
      key: () => lines.map(({ name, stroke, texture }) => ({ sign: swatch(stroke, false, texture), name })),
    };
  }

  /** What is to be heard on average in each basin over the last parameter. */
  #powerOf(row) {
    const { words, values, name: swept } = this.steps.at(-1);
    const powers = row.map(({ expected }) => expected?.impact_power ?? null);
    const most = Math.max(0, ...powers);
    const points = powers.flatMap((y, i) => (y === null ? [] : [{ x: values[i], y }]));
    return {
      ...this.#scene("power", "Expected impact power", "impact power", points, most > 0 ? 1.05 * most : 1),
      words: ({ x, y }) => `${words} = ${Number(x.toPrecision(6))}   impact power ${Number(y.toPrecision(3))}`,
      draw: (chart) => {
        chart.line(values, powers, { class: "line", stroke: "currentColor" });
        for (const { x, y } of points) chart.add("circle", { cx: chart.x(x), cy: chart.y(y), r: 3, fill: "currentColor" });
        this.#mark(chart);
      },
      table: () => [[swept, "impact_power"], ...points.map(({ x, y }) => [x, y])],
      key: () => [],
    };
  }

  /** Mark the basin that is shown in a chart over the last parameter. @param {import("../charts/chart.js").Chart} chart */
  #mark(chart) {
    const { values } = this.steps.at(-1);
    const [from, to] = chart.range, [bottom, top] = chart.reach.map((y) => chart.y(y));
    const value = values[placesOf(this.steps, this.panel).at(-1)];
    if (value < from || value > to) return;
    const here = chart.x(value);
    chart.add("path", { class: "here", d: `M${here} ${bottom}V${top}` });
    chart.add("text", { x: here + 5, y: top + 12 }, reading(value, to - from));
  }
}
