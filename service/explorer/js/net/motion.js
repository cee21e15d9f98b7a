/** One motion from a departure: its time history, and what this very motion does in the end. */

import { post } from "./api.js";

export const SHOWN_PERIODS = 15;
const SAMPLES = 120;
const BRIEF_PERIODS = 10;

function ask(path, oscillator, { t, v }, periods, samples, signal) {
  const body = { oscillator, start: { time: t, velocity: v }, periods, samples_per_period: samples };
  return post(path, body, { signal });
}

/** Departures from +beta, including the first. An impact leaves a part of its speed. */
function departuresOf({ restitution = 1 }, start, history) {
  const later = history.contacts.filter(({ wall, direction }) => wall === 1 && direction !== "in");
  return [start, ...later.map(({ time, speed, direction }) => ({ t: time, v: direction === "impact" ? restitution * speed : speed }))];
}

const STAYS = {
  periodic: "stays within 0.001 of it",
  impacting: "then bounces ever lower",
  piecewise_linear: "contact never ends",
};

function after(impacts, periods) {
  return `after ${impacts} ${impacts === 1 ? "impact" : "impacts"}, ${Number(periods.toFixed(2))} forcing periods`;
}

/**
 * What a motion does in the end, as the end of "The motion from here ...". It says nothing of a cell.
 * @param {string} model
 * @param {MotionEnd} end
 */
export function endInWords(model, { kind, name, periods, impacts, first }) {
  const begins = first ? `nearly repeats ${first.name} for ${Number(first.periods.toFixed(2))} forcing periods, leaves it, and ` : "";
  if (kind === "rattling") return `${begins}still rattles ${after(impacts, periods)}`;
  const stays = STAYS[kind === "periodic" ? "periodic" : model] ?? STAYS.impacting;
  return `${begins}ends in ${kind === "periodic" ? name : "permanent contact"} ${after(impacts, periods)} (${stays})`;
}

/** Departures of the motion from a place, for some periods. */
export async function briefMotion(oscillator, { t, v }, signal) {
  const start = { t: t - Math.floor(t), v };
  return departuresOf(oscillator, start, await ask("/v1/trajectories", oscillator, start, BRIEF_PERIODS, 1, signal));
}

/**
 * Follow the motion from a departure.
 * @param {Oscillator} oscillator as in a request
 * @param {Departure} start
 * @returns {Promise<Motion>}
 */
export async function followMotion(oscillator, start) {
  const shown = await ask("/v1/trajectories?end=true", oscillator, start, SHOWN_PERIODS, SAMPLES);
  const ends = endInWords(oscillator.model ?? "impacting", shown.end);
  return { start, shown, departures: departuresOf(oscillator, start, shown), end: shown.end, ends };
}
