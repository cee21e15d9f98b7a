/** Colours of cells, as 32-bit pixels of an ImageData. */

// Anchors of a scale of evenly increasing lightness, which colour-blind readers can read.
const SCALE = ["#440154", "#3b528b", "#21918c", "#5ec962", "#fde725"].map((hex) => channels(hex));
const STEPS = 256;

/**
 * Red, green and blue of "#rrggbb".
 * @returns {[number, number, number]}
 */
export function channels(hex) {
  const number = parseInt(hex.slice(1), 16);
  return [number >> 16, (number >> 8) & 255, number & 255];
}

function pixel([red, green, blue]) {
  return (255 << 24) | (blue << 16) | (green << 8) | red;
}

/** @param {[number, number, number]} rgb @returns {[number, number, number]} */
function brighter([red, green, blue], factor) {
  const channel = (value) => Math.min(255, Math.round(value * factor));
  return [channel(red), channel(green), channel(blue)];
}

/** @param {[number, number, number]} rgb @returns {[number, number, number]} */
function paler([red, green, blue], toward, part) {
  const channel = (value, i) => Math.round(value + (toward[i] - value) * part);
  return [channel(red, 0), channel(green, 1), channel(blue, 2)];
}

/** Colour at a position from 0 to 1 on the scale. */
export function scaleColour(place) {
  const at = Math.min(Math.max(place, 0), 1) * (SCALE.length - 1);
  const below = Math.min(Math.floor(at), SCALE.length - 2);
  return paler(SCALE[below], SCALE[below + 1], at - below);
}

const SCALE_PIXELS = Int32Array.from({ length: STEPS }, (_, i) => pixel(scaleColour(i / (STEPS - 1))));

/** Name of a solution that stays the same in every window: its own name, and its number among those of that name. */
export function keyOf(solutions, number) {
  const { name } = solutions[number];
  const twins = solutions.slice(0, number).filter((each) => each.name === name).length;
  return twins ? `${name} (${twins + 1})` : name;
}

/**
 * Brightness by speckle: 1 first, for the sink and for previews. Of the others, `usual` is 1, so that most of a motion
 * has the colour of the legend, whatever its groups are numbered in a window.
 */
function brightnesses({ speckle }, usual) {
  return [1, ...speckle.map((each) => each / speckle[usual])];
}

/** Whether a solution steps back behind the one that is highlighted, where that is there. */
function isFaint(highlight, solutions, number) {
  const keys = solutions.map((solution) => keyOf(solutions, solution.number));
  return keys.includes(highlight) && highlight !== keyOf(solutions, number);
}

/** Which brightness of the speckle most cells of chaotic solutions have. */
export function usualSpeckle({ solutions, speckle }, solution, group) {
  const chaotic = solutions.map(({ kind }) => kind.startsWith("chaotic"));
  const counts = new Array(speckle.length).fill(0);
  for (let i = 0; i < solution.length; i++) {
    if (solution[i] >= 0 && group[i] > 0 && chaotic[solution[i]]) counts[group[i] % speckle.length]++;
  }
  return counts.indexOf(Math.max(...counts));
}

/**
 * Pixels of solutions: for each number, one for every brightness of the speckle, beginning with the plain colour.
 * @param {Outline} outline
 * @param {{palette: string, highlight: string|null, ground: string}} look
 * @param {number} usual brightness of the speckle that most cells have
 */
export function solutionPixels(outline, look, usual) {
  const brightness = brightnesses(outline, usual);
  const table = new Int32Array(outline.solutions.length * brightness.length);
  const ground = channels(look.ground);
  for (const solution of outline.solutions) {
    const faint = isFaint(look.highlight, outline.solutions, solution.number);
    brightness.forEach((factor, i) => {
      let rgb = channels(solution.colours[look.palette]);
      if (solution.kind.startsWith("chaotic")) rgb = brighter(rgb, factor);
      if (faint) rgb = paler(rgb, ground, 0.86);
      table[solution.number * brightness.length + i] = pixel(rgb);
    });
  }
  return table;
}

/** Paint solutions of cells from..to of a row; missing cells stay transparent. `kinds` counts the speckle's values, 0 for none. */
export function paintSolutions(pixels, solution, group, table, kinds, from, to) {
  for (let i = from; i < to; i++) {
    const number = solution[i];
    pixels[i] = number < 0 ? 0 : table[number * (kinds + 1) + (kinds && group[i] > 0 ? 1 + (group[i] % kinds) : 0)];
  }
}

/** Whether the mark of a texture covers a cell, by its column and its row from the lowest speed. */
export function isMarked(texture, column, row) {
  if (texture === 1) return (column - row) % 5 === 0;
  if (texture === 2) return (column + row) % 5 === 0;
  return texture === 3 && column % 4 === 0 && row % 4 === 0;
}

/** "#000000" or "#ffffff", whichever is seen better on a colour. */
export function inkOn(colour) {
  const [red, green, blue] = channels(colour);
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue > 0.4 * 255 ? "#000000" : "#ffffff";
}

/** Texture and ink of each solution; null where none has a texture. @param {Outline} outline @param {Look} look */
export function texturesOf(outline, look) {
  const texture = outline.solutions.map(({ textures }) => textures?.[look.palette] ?? 0);
  if (!texture.some(Boolean)) return null;
  const ground = channels(look.ground);
  const ink = outline.solutions.map(({ number, colours }) => {
    const faint = isFaint(look.highlight, outline.solutions, number);
    const rgb = channels(inkOn(colours[look.palette]));
    return pixel(faint ? paler(rgb, ground, 0.86) : rgb);
  });
  return { texture, ink };
}

/** Mark cells from..to of a row, of a picture `width` cells wide, whose lowest row is the last. */
export function paintTextures(pixels, solution, { texture, ink }, width, from, to) {
  const row = solution.length / width - 1 - Math.floor(from / width);
  for (let i = from; i < to; i++) {
    const number = solution[i];
    if (number >= 0 && texture[number] && isMarked(texture[number], i % width, row)) pixels[i] = ink[number];
  }
}

/**
 * Where a number lies on its scale, from 0 to 1: logarithmic, because most cells have small numbers. Steps begin at 1: a
 * cell on the cycle itself has 0, and takes no more than one step either.
 */
export function placeOf(layer, value, highest) {
  if (layer === "step") return highest > 1 ? Math.log(Math.max(value, 1)) / Math.log(highest) : 0;
  return Math.log1p(value) / Math.log1p(Math.max(highest, 1));
}

/** Paint one of Hsu's numbers. */
export function paintNumbers(pixels, values, solution, layer, highest, special, from, to) {
  for (let i = from; i < to; i++) {
    const value = values[i];
    if (solution[i] < 0) pixels[i] = 0;
    else pixels[i] = value < 0 ? special : SCALE_PIXELS[Math.round((STEPS - 1) * placeOf(layer, value, highest))];
  }
}

/** The greatest impact power of the motions of a basin, where the scale of loudness ends. @param {Outline} outline */
export function loudest({ solutions }) {
  return solutions.reduce((most, { impact_power }) => Math.max(most, impact_power ?? 0), 0);
}

/** Pixels of solutions by how loud they are, silence first. @param {Outline} outline @param {number} special pixel of what is not known */
export function loudnessPixels(outline, special) {
  const most = loudest(outline);
  return Int32Array.from(outline.solutions, ({ impact_power: power }) =>
    (power === null ? special : SCALE_PIXELS[most > 0 ? Math.round(((STEPS - 1) * power) / most) : 0]));
}

/** Pixel of cells whose number is a code, not a count. */
export function specialPixel(hex) {
  return pixel(channels(hex));
}
