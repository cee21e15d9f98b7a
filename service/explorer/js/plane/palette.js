/** Colours of cells, as 32-bit pixels of an ImageData. */

// Anchors of a scale of evenly increasing lightness, which colour-blind readers can read.
const SCALE = ["#440154", "#3b528b", "#21918c", "#5ec962", "#fde725"].map(channels);
const STEPS = 256;

/** Red, green and blue of "#rrggbb". */
export function channels(hex) {
  return [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
}

function pixel([red, green, blue]) {
  return (255 << 24) | (blue << 16) | (green << 8) | red;
}

function brighter(rgb, factor) {
  return rgb.map((channel) => Math.min(255, Math.round(channel * factor)));
}

function paler(rgb, toward, part) {
  return rgb.map((channel, i) => Math.round(channel + (toward[i] - channel) * part));
}

/** Colour at a position from 0 to 1 on the scale. */
export function scaleColour(place) {
  const at = Math.min(Math.max(place, 0), 1) * (SCALE.length - 1);
  const below = Math.min(Math.floor(at), SCALE.length - 2);
  return paler(SCALE[below], SCALE[below + 1], at - below);
}

const SCALE_PIXELS = Int32Array.from({ length: STEPS }, (_, i) => pixel(scaleColour(i / (STEPS - 1))));

/**
 * Pixels of solutions: for each number, one for every brightness of the speckle.
 * @param {object} outline
 * @param {{palette: string, highlight: number|null, ground: string}} look
 */
export function solutionPixels(outline, look) {
  const kinds = outline.speckle.length;
  const table = new Int32Array(outline.solutions.length * kinds);
  const ground = channels(look.ground);
  for (const solution of outline.solutions) {
    const faint = look.highlight !== null && look.highlight !== solution.number;
    for (let i = 0; i < kinds; i++) {
      let rgb = channels(solution.colours[look.palette]);
      if (solution.kind.startsWith("chaotic")) rgb = brighter(rgb, outline.speckle[i]);
      if (faint) rgb = paler(rgb, ground, 0.86);
      table[solution.number * kinds + i] = pixel(rgb);
    }
  }
  return table;
}

/** Paint solutions of cells from..to of a row; missing cells stay transparent. */
export function paintSolutions(pixels, solution, group, table, kinds, from, to) {
  for (let i = from; i < to; i++) {
    const number = solution[i];
    pixels[i] = number < 0 ? 0 : table[number * kinds + (((group[i] % kinds) + kinds) % kinds)];
  }
}

/** Paint one of Hsu's numbers on a logarithmic scale, because most cells have small numbers. */
export function paintNumbers(pixels, values, solution, highest, special, from, to) {
  const factor = (STEPS - 1) / Math.log1p(Math.max(highest, 1));
  for (let i = from; i < to; i++) {
    const value = values[i];
    if (solution[i] < 0) pixels[i] = 0;
    else pixels[i] = value < 0 ? special : SCALE_PIXELS[Math.round(Math.log1p(value) * factor)];
  }
}

/** Pixel of cells whose number is a code, not a count. */
export function specialPixel(hex) {
  return pixel(channels(hex));
}
