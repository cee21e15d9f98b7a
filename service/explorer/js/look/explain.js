/** Motions in a sentence, for readers who do not know the symbols. */

import { percent } from "../charts/ticks.js";
import { inUnits } from "../state/machine.js";

function times(count, what) {
  return `${count === 0 ? "no" : count} ${what}${count === 1 ? "" : "s"}`;
}

const KINDS = {
  permanent_contact: "The teeth stay in contact: ever lower bounces, then no rattle at all.",
  chaotic: "Chaos: it rattles for ever and never repeats.",
  chaotic_transient: "A chaotic transient: it rattles without a pattern for long, and settles in the end.",
  undecided: "Where this ends could not be decided.",
};

/** Name of what has not settled in a first picture. */
export const UNSETTLED = "not settled yet";

/** What a solution is, in a sentence. */
export function solutionInWords({ kind, name }) {
  if (name === UNSETTLED) return "It has not settled within some hundred impacts. A finer picture says where it ends.";
  const parts = /^P\((\d+),(\d+),(\d+)\)/.exec(name);
  if (!parts) return KINDS[kind] ?? "";
  const [periods, upper, lower] = parts.slice(1).map(Number);
  const every = periods === 1 ? "every forcing period" : `every ${periods} forcing periods`;
  const rests = name.endsWith("*") ? " In every turn it comes to rest on a wall." : "";
  return `${name} repeats ${every}, with ${times(upper, "contact")} at +β and ${times(lower, "contact")} at −β.${rests}`;
}

const CENTRES = {
  permanent_contact: "ends in permanent contact",
  chaotic: "rattles chaotically without end",
  chaotic_transient: "rattles chaotically for long, and settles in the end",
  undecided: "could not be decided",
};

/**
 * What the cell of a followed motion is coloured by, as a sentence after one of the motion; empty where it is the same.
 * @param {Solution} solution that the picture has for the cell
 * @param {MotionEnd} end of the motion
 */
export function cellInWords({ kind, name }, end) {
  if (kind === end.kind && (kind === "permanent_contact" || name === end.name)) return "";
  const does = name === UNSETTLED ? "has not settled in this first look" : CENTRES[kind] ?? `ends in ${name}`;
  return ` This cell's centre ${does}.`;
}

/** What the cell under the pointer is coloured by: the motion from its centre, which need not be that from the pointer. */
export function underPointer(solution) {
  const words = solutionInWords(solution);
  return words && `This cell's centre: ${words}`;
}

/** What a saddle under the pointer is, and the cell that it lies on. @param {string} saddle @param {Solution|undefined} solution */
export function saddleInWords(saddle, solution) {
  const cell = solution ? ` ${underPointer(solution)}` : "";
  return `${saddle[0].toUpperCase()}${saddle.slice(1)}: a motion that repeats, but that motions beside it leave.${cell}`;
}

/** Hsu's numbers of a cell, as far as it has them. @param {{step?: number, group?: number, period?: number}} known */
export function numbersInWords({ step, group, period }) {
  const taken = `step ${step}`;
  if (group > 0) return `${taken}, group ${group}, period ${period}`;
  return group === 0 ? `${taken}, then out of all cells` : `${taken}, in no cycle of cells`;
}

function told(number) {
  return String(Number(number.toPrecision(3)));
}

/**
 * How loud a motion is, or a basin on average, in words; empty where it is not known.
 * @param {Loudness} heard
 * @param {Scales|null} [scales] of a machine in its own units
 */
export function loudnessInWords({ impacts_per_period, largest_impact_speed, impact_power, time_in_contact }, scales = null) {
  if (impacts_per_period === null) return "";
  if (impacts_per_period === 0) return "no impacts";
  const contact = time_in_contact ? `, teeth touch ${percent(time_in_contact)} of the time` : "";
  if (scales) {
    const [rate, speed, power] = [impacts_per_period / scales.time, largest_impact_speed * scales.speed, impact_power * scales.power];
    return `${told(rate)} impacts a second, the fastest at ${inUnits(speed, "m/s")}, impact power ${inUnits(power, "W")}${contact}`;
  }
  const rate = told(impacts_per_period);
  return `${rate} impact${rate === "1" ? "" : "s"} a forcing period, the fastest at ${told(largest_impact_speed)}, impact power ${told(impact_power)}${contact}`;
}

/**
 * What is to be heard over the window of a basin, in words.
 * @param {Expected} expected
 * @param {Scales|null} [scales]
 */
export function expectedInWords(expected, scales = null) {
  const undecided = expected.undecided_share > 0 ? `; ${percent(expected.undecided_share)} undecided, counted as silent` : "";
  return `On average over the window: ${loudnessInWords(expected, scales)}${undecided}.`;
}

/**
 * What a mask says of a cell, in a sentence.
 * @param {Clear} clear
 * @param {Solution} solution
 * @param {Mask} mask
 */
export function maskInWords({ parts, reason }, { kind, name }, { parts: all, words, ends, reasons }) {
  if (parts === all) return words.whole.replace("{ends}", ends[kind] ?? `ends in ${name}`);
  if (reason === null) return words.untried;
  const partly = parts > 0 ? words.partly.replace("{parts}", String(parts)) : words.none;
  return partly.replace("{reason}", reasons[reason]);
}

/**
 * An uncertainty exponent in words.
 * @param {{exponent: number|null, error: number|null}} fit
 */
export function uncertaintyInWords({ exponent, error }) {
  if (exponent === null) return "There are hardly any borders between basins in this window.";
  const fewer = Number((10 ** exponent).toPrecision(2));
  return `Final-state uncertainty exponent ${exponent.toFixed(3)} ± ${error.toFixed(3)}, of the whole basin that is computed, ` +
    `at the size of its cells: with ten times better knowledge of the departure, ${fewer} times fewer are uncertain. 1 is that of smooth borders.`;
}

const COLOURS = {
  solution: "the motion it ends in", loudness: "how loud the motion is that it ends in", step: "how soon its cell comes to a cycle of cells",
  group: "the cycle of cells that its cell comes to", period: "how long the cycle of cells is that its cell comes to",
};

/** What the plane shows, where nothing is pointed at. @param {string} layer */
export function planeInWords(layer) {
  return `Each point is a departure: a tooth leaves +β at phase t with speed v. Its colour is ${COLOURS[layer]}. Click one to see the tooth move.`;
}

/** What the marks on the plane are. */
export const MARKS = {
  plane: "Each point is a departure: a tooth leaves +β at phase t with speed v. Its colour is the motion it ends in.",
  attractors: "A cross is a departure of a motion that repeats; dots are departures of chaos.",
  grazing: "On this curve a departure just touches −β. Faster ones strike it.",
  preimages: "Departures that meet the grazing curve after one impact or more.",
  manifolds: "Stable manifolds of saddles: the borders between basins.",
  saddles: "Saddles: motions that repeat, but that no motion ends in.",
  group: "A group is a cycle of cells that the map runs through.",
};
