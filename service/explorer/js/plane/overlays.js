/** Overlays of a basin: the name of each, its symbol in the list, and its drawing. */

import { colour } from "../page/theme.js";
import { linesOf } from "./curves.js";

const SHIFTS = [-1, 0, 1];
// Of an upright cross, in pixels.
const ARM = 7;
const HALO = "rgb(0 0 0 / 55%)";

function onEachPeriod(plot, t, draw) {
  for (const shift of SHIFTS) {
    const x = plot.x(t + shift);
    if (x > plot.left - 12 && x < plot.left + plot.width + 12) draw(x);
  }
}

function strokeTwice(context, inner, width) {
  context.lineJoin = "round";
  for (const [style, wide] of [[HALO, width + 2], [inner, width]]) {
    context.strokeStyle = style;
    context.lineWidth = wide;
    context.stroke();
  }
}

/** Draw a curve of the (t, v) plane, given as lists of time and velocity. */
export function drawCurve(plot, curve, style, width) {
  const { context } = plot;
  for (const shift of SHIFTS) {
    context.beginPath();
    curve.time.forEach((t, i) => {
      const x = plot.x(t + shift), y = plot.y(curve.velocity[i]);
      // A curve that leaves on one side of the period returns on the other, without a line across.
      const torn = i === 0 || Math.abs(t - curve.time[i - 1]) > 0.5 || !Number.isFinite(y);
      if (torn) context.moveTo(x, y);
      else context.lineTo(x, y);
    });
    strokeTwice(context, style, width);
  }
}

function drawCross(plot, t, v) {
  const { context } = plot;
  const y = plot.y(v);
  onEachPeriod(plot, t, (x) => {
    context.beginPath();
    context.moveTo(x - 5, y - 5);
    context.lineTo(x + 5, y + 5);
    context.moveTo(x - 5, y + 5);
    context.lineTo(x + 5, y - 5);
    strokeTwice(context, "#ffffff", 2);
  });
}

function drawDots(plot, points) {
  const { context } = plot;
  context.fillStyle = "#000000";
  for (const [t, v] of points) {
    const y = plot.y(v);
    onEachPeriod(plot, t, (x) => context.fillRect(x - 0.75, y - 0.75, 1.5, 1.5));
  }
}

function drawAttractors(plot, picture) {
  for (const { kind, points } of picture.outline.solutions) {
    if (kind.startsWith("chaotic")) drawDots(plot, points);
    if (kind === "periodic") points.forEach(([t, v]) => drawCross(plot, t, v));
  }
}

function drawLines(plot, lines, style) {
  const { context } = plot;
  const path = new Path2D();
  for (const line of lines) {
    path.moveTo(line[0], line[1]);
    for (let i = 2; i < line.length; i += 2) path.lineTo(line[i], line[i + 1]);
  }
  context.lineJoin = "round";
  for (const [stroke, width] of [[style === "black" ? "rgb(255 255 255 / 60%)" : "rgb(0 0 0 / 75%)", 3.2], [style, 1.5]]) {
    context.strokeStyle = stroke;
    context.lineWidth = width;
    context.stroke(path);
  }
}

function drawUpright(plot, t, v) {
  const { context } = plot;
  const y = plot.y(v);
  onEachPeriod(plot, t, (x) => {
    context.beginPath();
    context.moveTo(x - ARM, y);
    context.lineTo(x + ARM, y);
    context.moveTo(x, y - ARM);
    context.lineTo(x, y + ARM);
    strokeTwice(context, "#ffffff", 2.2);
  });
}

function drawFetched(plot, overlays) {
  for (const overlay of overlays) {
    if (overlay.marker === null) drawLines(plot, linesOf(plot, overlay.pieces), overlay.colour);
    else overlay.pieces.forEach(({ time, velocity }) => time.forEach((t, i) => drawUpright(plot, t, velocity[i])));
  }
}

