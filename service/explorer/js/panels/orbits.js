/** Periodic orbits of the oscillator that is seen, those that attract and saddles: a chart whose marks can be followed. */

import { element } from "../charts/chart.js";
import { reading } from "../charts/ticks.js";
import { oscillatorInWords } from "../look/caption.js";
import { sameOscillator } from "../look/screen.js";
import { get } from "../net/api.js";
import { by } from "../page/by.js";
import { ChartPanel } from "./chart_panel.js";

const LONGEST = 4;
const RADIUS = 5;
// Room that a name needs, in pixels.
const [WIDE, HIGH] = [62, 13];

/** An orbit in words. */
export function orbitInWords({ name, attracts, multipliers }) {
  const largest = Math.max(...multipliers.map(([real, imaginary]) => Math.hypot(real, imaginary)));
  const turn = `each turn leaves ${largest.toPrecision(3)} of a disturbance`;
  return attracts ? `${name} attracts: ${turn}` : `${name} is a saddle: each turn makes a disturbance ${largest.toPrecision(3)} times as large`;
}

/** Sign of a kind of orbits, for a key. */
function sign(attracts) {
  const made = element("svg", { viewBox: "0 0 16 16" });
  made.append(element("circle", { cx: 8, cy: 8, r: 5, fill: attracts ? "#808080" : "none", stroke: "#808080", "stroke-width": 2 }));
  return made;
}

export class Orbits {
  name = "orbits";
  kind = "orbits";
  path = "/v1/orbits";
  offer = "Search for these orbits";
  words = { label: "Periodic orbits", act: "Follow this orbit", does: "follows the marked orbit" };
  note = "A filled dot is a departure of an orbit that attracts, a ring one of a saddle. Click one to see the tooth move.";

  /**
   * @param {import("./chart_panel.js").Page & {
   *   colour: (name: string) => string|undefined, pick: (departure: Departure) => void
   * }} page `colour`: of a motion on the basin; `pick`: follow the motion from a departure
   */
  constructor(page) {
    this.page = page;
    this.panel = new ChartPanel(this, page);
    const button = Object.assign(document.createElement("button"), { type: "button", id: "find-orbits", textContent: "Periodic orbits" });
    button.title = `Orbits of up to ${LONGEST} contacts a turn, those that attract and saddles`;
    button.addEventListener("click", () => this.panel.ask({}));
    by("explain").append(button);
  }

  title() {
    return "Periodic orbits";
  }

  body(oscillator) {
    return { oscillator, longest: LONGEST };
  }

  wantedOf() {
    return { x: null, y: null };
  }

  answers() {
    return true;
  }

  seenOf({ whole }, { x, y }) {
    return String([x, y]) === String([whole.x, whole.y]) ? { x: null, y: null } : { x, y };
  }

  isOf({ oscillator }, seen) {
    return sameOscillator(oscillator, seen);
  }

  /** Fewer of them are no more exact. */
  finer() {
    return null;
  }

  picked(place, point) {
    if (point) this.page.pick({ t: point.x, v: point.y });
  }

  follow() {}

  async sceneOf(job) {
    const { orbits } = await get(job.links.result);
    const { oscillator } = job.request;
    const points = orbits.flatMap((orbit) => orbit.departures.map(({ time, velocity }) => ({ x: time, y: velocity, orbit })));
    const speeds = points.map(({ y }) => y);
    const [least, most] = [Math.min(...speeds), Math.max(...speeds)];
    const room = Math.max(0.1 * (most - least), 0.05);
    return {
      id: job.id, job: job.id, oscillator, points, whole: { x: [0, 1], y: points.length ? [least - room, most + room] : [0, 7] },
      title: `${points.length ? "Periodic orbits" : "There are no periodic orbits"}. ${oscillatorInWords(oscillator)}`, file: `orbits-${job.id.slice(0, 8)}`,
      xLabel: "time t of departure (forcing periods)", yLabel: "velocity v of departure",
      words: ({ x, y, orbit }, view) => `t = ${reading(x, view.x[1] - view.x[0])}   v = ${reading(y, view.y[1] - view.y[0])}   ${orbitInWords(orbit)}`,
      draw: (chart) => this.#draw(orbits, chart),
      table: () => [["orbit", "attracts", "time", "velocity"], ...points.map(({ x, y, orbit }) => [orbit.name, orbit.attracts, x, y])],
      key: () => [{ sign: sign(true), name: "attracts" }, { sign: sign(false), name: "saddle" }],
    };
  }

  #draw(orbits, chart) {
    // Those that attract come last, over saddles that lie next to them.
    for (const orbit of orbits.toSorted((a, b) => Number(a.attracts) - Number(b.attracts))) this.#mark(chart, orbit);
    this.#name(orbits, chart);
  }

  /** Names beside the orbits, those that attract first, where there is room for them. */
  #name(orbits, chart) {
    const named = [];
    for (const { name, departures } of orbits.toSorted((a, b) => Number(b.attracts) - Number(a.attracts))) {
      const [x, y] = [chart.x(departures[0].time), chart.y(departures[0].velocity)];
      if (named.some((each) => Math.abs(each.x - x) < WIDE && Math.abs(each.y - y) < HIGH)) continue;
      named.push({ x, y });
      chart.add("text", { x: x + 8, y: y + 4 }, name);
    }
  }

  #mark(chart, orbit) {
    const colour = (orbit.attracts && this.page.colour(orbit.name)) || "currentColor";
    for (const { time, velocity } of orbit.departures) {
      const fill = orbit.attracts ? colour : "transparent";
      chart.add("circle", { class: "orbit", cx: chart.x(time), cy: chart.y(velocity), r: RADIUS, fill, stroke: orbit.attracts ? "none" : colour });
    }
  }
}
