/** The legend: solutions with colours and shares, which can be selected; or the scale of a number. */

import { element } from "../charts/chart.js";
import { expectedInWords, loudnessInWords, solutionInWords } from "../look/explain.js";
import { keyOf, loudest, scaleColour } from "../plane/palette.js";
import { grouped, percent } from "../charts/ticks.js";
import { inUnits } from "../state/machine.js";
import { maskLines } from "./masked.js";
import { swatch } from "./swatch.js";

const MEANINGS = {
  step: "Within how many impacts a cell has come to what it ends in: Hsu's step, which counts k impacts at a time.",
  group: "Hsu's group: the cycle of cells that is reached, by number.",
  period: "Hsu's period: cells in that cycle; 0 where there is none.",
  loudness: "Impact power of the motion that a cell ends in: half the squared speeds of its impacts, a forcing period. Grey is not known.",
};

/** What a picture shows, as the title of its legend. A preview has no numbers, and shows what cells end in. */
export function legendTitle(picture, { layer }) {
  if (layer === "loudness") return "How loud it ends";
  return layer === "solution" || !picture || picture.isPreview ? "It ends in" : "Cells by number";
}

function chaosInWords({ lyapunov_exponent, mean_life, mean_life_error, kind }) {
  if (lyapunov_exponent === null || !kind.startsWith("chaotic")) return "";
  const life = mean_life === null ? "" : `; left after some ${mean_life.toPrecision(1)} ± ${mean_life_error.toPrecision(1)} impacts`;
  return ` Largest Lyapunov exponent ${lyapunov_exponent.toFixed(3)} per forcing period${life}.`;
}

/** What a chaotic transient ends in, the most frequent first; with shares, unless all of it ends in the same. */
function endsInWords({ ends }, solutions) {
  if (!ends?.length) return "";
  if (ends.length === 1 && ends[0].share === 1) return ` It ends in ${solutions[ends[0].solution].name}.`;
  const told = ends.toSorted((a, b) => b.share - a.share).map((end) => `${solutions[end.solution].name} (${Math.round(100 * end.share)} %)`);
  const going = 1 - ends.reduce((sum, { share }) => sum + share, 0);
  return ` It ends in ${told.join(", ")}${going > 0 ? `; ${Math.round(100 * going)} % had not ended` : ""}.`;
}

function entry(solutions, solution, share, known, look, pick, scales) {
  const key = keyOf(solutions, solution.number);
  const button = document.createElement("button");
  button.type = "button";
  button.dataset.solution = key;
  button.setAttribute("aria-pressed", String(look.highlight === key));
  const heard = solution.impacts_per_period ? ` ${loudnessInWords(solution, scales)}.` : "";
  button.title = solutionInWords(solution) + chaosInWords(solution) + endsInWords(solution, solutions) + heard;
  const name = document.createElement("span");
  name.textContent = solution.name;
  const part = document.createElement("span");
  part.className = "share";
  part.textContent = known ? percent(share) : `${percent(share)} so far`;
  button.append(swatch(solution.colours[look.palette], false, solution.textures[look.palette]), name, part);
  button.addEventListener("click", () => pick(look.highlight === key ? null : key));
  const item = document.createElement("li");
  item.append(button);
  return item;
}

function listSolutions(picture, look, pick, scales) {
  const { outline } = picture;
  const counted = outline.complete ? outline.solutions.map(({ share }) => share ?? 0) : picture.shares();
  const there = outline.solutions.filter(({ number }) => counted[number] > 0 || outline.solutions[number].share === 0);
  there.sort((a, b) => counted[b.number] - counted[a.number]);
  const list = document.createElement("ul");
  list.append(...there.map((each) => entry(outline.solutions, each, counted[each.number], outline.complete, look, pick, scales)));
  return list;
}

/** What is to be heard on average, as far as it is known. */
function averageOf({ expected }, scales) {
  if (!expected) return [];
  return [note(expectedInWords(expected, scales))];
}

