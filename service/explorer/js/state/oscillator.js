/** The numbers of an oscillator: their names in words, which model has them, and its harmonics as text. */

export const NUMBERS = ["damping", "eccentricity", "half_backlash", "stiffness", "restitution", "contact_damping"];
const WORDS = { damping: "damping δ", eccentricity: "eccentricity ε", half_backlash: "half backlash β", stiffness: "stiffness κ", restitution: "restitution r", contact_damping: "contact damping ζ" };
const OF_HARMONICS = { amplitude: ["amplitude", "ε"], phase: ["phase", "φ"] };
/** Numbers that only one model has. */
export const ONLY_IN = { stiffness: "piecewise_linear", contact_damping: "piecewise_linear", restitution: "impacting" };
/** Values that are not written into requests. */
export const USUAL = { restitution: 1, contact_damping: 0 };

function below(order) {
  return [...String(order)].map((digit) => "₀₁₂₃₄₅₆₇₈₉"[Number(digit)]).join("");
}

/** A parameter in words, with its symbol: "damping δ", "phase φ₂". */
export function parameterInWords(parameter) {
  if (WORDS[parameter]) return WORDS[parameter];
  const [part, order] = parameter.split("_");
  const [word, symbol] = OF_HARMONICS[part] ?? [part, ""];
  return `${word} ${symbol}${below(order)}`;
}

/**
 * Harmonics written as "2: 0.01, 0.25; 3: 0.004": order, amplitude and phase. The text itself if it cannot be read: the
 * service then says so.
 * @param {string} text
 * @returns {Harmonic[]|string}
 */
export function harmonicsOf(text) {
  const parts = text.split(";").map((part) => part.trim()).filter(Boolean);
  const harmonics = parts.map((part) => {
    const [order, rest = ""] = part.split(":");
    const numbers = rest.split(",").map((number) => (number.trim() === "" ? NaN : Number(number)));
    return [Number(order), ...numbers];
  });
  const readable = harmonics.every((numbers) => (numbers.length === 2 || numbers.length === 3) && numbers.every(Number.isFinite));
  return readable ? harmonics.map(([order, amplitude, phase = 0]) => ({ order, amplitude, phase })) : text;
}

/** @param {Harmonic[]|string|undefined} harmonics */
export function harmonicsText(harmonics) {
  if (typeof harmonics === "string") return harmonics;
  return (harmonics ?? []).map(({ order, amplitude, phase = 0 }) => `${order}: ${amplitude}${phase ? `, ${phase}` : ""}`).join("; ");
}

/** Names under which numbers of harmonics can be swept. */
export function harmonicParameters(harmonics) {
  return Array.isArray(harmonics) ? harmonics.flatMap(({ order }) => [`amplitude_${order}`, `phase_${order}`]) : [];
}

/** The value that an oscillator has of a parameter. */
export function valueIn(oscillator, parameter) {
  if (NUMBERS.includes(parameter)) return oscillator[parameter] ?? USUAL[parameter];
  const [part, order] = parameter.split("_");
  return oscillator.harmonics?.find((harmonic) => harmonic.order === Number(order))?.[part];
}

/** An oscillator with other values of some parameters. */
export function withValues(oscillator, values) {
  const own = Object.fromEntries(Object.entries(values).filter(([name]) => NUMBERS.includes(name)));
  const harmonics = oscillator.harmonics?.map((harmonic) => ({
    ...harmonic,
    amplitude: values[`amplitude_${harmonic.order}`] ?? harmonic.amplitude,
    phase: values[`phase_${harmonic.order}`] ?? harmonic.phase,
  }));
  return { ...oscillator, ...own, ...(harmonics ? { harmonics } : {}) };
}
