/** The points of a diagram by the motions that they belong to. */

/** What the service calls a motion that repeats itself within none of the impacts that are kept. */
export const NO_PERIOD = "no period seen";

/**
 * Rows of the table of departures, by the motion that there is at their value: a branch is not the same motion all along.
 * @param {any[]} rows departures
 * @param {any[]} named each value's motions by name
 */
export function byMotion(rows, named) {
  const names = new Map(named.map(({ visit, seed, name }) => [`${visit} ${seed}`, name]));
  const motions = new Map();
  for (const row of rows) {
    if (row.velocity === null) continue;
    const name = names.get(`${row.visit} ${row.seed}`) || NO_PERIOD;
    if (!motions.has(name)) motions.set(name, []);
    motions.get(name).push(row);
  }
  return motions;
}
