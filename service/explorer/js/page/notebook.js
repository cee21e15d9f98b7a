/** The page in a notebook: Python hears what is seen, with the lines that lead there, and has its own views shown. */

import { frame } from "../net/frame.js";
import { linesBetween } from "../look/python.js";
import { decode, encode } from "../state/address.js";
import { entries } from "../state/entries.js";
import { writtenOf } from "../state/machine.js";
import { axesOf, viewOf } from "../state/window.js";

/**
 * @typedef {object} Told what Python hears
 * @property {string} address of the view, which holds all of it but the job
 * @property {Oscillator|null} oscillator
 * @property {number[]|null} window t0, t1, v0, v1
 * @property {number[]|null} departure t, v of the motion that is followed first
 * @property {string|null} solution name of the motion that is highlighted
 * @property {string|null} job
 * @property {string[]} history lines of Python
 *
 * @typedef {Partial<{address: string, oscillator: Oscillator, window: number[], departure: number[]|null, solution: string|null, compute: boolean}>} Parts
 * what Python says
 */

const lines = [];
let told = null;

/** What is seen, in the parts that Python has, and the rest of it as an address. @param {Partial<import("../state/address.js").Seen>} seen */
export function partsOf(seen) {
  const { request, view, motions, highlight, job } = seen;
  const rest = { ...seen, job: null, view: null, whole: null, motions: (motions ?? []).slice(1), highlight: null, request: request && { ...request, oscillator: {}, grid: axesOf({ t0: 0, t1: 1, v0: 0, v1: 1 }, { time: request.grid.time.cells, velocity: request.grid.velocity.cells }) } };
  return {
    address: encode({ ...seen, job: null }), oscillator: request?.oscillator ?? null, window: request ? Object.values(view ?? viewOf(request.grid)) : null,
    departure: motions?.[0] ?? null, solution: highlight ?? null, job: job ?? null, rest: encode(rest),
  };
}

/**
 * Tell Python what is seen.
 * @param {Partial<import("../state/address.js").Seen>} seen
 * @param {boolean} isNew whether it is another view, and not a correction of the last
 */
export function tell(seen, isNew) {
  if (!frame) return;
  const now = partsOf(seen);
  for (const line of linesBetween(told, now)) {
    const [name] = line.split(" = ");
    if (!isNew && lines.at(-1)?.startsWith(`${name} = `)) lines.pop();
    lines.push(line);
  }
  told = now;
  const { rest: _, ...parts } = now;
  frame.tell({ ...parts, history: [...lines] });
}

/** Note that a job is asked for. */
export function noteCompute() {
  lines.push("widget.compute()");
}

/**
 * Address of a view with some of its parts as Python says.
 * @param {string} address of the view that is seen
 * @param {Parts} parts
 */
export function withParts(address, parts) {
  if (parts.address !== undefined) return parts.address;
  const seen = decode(address);
  const { request } = seen;
  if (request && parts.oscillator) {
    const { vary: _, ...alone } = request;
    Object.assign(seen, { job: null, panel: 0, machine: null, request: { ...alone, oscillator: parts.oscillator } });
  }
  if (request && parts.window) {
    const [t0, t1, v0, v1] = parts.window, view = { t0, t1, v0, v1 };
    const { time, velocity } = request.grid;
    const whole = seen.whole ?? viewOf(request.grid);
    Object.assign(seen, { job: null, whole, view, request: { ...seen.request, grid: axesOf(view, { time: time.cells, velocity: velocity.cells }) } });
  }
  if (parts.departure !== undefined) seen.motions = parts.departure ? [parts.departure, ...seen.motions.slice(1)] : [];
  if (parts.solution !== undefined) seen.highlight = parts.solution;
  return encode(seen);
}

/**
 * Listen to Python.
 * @param {object} page
 * @param {() => Promise<any>} page.show show what the entries say
 * @param {() => void} page.compute ask for the job of what is seen
 */
export function listen({ show, compute }) {
  if (!frame) return;
  const { address, request, job } = frame.opening;
  entries.write(address ?? encode({ request, job, machine: request?.machine && writtenOf(request.machine) }), false);
  // A link to another view would lead the frame to the notebook's own server.
  document.addEventListener("click", (event) => {
    const href = /** @type {HTMLElement} */ (event.target).closest("a")?.getAttribute("href");
    if (!href?.startsWith("?")) return;
    event.preventDefault();
    entries.write(href, true);
    show();
  });
  frame.listen(async (parts) => {
    if (parts.compute) return compute();
    entries.write(withParts(entries.address, parts), true);
    await show();
  });
}
