/** A machine in its own units: its fields, how an address has them, and what one unit of the model is in SI. */

/**
 * @typedef {object} MachineAnswer
 * @property {Object<string, any>} machine its numbers in SI
 * @property {Oscillator} oscillator
 * @property {number} velocity_stop
 * @property {number} iterations
 * @property {Scales} scales
 * @property {number} gamma
 * @property {number|null} threshold_speed rad/s
 * @property {boolean} can_be_quiet
 */

/** @type {{name: string, label: string, units: string[], optional?: boolean, means: string}[]} */
export const FIELDS = [
  { name: "speed", label: "Speed", units: ["rpm", "rad/s"], means: "of the driven shaft" },
  { name: "inertia", label: "Inertia", units: ["kg m^2", "kg cm^2", "g m^2"], means: "of the driven shaft" },
  { name: "inertia_ratio", label: "Ratio of inertias", units: [], optional: true, means: "driven to driving, both seen from the driven shaft: 1 for equal gears, 0 for a loose gear on a heavy shaft" },
  { name: "drag_torque", label: "Drag torque", units: ["N m", "mN m"], means: "on the driven shaft at this speed" },
  { name: "base_radius", label: "Base radius", units: ["mm", "m"], means: "of the driven gear" },
  { name: "backlash", label: "Backlash", units: ["um", "mm"], means: "all of it, along the line of action" },
  { name: "transmission_error", label: "Transmission error", units: ["um", "mm"], means: "amplitude of its first order, along the line of action" },
  { name: "mesh_stiffness", label: "Mesh stiffness", units: ["N/um", "N/m"], optional: true, means: "without it contacts are impacts" },
  { name: "restitution", label: "Restitution", units: [], optional: true, means: "by which an impact multiplies the speed" },
];

/** The paper's pump; its speed, radius and inertia are guesses. @type {Object<string, string>} */
export const PUMP = {
  speed: "3000 rpm", inertia: "0.01 kg m^2", drag_torque: "94.2 mN m", base_radius: "100 mm", backlash: "120 um", transmission_error: "10 um",
};

const IN_SI = { rpm: Math.PI / 30, "kg cm^2": 1e-4, "g m^2": 1e-3, "mN m": 1e-3, mm: 1e-3, um: 1e-6, "N/um": 1e6 };

/**
 * Texts of the fields for a machine in SI, each in the unit in which its number is shortest; null if it has numbers for
 * which there is no field.
 * @param {Object<string, any>} machine
 * @returns {Object<string, string>|null}
 */
export function writtenOf({ transmission_error: orders, drag_law: law = "constant", turns = 1, ...machine }) {
  const { 1: first, ...others } = orders;
  const known = Object.keys(machine).every((name) => FIELDS.some((field) => field.name === name));
  if (!known || !first || first.phase || Object.keys(others).length || law !== "constant" || turns !== 1) return null;
  const numbers = { ...machine, transmission_error: first.amplitude };
  const text = (value, unit) => `${Number((value / (IN_SI[unit] ?? 1)).toPrecision(12))} ${unit}`.trim();
  const shortest = (texts) => texts.reduce((best, each) => (parts(each).number.length < parts(best).number.length ? each : best));
  const written = FIELDS.filter(({ name }) => numbers[name] !== undefined);
  return Object.fromEntries(written.map(({ name, units }) => [name, shortest((units.length ? units : [""]).map((unit) => text(numbers[name], unit)))]));
}

/** A number and its unit in a text as "3000 rpm". @param {string} text */
export function parts(text) {
  const [number, ...unit] = text.trim().split(" ");
  return { number, unit: unit.join(" ") };
}

/**
 * Request of a machine from its fields; null while one that is needed is empty.
 * @param {Object<string, string>} given texts as "3000 rpm", empty where nothing is written
 */
export function machineOf(given) {
  const written = FIELDS.filter(({ name }) => given[name]);
  if (FIELDS.some(({ name, optional }) => !optional && !given[name])) return null;
  return Object.fromEntries(written.map(({ name, units }) => [name, units.length ? given[name] : Number(given[name])]));
}

/**
 * Tolerances of a report from a text as "backlash = 120 +- 20 um; restitution = 0.8 to 1".
 * @param {string} text
 * @returns {Object<string, string|string[]>}
 */
export function tolerancesIn(text) {
  const each = text.split(";").map((part) => part.trim()).filter(Boolean).map((part) => {
    const [name, ...rest] = part.split("=").map((side) => side.trim());
    if (!name || rest.length !== 1 || !rest[0]) throw new Error(`write “${part}” as backlash = 120 +- 20 um, or restitution = 0.8 to 1`);
    const [low, high] = rest[0].split(" to ").map((side) => side.trim());
    const key = name.replaceAll(" ", "_");
    const { unit } = parts(high ?? "");
    const first = unit && !parts(low).unit ? `${low} ${unit}` : low;
    return [key === "transmission_error" ? `${key}.1.amplitude` : key, high === undefined ? low : [first, high]];
  });
  return Object.fromEntries(each);
}

/** A machine as addresses have it. @param {Object<string, string>} given */
export function machineText(given) {
  return FIELDS.filter(({ name }) => given[name]).map(({ name }) => `${name}:${given[name].replaceAll(" ", "_")}`).join(",");
}

/** Fields of a machine in an address; null if there is none. @param {string|null} text @returns {Object<string, string>|null} */
export function machineIn(text) {
  if (!text) return null;
  const named = text.split(",").map((part) => part.split(":")).filter(([name, value]) => value && FIELDS.some((field) => field.name === name));
  return named.length ? Object.fromEntries(named.map(([name, value]) => [name, value.replaceAll("_", " ")])) : null;
}

const PREFIXES = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"]];

/** The prefix that makes a number 1 to 1000, and what it counts. @param {number} value @returns {[number, string]} */
function prefixOf(value) {
  return /** @type {[number, string]} */ (PREFIXES.find(([size]) => Math.abs(value) >= Number(size)) ?? PREFIXES[PREFIXES.length - 1]);
}

/** A number with the prefix that makes it 1 to 1000, to three digits. @param {number} value @param {string} unit */
export function inUnits(value, unit) {
  if (value === 0) return `0 ${unit}`;
  const [size, prefix] = prefixOf(value);
  return `${Number((value / size).toPrecision(3))} ${prefix}${unit}`;
}

/**
 * How an axis is labelled in SI: by what its numbers are multiplied, and their unit.
 * @param {number} width of what it shows, in units of the model
 * @param {number} scale one of these in SI
 * @param {string} unit
 */
export function axisUnit(width, scale, unit) {
  const [size, prefix] = prefixOf(width * scale);
  return { factor: scale / size, unit: `${prefix}${unit}` };
}

/** What inertia torque over drag torque means, in sentences. @param {MachineAnswer} answer */
export function gammaInWords({ gamma, threshold_speed, can_be_quiet }) {
  const rpm = threshold_speed === null ? null : Math.round((threshold_speed * 30) / Math.PI);
  const reached = rpm === null ? "Without a transmission error it never reaches 1." : `It reaches 1 at ${rpm} rpm.`;
  const beyond = can_be_quiet ? "" : " Here no motion keeps the teeth together, and the machine is never quiet.";
  return `Inertia torque over drag torque Γ = ${Number(gamma.toPrecision(3))}. ${reached}${beyond}`;
}