function bar(numbers) {
  const drawn = element("svg", { class: "scale", viewBox: "0 0 100 8", preserveAspectRatio: "none", "aria-hidden": "true" });
  for (let i = 0; i < 50; i++) {
    drawn.append(element("rect", { x: 2 * i, width: 2.1, height: 8, fill: `rgb(${scaleColour(i / 49).join(" ")})` }));
  }
  const ends = Object.assign(document.createElement("div"), { className: "ends" });
  ends.append(...numbers.map((text) => Object.assign(document.createElement("span"), { textContent: text })));
  return [drawn, ends];
}

function note(text) {
  return Object.assign(document.createElement("p"), { className: "note", textContent: text });
}

/** The scale of one of Hsu's numbers. `iterations`: the k of the request; null where that is not known. */
function describeNumbers(picture, layer, iterations) {
  const highest = Math.max(picture.highest(layer), 1);
  const meaning = note(MEANINGS[layer]);
  if (layer === "step") {
    const told = (step) => (iterations ? grouped(step * iterations) : `${grouped(step)} k`);
    if (highest === 1) return [note(`All cells that are here come to it within ${told(1)} impacts.`), meaning];
    return [...bar([told(1), told(Math.round(Math.sqrt(highest))), `${told(highest)} impacts`]), meaning];
  }
  if (layer === "group") meaning.textContent += " 0 is the sink; grey are permanent contact and what is undecided.";
  return [...bar(["0", "logarithmic", grouped(highest)]), meaning];
}

/** The scale of loudness, and how loud each motion is, the loudest first. */
function describeLoudness(picture, scales) {
  const told = (power) => (scales ? inUnits(power * scales.power, "W") : String(Number(power.toPrecision(3))));
  const most = loudest(picture.outline), shares = picture.shares();
  const list = Object.assign(document.createElement("ul"), { className: "heard" });
  const there = picture.outline.solutions.filter(({ number }) => shares[number] > 0);
  list.append(...there.toSorted((a, b) => (b.impact_power ?? -1) - (a.impact_power ?? -1)).map(({ name, impact_power: power }) => {
    const item = document.createElement("li");
    const fill = power === null ? "#8a8f98" : `rgb(${scaleColour(most > 0 ? power / most : 0).join(" ")})`;
    const heard = Object.assign(document.createElement("span"), { textContent: power === null ? "not known" : told(power) });
    item.append(swatch(fill), name, heard);
    return item;
  }));
  return [...bar([told(0), told(most / 2), told(most)]), list, note(MEANINGS.loudness)];
}

/**
 * Show the legend of a picture.
 * @param {HTMLElement} place
 * @param {import("../plane/picture.js").Picture|null} picture
 * @param {Look} look
 * @param {(solution: string|null) => void} pick
 * @param {Scales|null} [scales] one unit of the model in SI, of a machine in its own units
 * @param {number|null} [iterations] k of the picture's request
 */
export function showLegend(place, picture, look, pick, scales = null, iterations = null) {
  const active = /** @type {HTMLElement} */ (document.activeElement);
  const focused = place.contains(active) ? active.dataset.solution : null;
  if (!picture) place.replaceChildren();
  else if (picture.empty) place.textContent = "No solutions are known yet.";
  else if (look.layer === "loudness") place.replaceChildren(...describeLoudness(picture, scales), ...averageOf(picture.outline, scales), ...maskLines(picture, look));
  else if (look.layer === "solution" || picture.isPreview) {
    place.replaceChildren(listSolutions(picture, look, pick, scales), ...averageOf(picture.outline, scales), ...maskLines(picture, look));
  }
  else place.replaceChildren(...describeNumbers(picture, look.layer, iterations), ...maskLines(picture, look));
  if (focused) Array.from(place.querySelectorAll("button")).find((each) => each.dataset.solution === focused)?.focus();
}
