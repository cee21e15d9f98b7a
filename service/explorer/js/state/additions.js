/** What packages add to basins, as the service describes it: a field of requests, and a mask over the cells, with its words. */

/** @type {Addition[]} */
export const additions = [];

/** Take what the service has, before an address is read. @param {Addition[]} found */
export function knowAdditions(found) {
  additions.splice(0, additions.length, ...found);
}

/** The mask that comes with the cells of a basin; null where none was asked for. @param {Outline} outline @returns {Mask|null} */
export function maskOf(outline) {
  return additions.find(({ outline: field }) => outline[field])?.mask ?? null;
}

/** Names of all masks, which are overlays. */
export function maskNames() {
  return additions.map(({ mask }) => mask.name);
}