/** Overlays of a basin: some come with its outline or its cells, the others are fetched when first turned on. */
export const OVERLAYS = [
  {
    name: "grazing", label: "Grazing curve", on: true, sign: { d: "M1 12 C9 1 17 1 25 12", stroke: "#ffffff" },
    draw: (plot, picture) => drawCurve(plot, picture.outline.grazing, "#ffffff", 1.6),
  },
  {
    name: "attractors", label: "Attractors", on: true, sign: { d: "M4 3 L12 13 M4 13 L12 3 M18 5h.1 M21 9h.1 M19 12h.1 M23 6h.1", stroke: "#ffffff" },
    draw: drawAttractors,
  },
  { name: "preimages", label: "Pre-images of grazing", on: false, sign: { d: "M1 12 C9 1 17 1 25 12", stroke: "#ffff00" }, fetched: [] },
  { name: "manifolds", label: "Stable manifolds", on: false, sign: { d: "M1 4 C9 16 17 0 25 12", stroke: "#ff00ff" }, fetched: [] },
  { name: "saddles", label: "Saddles", on: false, sign: { d: "M13 2V14 M7 8H19", stroke: "#ffffff" }, fetched: [] },
];

/** Add the masks that the service knows, before the others. @param {Mask[]} masks */
export function addMasks(masks) {
  OVERLAYS.unshift(...masks.map(({ name, label, sign }) => ({ name, label, on: true, sign: { d: sign, stroke: "#ffffff" }, draw: () => {} })));
}

/** Draw an overlay. */
export function drawOverlay(plot, overlay, picture) {
  if (overlay.fetched) drawFetched(plot, overlay.fetched);
  else overlay.draw(plot, picture);
}

/**
 * Label of the mark of an overlay at a place, such as "saddle P(1,1,0)"; null if there is none.
 * @param {import("./plot.js").Plot} plot
 * @param {{t: number, v: number}} place
 */
export function markAt(plot, overlays, place) {
  const fetched = overlays.flatMap((overlay) => overlay.fetched ?? []).filter(({ marker }) => marker !== null);
  const [x, y] = [plot.x(place.t), plot.y(place.v)];
  const near = ({ time, velocity }) => time.some((at, i) => SHIFTS.some((shift) => Math.hypot(plot.x(at + shift) - x, plot.y(velocity[i]) - y) <= ARM));
  return fetched.find(({ pieces }) => pieces.some(near))?.label ?? null;
}

/** Draw a motion's departures from +beta, joined in order. */
export function drawMotion(plot, departures, name) {
  const { context } = plot;
  const style = colour(name);
  const inView = ({ t, v }) => [plot.x(t), plot.y(v)];
  context.strokeStyle = style;
  context.globalAlpha = 0.35;
  context.lineWidth = 1;
  context.beginPath();
  departures.slice(0, 30).forEach((departure, i) => {
    const [x, y] = inView(departure);
    if (i) context.lineTo(x, y);
    else context.moveTo(x, y);
  });
  context.stroke();
  context.globalAlpha = 1;
  departures.forEach((departure, i) => {
    const [x, y] = inView(departure);
    context.beginPath();
    context.arc(x, y, i ? 3 : 6, 0, 2 * Math.PI);
    context.fillStyle = style;
    context.fill();
    context.strokeStyle = "#ffffff";
    context.lineWidth = i ? 0.8 : 2;
    context.stroke();
  });
}

/** Cross-hair at a point. */
export function drawCrossHair(plot, { t, v }) {
  const { context } = plot;
  context.beginPath();
  context.moveTo(plot.x(t), plot.top);
  context.lineTo(plot.x(t), plot.top + plot.height);
  context.moveTo(plot.left, plot.y(v));
  context.lineTo(plot.left + plot.width, plot.y(v));
  context.setLineDash([4, 4]);
  strokeTwice(context, "#ffffff", 1);
  context.setLineDash([]);
}
