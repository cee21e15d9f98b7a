/** Another basin swiped over the one that is seen: it is drawn to the right of a line, with all that belongs to it. */

import { colour } from "../page/theme.js";
import { wrapped } from "./wrapping.js";

const LINE = 16;

/**
 * Draw the other basin.
 * @param {import("./plot.js").Plot} plot
 * @param {number} part of the width at which it begins
 * @param {() => void} draw
 */
export function drawSwipe(plot, part, draw) {
  const { context } = plot;
  const x = plot.left + part * plot.width;
  context.save();
  context.beginPath();
  context.rect(x, plot.top, plot.width, plot.height);
  context.clip();
  context.fillStyle = colour("plot");
  context.fillRect(x, plot.top, plot.width, plot.height);
  draw();
  context.restore();
  context.fillStyle = "#ffffff";
  context.fillRect(x - 1.5, plot.top, 3, plot.height);
}

/**
 * Say over a basin which one it is.
 * @param {import("./plot.js").Plot} plot
 * @param {number} part of the width at which it begins
 * @param {string} label
 */
export function drawLabel(plot, part, label) {
  const { context } = plot;
  const x = plot.left + part * plot.width;
  plot.clipped(() => {
    context.font = '12px system-ui, "DejaVu Sans", sans-serif';
    const lines = wrapped(label, plot.left + plot.width - x - 18, (text) => context.measureText(text).width);
    const width = Math.max(...lines.map((line) => context.measureText(line).width));
    context.fillStyle = "rgb(0 0 0 / 70%)";
    context.fillRect(x + 6, plot.top + 6, width + 12, LINE * lines.length + 4);
    context.fillStyle = "#ffffff";
    context.textAlign = "left";
    context.textBaseline = "middle";
    lines.forEach((line, i) => context.fillText(line, x + 12, plot.top + 8 + LINE * (i + 0.5)));
  });
}
