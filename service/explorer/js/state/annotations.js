/** Annotations of the plane: pinned points with labels, and lines with the distance between their ends. */

/** @typedef {{t: number, v: number, label: string}} Note */
/** @typedef {{t0: number, v0: number, t1: number, v1: number}} Measure */
/** @typedef {{notes: Note[], measures: Measure[]}} Annotated */

/** Most of each, and letters of a label. */
const MOST = 20;
const MOST_LETTERS = 60;

function short(number) {
  return String(Number(number.toPrecision(9)));
}

/** A point in an address, as "0.3,4.1,a label"; null if it is none. @param {string} text @returns {Note|null} */
function noteIn(text) {
  const [t, v, ...label] = text.split(",");
  if (!t || !v || ![Number(t), Number(v)].every(Number.isFinite)) return null;
  return { t: Number(t), v: Number(v), label: label.join(",").slice(0, MOST_LETTERS) };
}

/** A line in an address, as "0.3,4.1,0.5,4.4"; null if it is none. @param {string} text @returns {Measure|null} */
function measureIn(text) {
  const numbers = text.split(",").map((part) => (part === "" ? NaN : Number(part)));
  if (numbers.length !== 4 || !numbers.every(Number.isFinite)) return null;
  const [t0, v0, t1, v1] = numbers;
  return { t0, v0, t1, v1 };
}

/** Annotations in an address. @param {URLSearchParams} query @returns {Annotated} */
export function annotationsIn(query) {
  const read = (name, one) => query.getAll(name).map(one).filter((each) => each !== null).slice(0, MOST);
  return { notes: read("note", noteIn), measures: read("measure", measureIn) };
}

/** Annotations of an address that cannot be read. @param {URLSearchParams} query */
export function unreadAnnotations(query) {
  const unread = (name, one) => query.getAll(name).filter((text) => one(text) === null).map((text) => `${name}=${text}`);
  return [...unread("note", noteIn), ...unread("measure", measureIn)];
}

/** Annotations as addresses have them: names and texts. @param {Annotated} annotated @returns {[string, string][]} */
export function annotationFields({ notes, measures }) {
  return [
    ...notes.map(({ t, v, label }) => /** @type {[string, string]} */ (["note", [short(t), short(v), ...(label ? [label] : [])].join(",")])),
    ...measures.map(({ t0, v0, t1, v1 }) => /** @type {[string, string]} */ (["measure", [t0, v0, t1, v1].map(short).join(",")])),
  ];
}

/** With one more; as it was if there are as many as an address may have. @template T @param {T[]} list @param {T} one @returns {T[]} */
export function withOne(list, one) {
  return list.length < MOST ? [...list, one] : list;
}

/** How far the ends of a line are apart, in words. @param {Measure} measure */
export function distanceInWords({ t0, v0, t1, v1 }) {
  const told = (value) => String(Number(value.toPrecision(3))).replace("-", "−");
  return `Δt = ${told(t1 - t0)}, Δv = ${told(v1 - v0)}`;
}
