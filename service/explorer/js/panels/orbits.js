/** Periodic orbits of the oscillator that is seen, those that attract and saddles: a chart whose marks can be followed. */

import { Chart, element } from "../charts/chart.js";
import { ended } from "../jobs/life.js";
import { get, post } from "../net/api.js";
import { follow } from "../net/follow.js";
import { by } from "../page/by.js";
import { inWords } from "../page/say.js";

const LONGEST = 4;
const RADIUS = 5;
// Room that a name needs, in pixels.
const [WIDE, HIGH] = [62, 13];
const NOTE = "A filled dot is a departure of an orbit that attracts, a ring one of a saddle. Click one to see the tooth move.";

/** An orbit in words. */
export function orbitInWords({ name, attracts, multipliers }) {
  const largest = Math.max(...multipliers.map(([real, imaginary]) => Math.hypot(real, imaginary)));
  const turn = `each turn leaves ${largest.toPrecision(3)} of a disturbance`;
  return attracts ? `${name} attracts: ${turn}` : `${name} is a saddle: each turn makes a disturbance ${largest.toPrecision(3)} times as large`;
}

export class Orbits {
  /**
   * @param {object} page
   * @param {() => Oscillator|null} page.oscillator that is seen
   * @param {(name: string) => string|undefined} page.colour of a motion on the basin
   * @param {(departure: Departure) => void} page.pick follow the motion from a departure
   */
  constructor(page) {
    this.page = page;
    this.section = by("orbits");
    this.note = by("orbits-note");
    this.following = new AbortController();
    this.orbits = null;
    const button = Object.assign(document.createElement("button"), { type: "button", id: "find-orbits", textContent: "Periodic orbits" });
    button.title = `Orbits of up to ${LONGEST} contacts a turn, those that attract and saddles`;
    button.addEventListener("click", () => this.ask());
    by("explain").append(button);
    new ResizeObserver(() => this.orbits && this.draw()).observe(by("orbits-chart"));
  }

  /** Search for the orbits of the oscillator that is seen. */
  async ask() {
    const oscillator = this.page.oscillator();
    if (!oscillator) return;
    this.#begin();
    try {
      await this.show(await post("/v1/orbits", { oscillator, longest: LONGEST }));
    } catch (error) {
      this.note.textContent = inWords(error);
    }
  }

  #begin() {
    this.forget();
    this.section.hidden = false;
    this.note.textContent = "computing…";
  }

  /** Show the orbits of a job once they are found. */
  async show(job) {
    this.#begin();
    const { signal } = (this.following = new AbortController());
    await follow(job, async (now) => {
      if (!ended(now) || signal.aborted) return;
      if (now.state !== "succeeded") {
        this.note.textContent = now.error?.detail ?? "The search was cancelled.";
        return;
      }
      const { orbits } = await get(now.links.result);
      if (signal.aborted) return;
      this.orbits = orbits;
      this.draw();
      this.note.textContent = orbits.length ? NOTE : "There are none.";
      this.section.scrollIntoView({ block: "nearest" });
    }, (error) => (this.note.textContent = inWords(error)), signal);
  }

  /** Another oscillator is seen, which has other orbits. */
  forget() {
    this.following.abort();
    this.orbits = null;
    by("orbits-chart").replaceChildren();
    this.section.hidden = true;
  }

  draw() {
    const speeds = this.orbits.flatMap(({ departures }) => departures.map(({ velocity }) => velocity));
    const [least, most] = [Math.min(...speeds, 7), Math.max(...speeds, 0)];
    const room = Math.max(0.1 * (most - least), 0.05);
    const chart = new Chart(by("orbits-chart"), {
      height: 240, x: [0, 1], y: speeds.length ? [least - room, most + room] : [0, 7], xLabel: "time t of departure (forcing periods)", yLabel: "velocity v of departure",
      label: "Departures of periodic orbits",
    });
    // Those that attract come last, over saddles that lie next to them.
    for (const orbit of this.orbits.toSorted((a, b) => Number(a.attracts) - Number(b.attracts))) this.#mark(chart, orbit);
    this.#name(chart);
  }

  /** Names beside the orbits, those that attract first, where there is room for them. */
  #name(chart) {
    const named = [];
    for (const { name, departures } of this.orbits.toSorted((a, b) => Number(b.attracts) - Number(a.attracts))) {
      const [x, y] = [chart.x(departures[0].time), chart.y(departures[0].velocity)];
      if (named.some((each) => Math.abs(each.x - x) < WIDE && Math.abs(each.y - y) < HIGH)) continue;
      named.push({ x, y });
      chart.add("text", { x: x + 8, y: y + 4, "pointer-events": "none" }, name);
    }
  }

  #mark(chart, orbit) {
    const colour = (orbit.attracts && this.page.colour(orbit.name)) || "currentColor";
    for (const { time, velocity } of orbit.departures) {
      const fill = orbit.attracts ? colour : "transparent";
      const place = { cx: chart.x(time), cy: chart.y(velocity), r: RADIUS };
      const mark = chart.add("circle", { class: "orbit", ...place, fill, stroke: orbit.attracts ? "none" : colour });
      mark.append(element("title", {}, orbitInWords(orbit)));
      mark.addEventListener("click", () => this.page.pick({ t: time, v: velocity }));
    }
  }
}
