/** The picture that is seen with its caption, its legend and a key of what lies over it, on one canvas and as a PNG. */

import { maskNames } from "../state/additions.js";
import { TEXTURES } from "../panels/swatch.js";
import { inkOn, keyOf, scaleColour } from "../plane/palette.js";
import { sheetOf } from "./paper.js";
import { described } from "./png.js";
import { colour } from "./theme.js";

const ROW = 20;
const COLUMN = 215;
const LEAST_PLANE = 60;
const CURVE = "M1 12 C9 1 17 1 25 12";
const UPRIGHT = "M13 2V14 M7 8H19";
const FONT = '12px system-ui, "DejaVu Sans", sans-serif';

/** A part of the plane that has a legend of its own. @typedef {Pick<import("../plane/plane.js").Plane, "picture">} Part */
/** A line of the legend: a colour with its texture, a sign of an overlay, or a scale. @typedef {{name: string, colour?: string, texture?: number, sign?: {d: string, stroke: string}, scale?: boolean}} Row */

function percentOf(share) {
  return `${(100 * share).toFixed(1)} %`;
}

/** What a mask marks, where it is hatched. @param {Part} part @returns {Row[]} */
function veiledOf({ picture }, hatches) {
  if (!picture.masked || !hatches) return [];
  const { colour: fill, words } = picture.masked.mask;
  const { clear } = picture.masked.shares(picture.solution, picture.outline.solutions.length);
  return [{ name: `${words.veiled.toLowerCase()} (hatched)  ${percentOf(1 - clear.reduce((sum, each) => sum + each, 0))}`, colour: fill }];
}

/** @param {Part} part @param {Look} look @returns {Row[]} */
function legendOf({ picture }, look) {
  if (look.layer !== "solution" && !picture.isPreview) return [{ name: `${look.layer}: 0 to ${Math.max(picture.highest(look.layer), 1)}, logarithmic`, scale: true }];
  const shares = picture.shares();
  return picture.outline.solutions.filter(({ number }) => shares[number] > 0).map((solution) => ({
    name: `${keyOf(picture.outline.solutions, solution.number)}  ${percentOf(shares[solution.number])}`,
    colour: solution.colours[look.palette], texture: solution.textures?.[look.palette] ?? 0,
  }));
}

/** Overlays that are drawn, each with its sign. @returns {Row[]} */
function overlaysOf(plane, drawn) {
  return plane.overlays.filter(({ name }) => drawn.includes(name) && !maskNames().includes(name)).flatMap(({ label, sign, fetched }) => (fetched
    ? fetched.map((each) => ({ name: each.label, sign: { d: each.marker === null ? CURVE : UPRIGHT, stroke: each.colour } }))
    : [{ name: label, sign }]));
}

/** Rows of the legends of all basins that are seen, and of what lies over them. */
function rowsOf(plane, drawn) {
  const rows = (part) => (part?.picture ? [...legendOf(part, plane.look), ...veiledOf(part, plane.hatches)] : []);
  const kept = rows(plane.beside).map((row) => ({ ...row, name: `kept: ${row.name}` }));
  return [...rows(plane), ...kept, ...overlaysOf(plane, drawn)];
}

/** @param {CanvasRenderingContext2D} context @param {Row} row */
function drawSign(context, { colour: fill, texture, sign, scale }, x, y) {
  context.save();
  context.translate(x, y - 8);
  if (sign) {
    context.fillStyle = "#48505c";
    context.fillRect(0, 0, 26, 16);
    context.strokeStyle = sign.stroke;
    context.lineWidth = 2;
    context.lineCap = "round";
    context.stroke(new Path2D(sign.d));
  } else if (scale) {
    for (let i = 0; i < 26; i++) {
      context.fillStyle = `rgb(${scaleColour(i / 25).join(" ")})`;
      context.fillRect(i, 0, 1.1, 16);
    }
  } else {
    context.fillStyle = fill;
    context.fillRect(5, 0, 16, 16);
    context.translate(5, 0);
    context.strokeStyle = inkOn(fill);
    context.lineWidth = 1.4;
    if (texture) context.stroke(new Path2D(TEXTURES[texture]));
  }
  context.restore();
}

/**
 * Draw the plane with its caption and legend.
 * @param {import("../plane/plane.js").Plane} plane
 * @param {{title: string, overlays: string[]}} said the line below the plane, and names of the overlays that are drawn
 * @param {(screen: {width: number, height: number}) => import("./paper.js").Sheet} sheetFor what is drawn in place of the screen
 */
export function photograph(plane, { title, overlays }, sheetFor) {
  const panes = plane.shown, rows = rowsOf(plane, overlays);
  const across = (width) => Math.max(1, Math.floor(width / COLUMN));
  const below = (width) => ROW * (Math.ceil(rows.length / across(width)) + 1.6);
  const seen = panes.reduce((sum, { plot }) => sum + plot.size.width, 0);
  const sheet = sheetFor({ width: seen, height: Math.max(...panes.map(({ plot }) => plot.size.height)) + below(seen) });
  const { width, height, ratio } = sheet;
  const high = Math.max(height - below(width), LEAST_PLANE);
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  context.fillStyle = colour("card");
  context.fillRect(0, 0, width, height);
  const copies = panes.map((pane) => pane.copy(width / panes.length, high, ratio));
  copies.forEach(({ canvas: drawn }, i) => context.drawImage(drawn, (i * width) / panes.length, 0, width / panes.length, high));
  const [{ plot: { left } }] = copies;
  context.font = FONT;
  context.textBaseline = "middle";
  context.fillStyle = colour("ink");
  context.fillText(title, left, high + ROW / 2, width - left);
  const columns = across(width), wide = (width - 12) / columns;
  rows.forEach((row, i) => {
    const x = 12 + (i % columns) * wide, y = high + ROW * (1.6 + Math.floor(i / columns));
    drawSign(context, row, x, y);
    context.fillStyle = colour("ink");
    context.fillText(row.name, x + 32, y, wide - 36);
  });
  return { canvas, sheet, plot: copies[0].plot };
}

/**
 * The plane as a PNG, which carries its caption.
 * @param {import("../plane/plane.js").Plane} plane
 * @param {{title: string, overlays: string[], caption: string}} said
 * @param {import("./paper.js").Paper} paper
 * @returns {Promise<Blob>}
 */
export async function pictureOf(plane, said, paper) {
  const { canvas, sheet } = photograph(plane, said, (screen) => sheetOf(paper, screen));
  /** @type {Blob} */
  const blob = await new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
  const png = described(new Uint8Array(await blob.arrayBuffer()), { description: said.caption, dpi: sheet.dpi });
  return new Blob([/** @type {Uint8Array<ArrayBuffer>} */ (png)], { type: "image/png" });
}
