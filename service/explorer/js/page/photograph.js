/** The picture that is seen, with its caption and legend, as a PNG. */

import { keyOf } from "../plane/palette.js";
import { colour } from "./theme.js";

const SCALE = 2;
const ROW = 20;
const FONT = '13px system-ui, "DejaVu Sans", sans-serif';

/** A part of the plane that has a legend of its own. @typedef {Pick<import("../plane/plane.js").Plane, "picture">} Part */

/** What a mask marks, where it is hatched. @param {Part} part */
function veiledOf({ picture }, hatches) {
  if (!picture.masked || !hatches) return [];
  const { colour: fill, words } = picture.masked.mask;
  const { clear } = picture.masked.shares(picture.solution, picture.outline.solutions.length);
  return [{ name: `${words.veiled.toLowerCase()} (hatched)`, colour: fill, share: 1 - clear.reduce((sum, each) => sum + each, 0) }];
}

/** @param {Part} part @param {Look} look */
function legendOf({ picture }, look) {
  if (look.layer !== "solution") return [];
  const shares = picture.shares();
  return picture.outline.solutions.filter(({ number }) => shares[number] > 0).map((solution) => ({
    name: keyOf(picture.outline.solutions, solution.number), colour: solution.colours[look.palette], share: shares[solution.number],
  }));
}

/** Rows of the legends of all basins that are seen. @param {import("../plane/plane.js").Plane} plane */
function rowsOf(plane) {
  const rows = (part) => (part?.picture ? [...legendOf(part, plane.look), ...veiledOf(part, plane.hatches)] : []);
  const kept = rows(plane.beside).map((row) => ({ ...row, name: `kept: ${row.name}` }));
  return [...rows(plane), ...kept];
}

/**
 * Photograph the plane.
 * @param {import("../plane/plane.js").Plane} plane
 * @param {string} caption
 * @returns {Promise<Blob>}
 */
export function pictureOf(plane, caption) {
  const panes = plane.shown;
  const [{ left }] = panes.map(({ plot }) => plot);
  const width = panes.reduce((sum, { plot }) => sum + plot.size.width, 0);
  const height = Math.max(...panes.map(({ plot }) => plot.size.height));
  const legend = rowsOf(plane);
  const canvas = document.createElement("canvas");
  const below = ROW * (Math.ceil(legend.length / 3) + 2);
  [canvas.width, canvas.height] = [SCALE * width, SCALE * (height + below)];
  const context = canvas.getContext("2d");
  context.scale(SCALE, SCALE);
  context.fillStyle = colour("card");
  context.fillRect(0, 0, width, height + below);
  let across = 0;
  for (const { canvas: drawn, plot } of panes) {
    context.drawImage(drawn, across, 0, plot.size.width, plot.size.height);
    across += plot.size.width;
  }
  context.font = FONT;
  context.textBaseline = "middle";
  context.fillStyle = colour("ink");
  context.fillText(caption, left, height + ROW / 2);
  legend.forEach(({ name, colour: fill, share }, i) => {
    const x = left + (i % 3) * ((width - left) / 3);
    const y = height + ROW * (1.7 + Math.floor(i / 3));
    context.fillStyle = fill;
    context.fillRect(x, y - 6, 12, 12);
    context.fillStyle = colour("ink");
    context.fillText(`${name}  ${(100 * share).toFixed(1)} %`, x + 18, y);
  });
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}
