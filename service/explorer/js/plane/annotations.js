/** Draws annotations over the plane, in the period that is seen. */

import { measureInWords } from "../state/annotations.js";
import { strokeTwice } from "./marks.js";

const PIN = 4;
const TICK = 5;
const REACH = 12;
const FONT = '600 12px system-ui, "DejaVu Sans", sans-serif';

/** Write beside a point, on its other side where the frame ends. */
function write(plot, text, px, y, gap) {
  const { context } = plot;
  context.font = FONT;
  const wide = context.measureText(text).width;
  const x = px + gap + wide > plot.left + plot.width ? px - gap - wide : px + gap;
  context.textAlign = "left";
  context.textBaseline = "middle";
  context.lineJoin = "round";
  context.lineWidth = 3;
  context.strokeStyle = "rgb(0 0 0 / 75%)";
  context.strokeText(text, x, y);
  context.fillStyle = "#ffffff";
  context.fillText(text, x, y);
}

/**
 * Ends of a line on the screen, its first one in the period that is seen.
 * @param {import("./plot.js").Plot} plot
 * @param {import("../state/annotations.js").Measure} measure
 */
function endsOf(plot, { t0, v0, t1, v1 }) {
  const turn = Math.floor(t0 - plot.view.t0);
  return [plot.x(t0 - turn), plot.y(v0), plot.x(t1 - turn), plot.y(v1)];
}

/** @returns {[number, number]} */
function pinOf(plot, { t, v }) {
  return [plot.x(t - Math.floor(t - plot.view.t0)), plot.y(v)];
}

/** Draw a line with what it says. */
export function drawMeasure(plot, measure) {
  const { context } = plot;
  const [x0, y0, x1, y1] = endsOf(plot, measure);
  const length = Math.hypot(x1 - x0, y1 - y0) || 1, across = [((y1 - y0) / length) * TICK, (-(x1 - x0) / length) * TICK];
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  for (const [x, y] of [[x0, y0], [x1, y1]]) {
    context.moveTo(x - across[0], y - across[1]);
    context.lineTo(x + across[0], y + across[1]);
  }
  strokeTwice(context);
  write(plot, measureInWords(measure), (x0 + x1) / 2, (y0 + y1) / 2 - 8, 8);
}

/** @param {import("./plot.js").Plot} plot @param {import("../state/annotations.js").Annotated} annotated */
export function drawAnnotations(plot, { notes, measures }) {
  for (const measure of measures) drawMeasure(plot, measure);
  for (const note of notes) {
    const [x, y] = pinOf(plot, note);
    plot.context.beginPath();
    plot.context.arc(x, y, PIN, 0, 2 * Math.PI);
    strokeTwice(plot.context);
    write(plot, note.label, x, y, PIN + 5);
  }
}

/**
 * The annotation at a place of the screen; null if none is near.
 * @param {import("./plot.js").Plot} plot
 * @param {import("../state/annotations.js").Annotated} annotated
 */
export function annotationAt(plot, { notes, measures }, x, y, reach = REACH) {
  const away = (px, py) => Math.hypot(px - x, py - y);
  const all = [
    ...notes.map((note) => ({ note, away: away(...pinOf(plot, note)) })),
    ...measures.map((measure) => {
      const [x0, y0, x1, y1] = endsOf(plot, measure);
      return { measure, away: Math.min(away(x0, y0), away(x1, y1), away((x0 + x1) / 2, (y0 + y1) / 2)) };
    }),
  ].filter(({ away }) => away <= reach);
  return all.length ? all.reduce((best, each) => (each.away < best.away ? each : best)) : null;
}
