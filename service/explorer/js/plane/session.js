/** Colours that motions keep by their names as long as the page is open, whatever else a basin has. */

import { keyOf } from "./palette.js";
import { OWN, POOLS, TEXTURES } from "./pools.js";

/** What each name was last painted with, by palette. @type {Map<string, Map<string, Paint>>} */
const KEPT = new Map();

const textOf = ({ colour, texture }) => `${colour} ${texture}`;

/** A paint that nothing in the basin has, without a texture as long as there is one, and rather one that no name had. */
function freePaint(palette, used, claimed) {
  const all = TEXTURES.flatMap((texture) => POOLS[palette].map((colour) => ({ colour, texture })));
  const free = all.filter((paint) => !used.has(textOf(paint)));
  const plain = free.filter(({ texture }) => texture === 0);
  return plain.find((paint) => !claimed.has(textOf(paint))) ?? plain[0] ?? free[0];
}

function paintsIn(solutions, palette, kept) {
  const used = new Set();
  const paints = new Map();
  const give = (number, paint) => (paints.set(number, paint), used.add(textOf(paint)));
  const later = [];
  // The larger share keeps its colour.
  for (const { number } of solutions.toSorted((a, b) => (b.share ?? 0) - (a.share ?? 0))) {
    const { colours, textures } = solutions[number];
    const offered = { colour: colours[palette], texture: textures?.[palette] ?? 0 };
    const had = kept.get(keyOf(solutions, number));
    if (!POOLS[palette]?.includes(offered.colour)) give(number, offered);
    else if (had && !used.has(textOf(had))) give(number, had);
    else later.push([number, offered]);
  }
  const claimed = new Set([...kept.values()].map(textOf));
  for (const [number, offered] of later) {
    const there = !used.has(textOf(offered)) && !claimed.has(textOf(offered)) && offered.texture === 0;
    const paint = there ? offered : freePaint(palette, used, claimed) ?? offered;
    give(number, paint);
    kept.set(keyOf(solutions, number), paint);
    claimed.add(textOf(paint));
  }
  return paints;
}

/**
 * Colour and texture of a motion by its name, whether a basin has it or not: it keeps them as well.
 * @param {string} name
 * @param {string} palette
 * @param {Map<string, Map<string, Paint>>} [session]
 * @returns {Paint}
 */
export function paintOfName(name, palette, session = KEPT) {
  if (OWN[palette][name]) return { colour: OWN[palette][name], texture: 0 };
  if (!session.has(palette)) session.set(palette, new Map());
  const kept = session.get(palette);
  if (!kept.has(name)) {
    const claimed = new Set([...kept.values()].map(textOf));
    kept.set(name, freePaint(palette, claimed, claimed) ?? { colour: POOLS[palette][kept.size % POOLS[palette].length], texture: 0 });
  }
  return kept.get(name);
}

/**
 * An outline whose motions have the colours that they had before.
 * @template {{solutions: Solution[]}} T
 * @param {T} outline
 * @param {Map<string, Map<string, Paint>>} [session]
 * @returns {T}
 */
export function inKeptColours(outline, session = KEPT) {
  const { solutions } = outline;
  const changed = solutions.map((solution) => ({ ...solution, colours: { ...solution.colours }, textures: { ...solution.textures } }));
  for (const palette of Object.keys(POOLS)) {
    if (!session.has(palette)) session.set(palette, new Map());
    for (const [number, { colour, texture }] of paintsIn(solutions, palette, session.get(palette))) {
      [changed[number].colours[palette], changed[number].textures[palette]] = [colour, texture];
    }
  }
  return { ...outline, solutions: changed };
}

/**
 * Colours of the motions of a basin as the service's pictures take them, so that these have the same.
 * @param {Solution[]} solutions
 * @param {string} palette
 */
export function paintsText(solutions, palette) {
  return solutions.filter(({ kind }) => kind === "periodic").map(({ number, colours, textures }) => {
    const texture = textures?.[palette] ? `/${textures[palette]}` : "";
    return `${keyOf(solutions, number)}:${colours[palette].slice(1)}${texture}`;
  }).join(";");
}
