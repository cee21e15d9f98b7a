/** The picture that is seen, with its caption and legend, as a PNG. */

import { keyOf } from "../plane/palette.js";
import { colour } from "./theme.js";

const SCALE = 2;
const ROW = 20;
const FONT = '13px system-ui, "DejaVu Sans", sans-serif';

const UNPROVEN = "#d9d9d9";

/** What is not proven, where it is hatched. */
function unprovenOf({ picture, hatches }) {
  if (!picture.proof || !hatches) return [];
  const { proven } = picture.proof.shares(picture.solution, picture.outline.solutions.length);
  return [{ name: "not proven (hatched)", colour: UNPROVEN, share: 1 - proven.reduce((sum, each) => sum + each, 0) }];
}

function legendOf({ picture, look }) {
  if (look.layer !== "solution") return [];
  const shares = picture.shares();
  return picture.outline.solutions.filter(({ number }) => shares[number] > 0).map((solution) => ({
    name: keyOf(picture.outline.solutions, solution.number), colour: solution.colours[look.palette], share: shares[solution.number],
  }));
}

/**
 * Photograph the plane.
 * @param {import("../plane/plane.js").Plane} plane
 * @param {string} caption
 * @returns {Promise<Blob>}
 */
export function pictureOf(plane, caption) {
  const { width, height } = plane.plot.size;
  const legend = [...legendOf(plane), ...unprovenOf(plane)];
  const canvas = document.createElement("canvas");
  const below = ROW * (Math.ceil(legend.length / 3) + 2);
  [canvas.width, canvas.height] = [SCALE * width, SCALE * (height + below)];
  const context = canvas.getContext("2d");
  context.scale(SCALE, SCALE);
  context.fillStyle = colour("card");
  context.fillRect(0, 0, width, height + below);
  context.drawImage(plane.canvas, 0, 0, width, height);
  context.font = FONT;
  context.textBaseline = "middle";
  context.fillStyle = colour("ink");
  context.fillText(caption, plane.plot.left, height + ROW / 2);
  legend.forEach(({ name, colour: fill, share }, i) => {
    const x = plane.plot.left + (i % 3) * ((width - plane.plot.left) / 3);
    const y = height + ROW * (1.7 + Math.floor(i / 3));
    context.fillStyle = fill;
    context.fillRect(x, y - 6, 12, 12);
    context.fillStyle = colour("ink");
    context.fillText(`${name}  ${(100 * share).toFixed(1)} %`, x + 18, y);
  });
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}
