/** What is proven of the picture that is seen: shares by motion, and by the reason why the rest is not. */

import { percent } from "../charts/ticks.js";
import { REASONS } from "../look/explain.js";
import { swatch } from "./swatch.js";

const UNPROVEN = "#d9d9d9";

function line(sign, words, share) {
  const item = document.createElement("li");
  const part = Object.assign(document.createElement("span"), { className: "share", textContent: percent(share) });
  item.append(sign, Object.assign(document.createElement("span"), { textContent: words }), part);
  return item;
}

function list(title, items) {
  const drawn = document.createElement("ul");
  drawn.className = "proof";
  drawn.append(...items);
  return [Object.assign(document.createElement("h3"), { textContent: title }), drawn];
}

/**
 * Lines of the legend; none where no proof was asked for.
 * @param {import("../plane/picture.js").Picture} picture
 * @param {Look} look
 * @returns {HTMLElement[]}
 */
export function proofLines({ proof, solution, outline }, look) {
  if (!proof) return [];
  const { solutions } = outline;
  const { proven, reasons, tried } = proof.shares(solution, solutions.length);
  const whole = proven.reduce((sum, each) => sum + each, 0);
  const there = solutions.filter(({ number }) => proven[number] > 0).sort((a, b) => proven[b.number] - proven[a.number]);
  return [
    ...list(`Proven: ${percent(whole)}${tried ? "" : " so far"}`, there.map((each) => line(swatch(each.colours[look.palette], false, each.textures[look.palette]), each.name, proven[each.number]))),
    ...list(`Not proven: ${percent(1 - whole)}`, reasons.filter(({ share }) => share > 0).map(({ reason, share }) => line(swatch(UNPROVEN, true), REASONS[reason], share))),
  ];
}
