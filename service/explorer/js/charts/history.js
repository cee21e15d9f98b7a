/** Time histories of one or two motions, under the basin. */

import { Chart } from "./chart.js";

const MOST_MARKS = 400;
/** Height of a line of text. */
const LINE = 12;
const NAMES = { first: "A", second: "B" };

function draw(place, backlashOf, motions) {
  const widths = [...motions.values()].map(backlashOf);
  const backlash = Math.max(...widths);
  const all = [...motions.values()].flatMap(({ shown }) => [shown.displacement]);
  const least = Math.min(-backlash, ...all.map((values) => values.reduce((a, b) => Math.min(a, b))));
  const most = Math.max(backlash, ...all.map((values) => values.reduce((a, b) => Math.max(a, b))));
  const ends = [...motions.values()].map(({ shown }) => [shown.time[0], shown.time.at(-1)]);
  const x = [Math.min(...ends.map(([from]) => from)), Math.max(...ends.map(([, to]) => to))];
  const room = 0.08 * (most - least);
  const label = `Displacement over time of ${motions.size === 1 ? "one motion" : "two motions"} between the backlash boundaries`;
  const chart = new Chart(place, {
    height: 140, x, y: [least - room, most + room], xLabel: "time t (forcing periods)", yLabel: "displacement Φ", label,
  });
  const named = [];
  for (const [wall, name] of [...new Set(widths)].flatMap((width) => [[width, "+β"], [-width, "−β"]])) {
    const y = chart.y(wall);
    chart.add("path", { class: "wall", d: `M${chart.x(x[0])} ${y}H${chart.x(x[1])}` });
    // One name for two walls that are close: two would be printed over each other.
    if (named.every((other) => Math.abs(other - y) >= LINE)) chart.add("text", { x: chart.x(x[1]) + 2, y: y + 4 }, name);
    named.push(y);
  }
  for (const [name, motion] of motions) {
    const { shown } = motion;
    chart.line(shown.time, shown.displacement, { class: name });
    for (const { time, wall, direction } of shown.contacts.slice(0, MOST_MARKS)) {
      if (direction !== "out") chart.add("circle", { class: name, cx: chart.x(time), cy: chart.y(wall * backlashOf(motion)), r: 2 });
    }
  }
  return chart;
}

function cursorOn(chart, seek) {
  const line = chart.add("path", { class: "cursor", visibility: "hidden" });
  const [top, bottom] = [chart.y(chart.reach[1]), chart.y(chart.reach[0])];
  chart.svg.addEventListener("click", (event) => seek(chart.valueAt(event)));
  return (at) => {
    line.setAttribute("visibility", at === null ? "hidden" : "visible");
    if (at !== null) line.setAttribute("d", `M${chart.x(at).toFixed(1)} ${top}V${bottom}`);
  };
}

/** @param {string} name @param {Motion} motion */
function sentence(name, { start, ends, kept }) {
  const line = document.createElement("p");
  line.className = "ends";
  const mark = document.createElement("b");
  mark.className = name;
  mark.textContent = NAMES[name];
  const cell = document.createElement("span");
  cell.dataset.cell = name;
  line.append(mark, ` The motion ${kept ? "of the kept basin " : ""}from t = ${start.t}, v = ${start.v} ${ends}.`, cell);
  return line;
}

/**
 * Show motions. Returns a function that moves a cursor to a time, and calls `seek` with the time of a click.
 * @param {HTMLElement} section
 * @param {(motion: Motion) => number} backlashOf half of the backlash of a motion's machine
 * @param {Map<string, Motion>} motions
 * @param {(at: number) => void} seek
 * @returns {(at: number|null) => void}
 */
export function showHistories(section, backlashOf, motions, seek) {
  section.classList.toggle("empty", motions.size === 0);
  const place = section.querySelector("#histories");
  place.replaceChildren();
  if (!motions.size) return () => {};
  const chart = document.createElement("div");
  chart.className = "chart";
  place.append(...[...motions].map(([name, motion]) => sentence(name, motion)), chart);
  let move = cursorOn(draw(chart, backlashOf, motions), seek);
  let [wide, now] = [chart.clientWidth, null];
  // A drawer that opens or a phone that turns gives it another width, and its text would change in size.
  new ResizeObserver(() => {
    if ([0, wide].includes(chart.clientWidth)) return;
    wide = chart.clientWidth;
    move = cursorOn(draw(chart, backlashOf, motions), seek);
    move(now);
  }).observe(chart);
  return (at) => move((now = at));
}
