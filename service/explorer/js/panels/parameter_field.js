/** What lies on and below a chart of two parameters: curves with their parts, and colours of machines. Pure. */

/** A curve of special points: `parts` are drawn, `places` are its points. */
/** @typedef {{x: number, y: number, curve: Curve}} CurvePlace */
/** @typedef {{kind: string, orbit: string, says: string, places: CurvePlace[], parts: {words: string, dashed: boolean, places: CurvePlace[]}[]}} Curve */

const NONE = "";
const LEVELS = 10;
// From violet through white to orange, and from white to green: apart for all eyes.
const DOWN = [84, 39, 136], UP = [179, 88, 6], QUIET = [27, 107, 58], WHITE = [247, 247, 247];

function between(one, other, part) {
  return `#${one.map((value, i) => Math.round(value + part * (other[i] - value)).toString(16).padStart(2, "0")).join("")}`;
}

/** A number as a sign and three digits. */
function signed(value) {
  return `${value < 0 ? "−" : "+"}${Math.abs(value).toPrecision(3)}`;
}

/** What may lie below: its words, and what it is at a machine. */
export const FIELDS = {
  exponent: {
    words: "largest exponent per period",
    says: ({ exponent }) => (exponent === null ? "No motion with an exponent is met." : `Largest exponent ${signed(exponent)} per period: ${exponent > 0 ? "chaos" : "regular"}.`),
  },
  quiet_share: { words: "quiet share", says: ({ quiet_share: share }) => `${Math.round(100 * share)} % of departures fall quiet.` },
  motion: { words: "motion that rattles", says: ({ motion }) => `What most departures end in that do not fall quiet: ${motion}.` },
};

/**
 * Curves of a summary with their points, from the rows of the table of points: these follow each other. A folding part is
 * dashed, and begins and ends at points of the part beside it.
 * @param {any[]} curves
 * @param {any[]} rows
 * @param {string[]} pair
 * @returns {Curve[]}
 */
export function curvesOf(curves, rows, [first, second]) {
  let begin = 0;
  return curves.map(({ kind, orbit, says, points }) => {
    const own = rows.slice(begin, (begin += points));
    /** @type {Curve} */
    const curve = { kind, orbit, says, places: [], parts: [] };
    curve.places = own.map((row) => ({ x: row[`curve_${first}`], y: row[`curve_${second}`], curve }));
    const folds = own.map(({ curve_response: response }) => response !== null && response < 0);
    for (let from = 0; from < own.length; ) {
      let to = from;
      while (to + 1 < own.length && folds[to + 1] === folds[from]) to++;
      const [before, after] = folds[from] ? [Math.max(from - 1, 0), Math.min(to + 1, own.length - 1)] : [from, to];
      curve.parts.push({ words: `${folds[from] ? "folding " : ""}${kind} of ${orbit}`, dashed: folds[from], places: curve.places.slice(before, after + 1) });
      from = to + 1;
    }
    return curve;
  });
}

/**
 * Colours of machines, empty where there is none, and a key of them.
 * @param {string} field
 * @param {any[]} machines
 * @param {(name: string) => string} paint
 * @returns {{colours: string[], key: {colour: string, name: string}[]}}
 */
export function shadesOf(field, machines, paint) {
  if (field === "motion") {
    const names = [...new Set(machines.map(({ motion }) => motion).filter(Boolean))].sort();
    return { colours: machines.map(({ motion }) => (motion ? paint(motion) : NONE)), key: names.map((name) => ({ colour: paint(name), name })) };
  }
  const level = (part) => Math.round(LEVELS * part) / LEVELS;
  if (field === "quiet_share") {
    const of = (share) => between(WHITE, QUIET, level(share));
    return { colours: machines.map(({ quiet_share: share }) => (share === null ? NONE : of(share))), key: [{ colour: of(0), name: "none fall quiet" }, { colour: of(1), name: "all fall quiet" }] };
  }
  const most = machines.reduce((largest, { exponent }) => Math.max(largest, Math.abs(exponent ?? 0)), 0);
  const of = (exponent) => between(WHITE, exponent < 0 ? DOWN : UP, most ? level(Math.abs(exponent) / most) : 0);
  const key = most ? [{ colour: of(-most), name: `exponent ${signed(-most)}` }, { colour: of(most), name: `exponent ${signed(most)}: chaos` }] : [];
  return { colours: machines.map(({ exponent }) => (exponent === null ? NONE : of(exponent))), key };
}

/**
 * What the machine nearest to a place does, in a sentence; nothing where none was computed.
 * @param {string} field
 * @param {{machines: any[], pair: string[], whole: import("../charts/view.js").ChartView}} scene
 * @param {{x: number, y: number}} at
 */
export function fieldIn(field, { machines, pair, whole }, at) {
  const [wide, high] = [whole.x[1] - whole.x[0], whole.y[1] - whole.y[0]];
  const away = (row) => Math.hypot((row[pair[0]] - at.x) / wide, (row[pair[1]] - at.y) / high);
  const nearest = machines.reduce((best, row) => (best === null || away(row) < away(best) ? row : best), null);
  return nearest?.motion ? FIELDS[field].says(nearest) : "";
}
