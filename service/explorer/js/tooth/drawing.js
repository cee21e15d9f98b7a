/** Draws a tooth in its backlash: two flanks of one gear, and the tooth of the other between them. */

import { colour } from "../page/theme.js";

/** Place of a displacement across the drawing: the backlash takes most of the width. */
function placing(width, backlash) {
  const middle = width / 2;
  const reach = width * 0.17;
  return (displacement) => middle + (displacement / backlash) * reach;
}

/** The side of a tooth is inclined: this far over its height, in heights of the drawing. */
const TAPER = 0.1;
const CREST = 0.12;
const ROOT = 0.68;
// With less width the displacement would lie over the names of the walls.
const ROOMY = 200;

function flank(context, { x, side, width, height, glow }) {
  const outer = side > 0 ? width : 0;
  const foot = x - side * height * TAPER;
  context.beginPath();
  context.moveTo(x, height * CREST);
  context.lineTo(foot, height * ROOT);
  context.lineTo(width / 2, height * ROOT);
  context.lineTo(width / 2, height * 0.82);
  context.lineTo(outer, height * 0.82);
  context.lineTo(outer, height * CREST);
  context.closePath();
  context.fillStyle = colour("gear");
  context.fill();
  if (glow < 0.01) return;
  context.beginPath();
  context.moveTo(x, height * CREST);
  context.lineTo(foot, height * ROOT);
  context.lineWidth = 3 + 9 * glow;
  context.strokeStyle = colour("strike");
  context.globalAlpha = Math.min(1, 0.25 + glow);
  context.stroke();
  context.globalAlpha = 1;
}

function tooth(context, { x, half, height, name }) {
  const reach = (ROOT - CREST - 0.08) / (ROOT - CREST);
  context.beginPath();
  context.moveTo(x - half, height * CREST);
  context.lineTo(x - half + height * TAPER * reach, height * (ROOT - 0.08));
  context.lineTo(x + half - height * TAPER * reach, height * (ROOT - 0.08));
  context.lineTo(x + half, height * CREST);
  context.lineTo(x + half, 0);
  context.lineTo(x - half, 0);
  context.closePath();
  context.fillStyle = colour(name);
  context.fill();
}

/**
 * Draw the tooth at a displacement.
 * @param {HTMLCanvasElement} canvas
 * @param {{displacement: number, backlash: number, glow: {upper: number, lower: number}, name: string}} state
 */
export function drawTooth(canvas, { displacement, backlash, glow, name }) {
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
  if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  const x = placing(width, backlash);
  const half = width * 0.13;
  flank(context, { x: x(-backlash) - half, side: -1, width, height, glow: glow.lower });
  flank(context, { x: x(backlash) + half, side: 1, width, height, glow: glow.upper });
  tooth(context, { x: x(displacement), half, height, name });
  context.fillStyle = colour("quiet");
  context.font = '12px system-ui, "DejaVu Sans", sans-serif';
  context.textAlign = "center";
  context.fillText("−β", x(-backlash) - half, height * 0.95);
  context.fillText("+β", x(backlash) + half, height * 0.95);
  if (width > ROOMY) context.fillText(`Φ = ${displacement.toFixed(3)}`, width / 2, height * 0.95);
}
