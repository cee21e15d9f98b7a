/** Charts below the plane as addresses have them: which, and what is seen of them. */

import { NUMBERS } from "./oscillator.js";

const OF_HARMONICS = /^(amplitude|phase)_\d+$/;

function short(number) {
  return String(Number(number.toPrecision(9)));
}

function numbersIn(texts) {
  const numbers = texts.map((text) => (text.trim() ? Number(text) : NaN));
  const rises = numbers.every((value, i) => Number.isFinite(value) && (i % 2 === 0 || value > numbers[i - 1]));
  return rises && numbers.length % 2 === 0 ? numbers : null;
}

/** A view as addresses have it; the whole is 1. @param {{x: number[]|null, y: number[]|null}} view */
export function viewText({ x, y }) {
  return x && y ? [...x, ...y].map(short).join(",") : "1";
}

/** @param {string|null} text @returns {{x: number[]|null, y: number[]|null}|null} null if it is none */
export function viewFrom(text) {
  if (text === "1") return { x: null, y: null };
  const numbers = text ? numbersIn(text.split(",")) : null;
  return numbers?.length === 4 ? { x: numbers.slice(0, 2), y: numbers.slice(2) } : null;
}

/** A diagram: its parameter, the range that is seen, and that of speeds unless all are. @param {SeenChart} seen */
export function diagramText({ parameter, x, y }) {
  return [parameter, ...[...x, ...(y ?? [])].map(short)].join(",");
}

/** @param {string|null} text @returns {{parameter: string, x: number[], y: number[]|null}|null} null if it is none */
export function diagramIn(text) {
  const [parameter, ...ends] = (text ?? "").split(",");
  const numbers = numbersIn(ends);
  if (!(NUMBERS.includes(parameter) || OF_HARMONICS.test(parameter)) || ![2, 4].includes(numbers?.length)) return null;
  return { parameter, x: numbers.slice(0, 2), y: numbers.length === 4 ? numbers.slice(2) : null };
}

/** A chart of two parameters: these, and the ranges that are seen. @param {string|null} text */
export function parametersIn(text) {
  const [first, second, ...ends] = (text ?? "").split(",");
  const numbers = numbersIn(ends);
  const known = [first, second].every((name) => NUMBERS.includes(name) || OF_HARMONICS.test(name)) && first !== second;
  return known && numbers?.length === 4 ? { parameter: `${first},${second}`, x: numbers.slice(0, 2), y: numbers.slice(2) } : null;
}

const FIELDS = { diagram: diagramIn, orbits: viewFrom, parameters: parametersIn, shares: viewFrom, power: viewFrom };
const TEXTS = { diagram: diagramText, orbits: viewText, parameters: diagramText, shares: viewText, power: viewText };

/** Charts in an address, by name; null where it has none. @param {URLSearchParams} query @returns {SeenCharts} */
export function chartsIn(query) {
  const found = Object.entries(FIELDS).map(([name, read]) => {
    const seen = read(query.get(name));
    const job = ["diagram", "orbits", "parameters"].includes(name) ? { job: query.get(`${name}_job`) } : {};
    return [name, seen && { ...seen, ...job }];
  });
  return Object.fromEntries(found);
}

/** Fields of an address with charts. @param {Partial<SeenCharts>} charts @returns {string[][]} */
export function chartFields(charts) {
  return Object.keys(FIELDS).filter((name) => charts[name]).flatMap((name) => {
    const { job } = charts[name];
    return [[name, TEXTS[name](charts[name])], ...(job ? [[`${name}_job`, job]] : [])];
  });
}

/** Fields of charts that cannot be read. @param {URLSearchParams} query */
export function unreadCharts(query) {
  return Object.entries(FIELDS).filter(([name, read]) => query.has(name) && !read(query.get(name))).map(([name]) => `${name}=${query.get(name)}`);
}
