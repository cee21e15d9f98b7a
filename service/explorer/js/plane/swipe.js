/** Another basin swiped over the one that is seen: it is drawn to the right of a line. */

import { colour } from "../page/theme.js";

/**
 * Draw the other basin.
 * @param {import("./plot.js").Plot} plot
 * @param {{pictures: import("./picture.js").Picture[], part: number, label: string}} beside pictures in the order in which they are drawn, and
 *   the part of the width at which they begin
 */
export function drawSwipe(plot, { pictures, part, label }) {
  const { context } = plot;
  const x = plot.left + part * plot.width;
  context.save();
  context.beginPath();
  context.rect(x, plot.top, plot.width, plot.height);
  context.clip();
  context.fillStyle = colour("plot");
  context.fillRect(x, plot.top, plot.width, plot.height);
  for (const picture of pictures) picture.draw(plot);
  context.restore();
  context.fillStyle = "#ffffff";
  context.fillRect(x - 1.5, plot.top, 3, plot.height);
  context.font = '12px system-ui, "DejaVu Sans", sans-serif';
  const width = context.measureText(label).width;
  context.fillStyle = "rgb(0 0 0 / 70%)";
  context.fillRect(x + 6, plot.top + 6, width + 12, 20);
  context.fillStyle = "#ffffff";
  context.textAlign = "left";
  context.textBaseline = "middle";
  context.fillText(label, x + 12, plot.top + 16);
}
