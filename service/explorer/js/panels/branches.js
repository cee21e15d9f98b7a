/** The points of a diagram by the motions that they belong to. */

/** What the service calls a motion that repeats itself within none of the impacts that are kept. */
export const NO_PERIOD = "no period seen";

/** What is known of a motion that has no name, because there are very many: how many impacts it has. */
function repeats(period) {
  return period > 0 ? `repeats after ${period} impact${period > 1 ? "s" : ""}` : NO_PERIOD;
}

/** Numbers of a name, for the order in which motions take their colours: contacts first, as in pictures elsewhere. */
function contactsOf(name) {
  const numbers = (name.match(/\d+/g) ?? []).map(Number);
  return numbers.length === 3 ? numbers[1] + numbers[2] : numbers[0] ?? 0;
}

/**
 * Rows of the table of departures, by the motion that there is at their value: a branch is not the same motion all along.
 * They come in the order in which they take their colours.
 * @param {any[]} rows departures
 * @param {any[]} named each value's motions by name
 */
export function byMotion(rows, named) {
  const names = new Map(named.map(({ visit, seed, name, impact_period }) => [`${visit} ${seed}`, name ?? repeats(impact_period)]));
  const motions = new Map();
  for (const row of rows) {
    const name = names.get(`${row.visit} ${row.seed}`);
    if (row.velocity === null || !name) continue;
    if (!motions.has(name)) motions.set(name, []);
    motions.get(name).push(row);
  }
  const before = (one, other) => contactsOf(one[0]) - contactsOf(other[0]) || (one[0] < other[0] ? -1 : 1);
  return new Map([...motions].sort(before));
}

/** Path of a mark: a dot, and where colours come again, strokes up, strokes down and dashes. */
export function markAt(x, y, texture) {
  const place = (dx, dy) => `M${(x + dx).toFixed(1)} ${(y + dy).toFixed(1)}`;
  return [`${place(0, 0)}h.01`, `${place(-1.5, 1.5)}l3 -3`, `${place(-1.5, -1.5)}l3 3`, `${place(-1.5, 0)}h3`][texture];
}
