/** How large a picture is on paper: what the reader asks for, what the page draws, and what the service is asked. */

/** Most pixels of a picture, as the service has it: A4 at 600 dpi has 35 million. */
const MOST_PIXELS = 40_000_000;
const LIMITS = { width: [20, 1200], height: [20, 1200], dpi: [30, 1200], letters: [4, 36] };
const POINTS_PER_MM = 72 / 25.4;
// Letters of the page's plane, in its pixels.
const LETTERS = 12;
const ON_SCREEN = 2;

/** What is asked for: texts of fields, empty for as on the screen. @typedef {{width: string, height: string, dpi: string, letters: string}} Paper */
/** What is drawn: a size in pixels of the page, and how many pixels of the picture each has. @typedef {{width: number, height: number, ratio: number, dpi: number|null}} Sheet */

/** @type {Paper} */
export const USUAL = { width: "", height: "", dpi: "300", letters: "9" };
export const FIELDS = [["width", "Width, mm"], ["height", "Height, mm"], ["dpi", "Dots per inch"], ["letters", "Letters, points"]];

/** Numbers of the fields; null where no size on paper is asked for. @param {Paper} paper */
function numbersOf(paper) {
  if (!paper.width.trim() && !paper.height.trim()) return null;
  const given = Object.entries(paper).filter(([, text]) => text.trim() !== "").map(([name, text]) => [name, Number(text)]);
  for (const [name, number] of given) {
    const [least, most] = LIMITS[name];
    const label = FIELDS.find(([field]) => field === name)[1].toLowerCase();
    if (!(number >= least && number <= most)) throw new Error(`${label}: ${least} to ${most}`);
  }
  return /** @type {{width?: number, height?: number, dpi: number, letters: number}} */ ({ dpi: 300, letters: 9, ...Object.fromEntries(given) });
}

/**
 * What the page draws for a size on paper, of which one side may follow from the screen's.
 * @param {Paper} paper
 * @param {{width: number, height: number}} screen
 * @returns {Sheet}
 */
export function sheetOf(paper, screen) {
  const asked = numbersOf(paper);
  if (!asked) return { ...screen, ratio: ON_SCREEN, dpi: null };
  const width = asked.width ?? (asked.height * screen.width) / screen.height;
  const height = asked.height ?? (asked.width * screen.height) / screen.width;
  const dots = ([width, height].map((mm) => Math.round((mm / 25.4) * asked.dpi)));
  if (dots[0] * dots[1] > MOST_PIXELS) throw new Error(`a picture has at most 40 million pixels, not ${dots.join(" × ")}: take fewer dots per inch, or a smaller size`);
  const perPoint = LETTERS / asked.letters;
  return { width: width * POINTS_PER_MM * perPoint, height: height * POINTS_PER_MM * perPoint, ratio: asked.dpi / 72 / perPoint, dpi: asked.dpi };
}

/** What the service is asked for the same. @param {Paper} paper */
export function printingOf(paper) {
  const asked = numbersOf(paper);
  if (!asked) return {};
  const { letters, ...size } = asked;
  return { ...size, font_size: letters };
}
