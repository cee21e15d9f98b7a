/** The Python that computes what is seen. */

import { additions } from "../state/additions.js";
import { NUMBERS } from "../state/oscillator.js";

function literal(value) {
  if (Array.isArray(value)) return `[${value.map(literal).join(", ")}]`;
  if (typeof value === "boolean") return value ? "True" : "False";
  return JSON.stringify(value);
}

function pair(one, other) {
  return `(${literal(one)}, ${literal(other)})`;
}

/** A machine in SI, as Python makes it. @param {Object<string, any>} machine */
function machineIn({ transmission_error: orders, ...numbers }) {
  const order = ([order, { amplitude, phase }]) => `${order}: ${phase ? `{"amplitude": ${amplitude}, "phase": ${phase}}` : amplitude}`;
  const fields = [...Object.entries(numbers).map(([name, value]) => `${name}=${literal(value)}`), `transmission_error={${Object.entries(orders).map(order).join(", ")}}`];
  return `machine=rattle.GearPair(${fields.join(", ")})`;
}

/** An oscillator as Python makes it. @param {Oscillator} oscillator */
function oscillatorIn({ model: _, harmonics, permanent_contact: rule, allow_no_quiet_solution: __, ...numbers }) {
  const fields = Object.entries(numbers).map(([name, value]) => `${name}=${value}`);
  if (rule === "one_rotation") fields.push("permanent_after=1.0");
  if (harmonics?.length) fields.push(`harmonics=(${harmonics.map(({ order, amplitude, phase = 0 }) => `(${order}, ${amplitude}, ${phase}),`).join(" ")})`);
  return `rattle.Oscillator(${fields.join(", ")})`;
}

const PARTS = {
  oscillator: oscillatorIn, window: (window) => `(${window.join(", ")})`, departure: (departure) => `(${departure.join(", ")})`, solution: literal,
};

/**
 * Python that leads the `widget` of a notebook from one view to the next.
 * @param {Object<string, any>|null} before null at first
 * @param {Object<string, any>} now
 */
export function linesBetween(before, now) {
  if (before?.rest !== now.rest) return [`widget.address = ${literal(now.address)}`];
  const changed = Object.keys(PARTS).filter((name) => JSON.stringify(before[name]) !== JSON.stringify(now[name]));
  return changed.map((name) => `widget.${name} = ${now[name] === null ? "None" : PARTS[name](now[name])}`);
}

/**
 * Python for the request of a basin or a sweep.
 * @param {BasinRequest} request
 */
export function pythonOf(request) {
  const { oscillator, machine, grid, iterations, vary } = request;
  const { model: _, harmonics, ...parameters } = oscillator;
  // They follow from the machine.
  if (machine) for (const name of NUMBERS) delete parameters[name];
  const swept = Object.fromEntries((vary ?? []).map(({ parameter, values, start, stop, count }) =>
    [parameter, values ? literal(values) : `(${start}, ${stop}, ${count})`]));
  const fields = Object.entries({ ...parameters, ...swept }).map(([name, value]) => `${name}=${swept[name] ?? literal(value)}`);
  if (machine) fields.unshift(machineIn(machine));
  else if (harmonics?.length) fields.push(`harmonics=[${harmonics.map(({ order, amplitude, phase = 0 }) => `(${order}, ${amplitude}, ${phase})`).join(", ")}]`);
  const { time, velocity } = grid;
  const lines = [
    fields.join(", "),
    `cells=${pair(time.cells, velocity.cells)}, time=${pair(time.start, time.stop)}, velocity=${pair(velocity.start, velocity.stop)}`,
    `iterations=${iterations}`,
  ];
  for (const { name } of additions) {
    if (request[name]) lines.push(`${name}=True`);
    for (const [part, value] of Object.entries(request[name] ?? {})) {
      const pairs = Object.entries(value).map(([of, [low, high]]) => `"${of}": (${low}, ${high})`);
      if (typeof value !== "object") lines.push(`${part}=${value}`);
      else if (pairs.length) lines.push(`${part}={${pairs.join(", ")}}`);
    }
  }
  const verb = vary ? "sweep" : "basin";
  return `import rattle\n\n${verb} = rattle.${verb}(\n${lines.map((line) => `    ${line},\n`).join("")})\n${verb}.rattle.plot()`;
}
