/** What a sweep steps along: its swept parameters, or the coordinate of its design, which is a list of machines. */

import { parameterInWords } from "./oscillator.js";

/**
 * @typedef {object} Steps
 * @property {string} name
 * @property {string} words the name as it is read, with symbol or units
 * @property {number[]} values
 * @property {Object<string, number[]>} columns values of each number of the oscillator that changes
 */

/** @param {BasinRequest} request @returns {Steps[]} the last one runs fastest; none of one basin */
export function stepsOf({ vary, design }) {
  if (design) {
    const { name, units, values, parameters } = design;
    const words = name.replaceAll("_", " ");
    return [{ name, words: units ? `${words} (${units})` : words, values, columns: parameters }];
  }
  return (vary ?? []).map(({ parameter, values, start }) => {
    const known = values ?? [start];
    return { name: parameter, words: parameterInWords(parameter), values: known, columns: { [parameter]: known } };
  });
}

/** Index of a basin along each of the steps. @param {Steps[]} steps @param {number} panel */
export function placesOf(steps, panel) {
  const places = [];
  for (const { values } of steps.toReversed()) {
    places.unshift(panel % values.length);
    panel = Math.floor(panel / values.length);
  }
  return places;
}

/** Number of a basin from its index along each of the steps. @param {Steps[]} steps @param {number[]} places */
export function panelAt(steps, places) {
  return steps.reduce((panel, { values }, axis) => panel * values.length + places[axis], 0);
}

/** Values of the numbers of the oscillator that change, in one basin. @param {Steps[]} steps @param {number} panel */
export function changesAt(steps, panel) {
  const places = placesOf(steps, panel);
  return Object.fromEntries(steps.flatMap(({ columns }, axis) =>
    Object.entries(columns).map(([parameter, values]) => [parameter, values[places[axis]]])));
}
