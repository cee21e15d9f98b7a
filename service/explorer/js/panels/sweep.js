/** A sweep: a slider for each of its steps; the share of each solution and the impact power over the last one. */

import { get } from "../net/api.js";
import { Chart } from "../charts/chart.js";
import { reading } from "../charts/ticks.js";
import { panelAt, placesOf } from "../state/steps.js";

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

export class Sweep {
  /** @param {HTMLElement} section @param {(panel: number) => void} open */
  constructor(section, open) {
    this.section = section;
    this.open = open;
    /** Basins that were complete when the shares were fetched. */
    this.charted = 0;
    this.result = null;
  }

  hide() {
    this.section.hidden = true;
    this.steps = this.result = null;
  }

  /** Show the sliders of a sweep at one of its basins. */
  show(steps, panel) {
    this.section.hidden = false;
    [this.steps, this.panel, this.drawn, this.result] = [steps, panel, null, null];
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
   * Draw shares over the last parameter, at the current values of the others.
   * @param {{basins: any[]}} result as from `/result`
   * @param {Outline} outline whose colours are used
   * @param {string} palette
   */
  draw(result, outline, palette) {
    // A click is lost if the chart under the pointer is replaced.
    const drawn = [this.panel, palette, result.basins.filter(({ complete }) => complete).length, this.section.clientWidth].join();
    if (drawn === this.drawn) return;
    this.drawn = drawn;
    const { words, values } = this.steps.at(-1);
    const places = placesOf(this.steps, this.panel);
    const row = values.map((_, at) => result.basins[panelAt(this.steps, places.with(-1, at))]);
    const ends = [Math.min(...values), Math.max(...values)];
    /** @type {HTMLElement} */
    const place = this.section.querySelector("#shares");
    const chart = new Chart(place, {
      height: 190, x: ends, y: [0, 1], xLabel: words, yLabel: "share",
      label: `Share of each solution over ${words}; a click opens the nearest basin`,
    });
    for (const solution of outline.solutions) {
      const shares = row.map(({ complete, shares: known }) =>
        complete ? known.find((each) => each.solution === solution.number)?.share ?? null : null);
      if (shares.every((share) => share === null)) continue;
      const stroke = solution.colours[palette];
      chart.line(values, shares, { class: "halo" });
      const line = chart.line(values, shares, { class: "line", stroke });
      shares.forEach((share, i) => {
        if (share !== null) chart.add("circle", { cx: chart.x(values[i]), cy: chart.y(share), r: 3.5, fill: stroke, stroke: "rgb(128 128 128)" });
      });
      line.setAttribute("aria-label", solution.name);
    }
    this.finish(chart, places);
    this.drawLoudness(row, places);
  }

  /** Draw what is to be heard on average in each basin over the last parameter. */
  drawLoudness(row, places) {
    const { words, values } = this.steps.at(-1);
    const powers = row.map(({ expected }) => expected?.impact_power ?? null);
    const most = Math.max(0, ...powers);
    const chart = new Chart(this.section.querySelector("#loudness"), {
      height: 130, x: [Math.min(...values), Math.max(...values)], y: [0, most > 0 ? 1.05 * most : 1],
      xLabel: words, yLabel: "impact power",
      label: `Expected impact power over ${words}; a click opens the nearest basin`,
    });
    chart.line(values, powers, { class: "line", stroke: "currentColor" });
    powers.forEach((power, i) => {
      if (power !== null) chart.add("circle", { cx: chart.x(values[i]), cy: chart.y(power), r: 3, fill: "currentColor" });
    });
    this.finish(chart, places);
  }

  /** Mark the basin that is shown in a chart over the last parameter, and open the one that is clicked. */
  finish(chart, places) {
    const { values } = this.steps.at(-1);
    const [from, to] = chart.range, [bottom, top] = chart.reach.map((y) => chart.y(y));
    const here = chart.x(values[places.at(-1)]);
    chart.add("path", { class: "here", d: `M${here} ${bottom}V${top}` });
    chart.add("text", { x: here + 5, y: top + 12 }, reading(values[places.at(-1)], to - from));
    const target = chart.add("rect", { class: "target", x: chart.x(from) - 8, y: top, width: chart.x(to) - chart.x(from) + 16, height: bottom - top });
    target.addEventListener("click", (event) => {
      const wanted = chart.valueAt(event);
      const distances = values.map((value) => Math.abs(value - wanted));
      this.open(panelAt(this.steps, places.with(-1, distances.indexOf(Math.min(...distances)))));
    });
  }
}
