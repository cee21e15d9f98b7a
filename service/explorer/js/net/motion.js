/** One motion from a departure: its time history, its attractor, and the number of impacts until then. */

import { post } from "./api.js";

export const SHOWN_PERIODS = 15;
const SAMPLES = 120;
const BRIEF_PERIODS = 10;
const LONG_PERIODS = 300;
// A motion is on an orbit once all its departures are this close to the orbit's points.
const CLOSE_TIME = 1e-3;
const CLOSE_SPEED = 5e-3;
const SURE = 3;

function ask(oscillator, { t, v }, periods, samples, signal) {
  const body = { oscillator, start: { time: t, velocity: v }, periods, samples_per_period: samples };
  return post("/v1/trajectories", body, { signal });
}

/** Departures from +beta, including the first. */
function departuresOf(start, history) {
  const later = history.contacts.filter(({ wall, direction }) => wall === 1 && direction !== "in");
  return [start, ...later.map(({ time, speed }) => ({ t: time, v: speed }))];
}

function impactsBefore(history, time) {
  return history.contacts.filter((contact) => contact.direction !== "out" && contact.time <= time).length;
}

function isOn(points, { t, v }) {
  return points.some(([time, velocity]) => {
    const away = Math.abs(t - time - Math.round(t - time));
    return away < CLOSE_TIME && Math.abs(v - velocity) < CLOSE_SPEED;
  });
}

/** Time from which a history stays on its solution; null if it has not settled yet. */
function settledAt(solution, start, history) {
  if (solution.kind === "permanent_contact") return history.permanent_from;
  if (solution.kind !== "periodic") return null;
  const departures = departuresOf(start, history);
  let from = departures.length;
  while (from > 0 && isOn(solution.points, departures[from - 1])) from--;
  return departures.length - from >= SURE ? departures[from].t : null;
}

const STAYS = {
  periodic: "stays within 0.001 of it",
  impacting: "then bounces ever lower",
  piecewise_linear: "contact never ends",
};

function ending(model, solution, start, history, periods) {
  if (solution.kind === "chaotic") {
    return `rattles chaotically without end, with ${impactsBefore(history, Infinity)} impacts in ${periods} forcing periods`;
  }
  if (solution.kind === "chaotic_transient") {
    return "rattles chaotically for longer than it was followed; such motions have been seen to settle in the end";
  }
  if (solution.kind === "undecided") return "could not be decided";
  const time = settledAt(solution, start, history);
  if (time === null) return `ends in ${solution.name}, later than the ${periods} forcing periods followed`;
  const impacts = impactsBefore(history, time);
  const after = `after ${impacts} ${impacts === 1 ? "impact" : "impacts"}, ${(time - start.t).toFixed(2)} forcing periods`;
  return `ends in ${solution.name} ${after} (${STAYS[solution.kind === "periodic" ? "periodic" : model]})`;
}

/** Departures of the motion from a place, for some periods. */
export async function briefMotion(oscillator, { t, v }, signal) {
  const start = { t: t - Math.floor(t), v };
  return departuresOf(start, await ask(oscillator, start, BRIEF_PERIODS, 1, signal));
}

/**
 * Follow the motion from the centre of a cell.
 * @param {Oscillator} oscillator as in a request
 * @param {Departure & {solution?: Solution}} start
 * @param {(motion: Motion) => void} begun called with its first periods, where its end takes another request
 * @returns {Promise<Motion>}
 */
export async function followMotion(oscillator, start, begun = () => {}) {
  const shown = await ask(oscillator, start, SHOWN_PERIODS, SAMPLES);
  const motion = { start, shown, departures: departuresOf(start, shown) };
  const { solution } = start;
  if (!solution) return { ...motion, ends: "starts where the basin is not known yet" };
  const waits = ["periodic", "permanent_contact"].includes(solution.kind);
  if (!waits || settledAt(solution, start, shown) !== null) {
    return { ...motion, ends: ending(oscillator.model, solution, start, shown, SHOWN_PERIODS) };
  }
  begun({ ...motion, ends: `is followed for ${LONG_PERIODS} forcing periods` });
  const history = await ask(oscillator, start, LONG_PERIODS, 1);
  return { ...motion, ends: ending(oscillator.model, solution, start, history, LONG_PERIODS) };
}
