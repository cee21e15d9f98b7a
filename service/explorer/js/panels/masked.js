/** What a mask leaves clear of the picture that is seen: shares by motion, or their bounds, and of the rest by reason. */

import { percent } from "../charts/ticks.js";
import { swatch } from "./swatch.js";

function line(sign, words, share) {
  const item = document.createElement("li");
  const part = Object.assign(document.createElement("span"), { className: "share", textContent: share });
  item.append(sign, Object.assign(document.createElement("span"), { textContent: words }), part);
  return item;
}

function list(title, items) {
  const drawn = document.createElement("ul");
  drawn.className = "masked";
  drawn.append(...items);
  return [Object.assign(document.createElement("h3"), { textContent: title }), drawn];
}

/**
 * Lines of the legend; none where there is no mask.
 * @param {import("../plane/picture.js").Picture} picture
 * @param {Look} look
 * @returns {HTMLElement[]}
 */
export function maskLines({ masked, solution, outline }, look) {
  if (!masked) return [];
  const { solutions } = outline;
  const { colour, words, reasons: whys } = masked.mask;
  const { clear, reasons, tried } = masked.shares(solution, solutions.length);
  const whole = clear.reduce((sum, each) => sum + each, 0);
  const bounds = outline.share_bounds ?? [];
  const there = solutions.filter(({ number }) => clear[number] > 0 || bounds[number]).sort((a, b) => clear[b.number] - clear[a.number]);
  return [
    ...list(`${words.clear}: ${percent(whole)}${tried ? "" : " so far"}`, there.map((each) => line(swatch(each.colours[look.palette], false, each.textures[look.palette]), each.name, (bounds[each.number] ?? [clear[each.number]]).map(percent).join(" to ")))),
    ...list(`${words.veiled}: ${percent(1 - whole)}`, reasons.filter(({ share }) => share > 0).map(({ reason, share }) => line(swatch(colour, true), whys[reason], percent(share)))),
  ];
}
