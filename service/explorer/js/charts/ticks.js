/** Numbers for axes and for readers. */

/** Round steps between two ends, roughly `about` of them. */
export function ticks(from, to, about) {
  const rough = (to - from) / about;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough * 0.999);
  const first = Math.ceil(from / step - 1e-9);
  const last = Math.floor(to / step + 1e-9);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return Array.from({ length: last - first + 1 }, (_, i) => {
    const at = (first + i) * step;
    return { at, label: at.toFixed(Math.min(digits, 12)) };
  });
}

const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";
const MOST_DIGITS = 4;

function power10(exponent) {
  return `10⁻${[...String(exponent)].map((digit) => SUPERSCRIPTS[digit]).join("")}`;
}

/**
 * Ticks of an axis. Where labels would need many digits, what they have in common goes to the title:
 * `{ticks, title}`, where the title is "" or as " = 3.4012 + … × 10⁻⁶".
 */
export function axisTicks(from, to, about) {
  const plain = ticks(from, to, about);
  const step = plain.length > 1 ? plain[1].at - plain[0].at : to - from;
  const digits = -Math.floor(Math.log10(step) + 1e-9);
  if (digits <= MOST_DIGITS) return { ticks: plain, title: "" };
  const exponent = digits - 1;
  const common = Number((Math.floor(from * 10 ** (exponent - 2)) / 10 ** (exponent - 2)).toFixed(Math.max(exponent - 2, 0)));
  const labelled = plain.map(({ at }) => ({ at, label: ((at - common) * 10 ** exponent).toFixed(1) }));
  return { ticks: labelled, title: ` = ${common} + … × ${power10(exponent)}` };
}

/** A coordinate with as many digits as a window of this width needs. */
export function reading(value, width) {
  return value.toFixed(Math.min(12, Math.max(3, 3 - Math.floor(Math.log10(width)))));
}

/** A share in words. */
export function percent(share) {
  if (share === 0) return "0 %";
  if (share < 0.0001) return "< 0.01 %";
  return `${(100 * share).toFixed(2)} %`;
}

/** A count with thin spaces. */
export function grouped(count) {
  return String(Math.round(count)).replace(/\B(?=(\d{3})+$)/g, "\u202f");
}
