/** Frames of a film: the plane with its caption and legend at each value of a slider, at each step of a sweep, or with a tooth in motion. */

import { oscillatorInWords } from "../look/caption.js";
import { askPreview } from "../look/preview.js";
import { photograph } from "../page/photograph.js";
import { Picture } from "../plane/picture.js";
import { Stack } from "../plane/stack.js";
import { changesAt, stepsOf } from "../state/steps.js";
import { withValues } from "../state/oscillator.js";
import { colour } from "../page/theme.js";
import { drawTooth } from "../tooth/drawing.js";
import { departureAt, displacementAt, glowAt } from "../tooth/playing.js";

const WIDEST = 960;
const CELLS = 160;
const TOOTH = 130;
const FADE_PERIODS = 0.08;

function sheetFor({ width, height }) {
  return { width, height, ratio: Math.min(1, WIDEST / width), dpi: null };
}

/** A photograph of the plane as if it showed another picture, with what belongs to that one alone. */
function shotOf(plane, picture, oscillator) {
  const { stack, beside, side, overlays, motions } = plane;
  const own = overlays.filter(({ fetched }) => !fetched);
  picture.paint(plane.look);
  const other = new Stack();
  other.preview = picture;
  [plane.stack, plane.beside, plane.side, plane.overlays, plane.motions] = [other, null, false, own, new Map()];
  try {
    return photograph(plane, { title: oscillatorInWords(oscillator), overlays: own.map(({ name }) => name) }, sheetFor).canvas;
  } finally {
    [plane.stack, plane.beside, plane.side, plane.overlays, plane.motions] = [stack, beside, side, overlays, motions];
  }
}

/** A finished preview at each value of a parameter. */
export async function* ofSlider({ plane, oscillator }, parameter, values, signal) {
  const { view } = plane;
  for (const value of values) {
    const turned = withValues(oscillator, { [parameter]: value });
    yield shotOf(plane, await askPreview(turned, view, { cells: CELLS, iterations: null, quick: false }, signal), turned);
  }
}

/** Each basin of a sweep. @param {{plane: any, job: Job}} seen @param {AbortSignal} signal */
export async function* ofSweep({ plane, job }, signal) {
  const steps = stepsOf(job.request);
  const basins = steps.reduce((product, { values }) => product * values.length, 1);
  for (let panel = 0; panel < basins; panel++) {
    const picture = await Picture.open(job.id, panel);
    await picture.refresh(true, () => {}, signal);
    yield shotOf(plane, picture, withValues(job.request.oscillator, changesAt(steps, panel)));
  }
}

/** The tooth below the plane, at each time, with its dot on the plane. */
export function* ofTooth({ plane, title, overlays, oscillator }, motion, times) {
  const base = photograph(plane, { title, overlays }, sheetFor);
  const { ratio, width } = base.sheet;
  const tooth = Object.defineProperties(document.createElement("canvas"), { clientWidth: { value: width }, clientHeight: { value: TOOTH } });
  for (const at of times) {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [base.canvas.width, base.canvas.height + Math.round(TOOTH * ratio)];
    const context = canvas.getContext("2d");
    context.fillStyle = colour("card");
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.drawImage(base.canvas, 0, 0);
    const departure = departureAt(motion.departures, at);
    context.scale(ratio, ratio);
    if (departure) drawDot(context, base.plot, plane.inView(departure));
    drawTooth(tooth, { displacement: displacementAt(motion.shown, at), backlash: (motion.kept?.oscillator ?? oscillator).half_backlash, glow: glowAt(motion.shown, at, FADE_PERIODS), name: "first" });
    context.drawImage(tooth, 0, base.canvas.height / ratio, width, TOOTH);
    yield canvas;
  }
}

function drawDot(context, plot, { t, v }) {
  const [x, y] = [plot.x(t), plot.y(v)];
  if (!plot.contains(x, y)) return;
  for (const [radius, style] of /** @type {[number, string][]} */ ([[9, "#ffffff"], [7, "#000000"], [5.5, colour("first")]])) {
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fillStyle = style;
    context.fill();
  }
}
