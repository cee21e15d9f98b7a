/** The Python that computes what is seen. */

import { additions } from "../state/additions.js";

function literal(value) {
  if (Array.isArray(value)) return `[${value.map(literal).join(", ")}]`;
  if (typeof value === "boolean") return value ? "True" : "False";
  return JSON.stringify(value);
}

function pair(one, other) {
  return `(${literal(one)}, ${literal(other)})`;
}

/**
 * Python for the request of a basin or a sweep.
 * @param {BasinRequest} request
 */
export function pythonOf(request) {
  const { oscillator, grid, iterations, vary } = request;
  const { model: _, harmonics, ...parameters } = oscillator;
  const swept = Object.fromEntries((vary ?? []).map(({ parameter, values, start, stop, count }) =>
    [parameter, values ? literal(values) : `(${start}, ${stop}, ${count})`]));
  const fields = Object.entries({ ...parameters, ...swept }).map(([name, value]) => `${name}=${swept[name] ?? literal(value)}`);
  if (harmonics?.length) fields.push(`harmonics=[${harmonics.map(({ order, amplitude, phase = 0 }) => `(${order}, ${amplitude}, ${phase})`).join(", ")}]`);
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
