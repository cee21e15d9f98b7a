/** What the service refuses, in words of the form: which of its fields are at fault, and what is to be written there. */

const NUMBERS = ["damping", "eccentricity", "half_backlash", "stiffness", "restitution", "contact_damping", "time.start", "time.stop", "velocity.start", "velocity.stop", "vary.start", "vary.stop"];
const COUNTS = ["time.cells", "velocity.cells", "iterations", "vary.count"];
const HARMONIC = { order: "order", amplitude: "amplitude", phase: "phase" };

/**
 * Names of the form's fields that an error of the request is about; none if it is about the whole.
 * @param {(string|number)[]} location such as ["body", "grid", "time", "stop"]
 * @returns {string[]}
 */
export function fieldsOf(location) {
  const [, part, first, second] = location;
  if (part === "oscillator") return first ? [String(first)] : [];
  if (part === "grid" && first) return second ? [`${first}.${second}`] : [`${first}.start`, `${first}.stop`];
  if (part === "vary") return ["start", "stop", "count"].includes(String(second)) ? [`vary.${second}`] : ["vary.start", "vary.stop"];
  return part && part !== "grid" ? [String(part)] : [];
}

function plainly(message) {
  return message.replace(/^Input should be /, "must be ").replace("greater than or equal to", "at least").replace("less than or equal to", "at most")
    .replace("greater than", "above").replace("less than", "below").replace(/ \(RATTLE_\w+\)/, "").replace(/; allow_no_quiet_solution takes it all the same$/, "");
}

/** What one of several harmonics lacks. @param {(string|number)[]} location */
function ofHarmonic(location, message) {
  const [, , , index, part] = location;
  if (typeof index !== "number") return /^Input should be/.test(message) ? "write order: amplitude, phase; as in 2: 0.01, 0.25; 3: 0.004" : message;
  const words = /valid integer/.test(message) ? "must be a whole number" : plainly(message);
  return `the ${HARMONIC[part] ?? "number"} of harmonic ${index + 1} ${words}`;
}

/**
 * What is wrong with a field, without the words of types and of settings.
 * @param {{location: (string|number)[], message: string}} error
 * @param {string} written what the field has
 */
export function faultInWords({ location, message }, written) {
  const [field] = fieldsOf(location);
  if (field === "harmonics") return ofHarmonic(location, message);
  const number = written.trim() === "" ? NaN : Number(written.replace(",", "."));
  if (NUMBERS.includes(field) && !Number.isFinite(number)) return "not a valid number: write one as 0.6";
  if (COUNTS.includes(field) && !Number.isInteger(number)) return "not a whole number: write one as 500";
  return plainly(message);
}
