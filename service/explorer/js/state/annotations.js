/** Annotations of the plane: pinned points with labels, and lines, which say the distance between their ends or a label. */

/** @typedef {{t: number, v: number, label: string}} Note */
/** @typedef {{t0: number, v0: number, t1: number, v1: number, label: string|null}} Measure null for the distance */
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

/**
 * A line in an address, as "0.3,4.1,0.5,4.4" or with a label after a comma, which may be empty; null if it is none.
 * @param {string} text
 * @returns {Measure|null}
 */
function measureIn(text) {
  const parts = text.split(",");
  const numbers = parts.slice(0, 4).map((part) => (part === "" ? NaN : Number(part)));
  if (numbers.length !== 4 || !numbers.every(Number.isFinite)) return null;
  const [t0, v0, t1, v1] = numbers;
  return { t0, v0, t1, v1, label: parts.length > 4 ? parts.slice(4).join(",").slice(0, MOST_LETTERS) : null };
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
    ...measures.map(({ label, t0, v0, t1, v1 }) => {
      return /** @type {[string, string]} */ (["measure", [...[t0, v0, t1, v1].map(short), ...(label === null ? [] : [label])].join(",")]);
    }),
  ];
}

/** With one more; as it was if there are as many as an address may have. @template T @param {T[]} list @param {T} one @returns {T[]} */
export function withOne(list, one) {
  return list.length < MOST ? [...list, one] : list;
}

/** What a line says: its label, or how far its ends are apart. @param {Measure} measure */
export function measureInWords({ t0, v0, t1, v1, label }) {
  if (label !== null) return label;
  const told = (value) => String(Number(value.toPrecision(3))).replace("-", "−");
  return `Δt = ${told(t1 - t0)}, Δv = ${told(v1 - v0)}`;
}
