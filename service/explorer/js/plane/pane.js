/** One canvas of the plane: the basin that is seen, with the one that was kept swiped over it; or that one alone, beside it. */

import { colour } from "../page/theme.js";
import { drawAnnotations, drawMeasure } from "./annotations.js";
import { Gestures } from "./gestures.js";
import { hatchMissing } from "./hatching.js";
import { drawCrossHair, drawMotion, drawOverlay } from "./overlays.js";
import { Plot } from "./plot.js";
import { drawLabel, drawSwipe } from "./swipe.js";
import { layVeil } from "./veil.js";

/** A canvas of a size in pixels of the page, which is not on it. */
function canvasOf(clientWidth, clientHeight) {
  return Object.defineProperties(document.createElement("canvas"), { clientWidth: { value: clientWidth }, clientHeight: { value: clientHeight } });
}

export class Pane {
  /**
   * @param {import("./plane.js").Plane} plane
   * @param {{canvas: HTMLCanvasElement, marks: HTMLCanvasElement}} canvases of the basin, and of what moves over it
   * @param {boolean} kept whether it shows the basin that was kept, and nothing else
   */
  constructor(plane, { canvas, marks }, kept) {
    this.plane = plane;
    this.canvas = canvas;
    this.marks = marks;
    this.kept = kept;
    /** @type {Plot|null} */
    this.plot = null;
    /** Bitmaps of overlays while the window is dragged, by whether they are of the basin that was kept. */
    this.bitmaps = new Map();
    this.gestures = new Gestures(plane, this, canvas);
    new ResizeObserver(() => plane.draw()).observe(canvas);
  }

  /** A departure at a point of the canvas, and in which basin it is. */
  placeAt(x, y) {
    return this.place(this.plot.point(x, y));
  }

  /** A departure, and in which basin it is on this canvas. @param {{t: number, v: number}} departure @returns {Place} */
  place({ t, v }) {
    return { t, v, kept: this.kept || this.plane.isSwiped(t) };
  }

  draw() {
    if (!this.canvas.clientWidth) return;
    this.#drawOn((this.plot = new Plot(this.canvas, this.plane.view, undefined, this.plane.scales)));
  }

  /** The same at another size, on a canvas of its own. @param {number} width @param {number} height @param {number} ratio */
  copy(width, height, ratio) {
    const canvas = canvasOf(width, height);
    const plot = new Plot(canvas, this.plane.view, ratio, this.plane.scales);
    this.#drawOn(plot);
    return { canvas, plot };
  }

  #drawOn(plot) {
    const { plane } = this;
    const { beside } = plane;
    plot.clear();
    if (!plane.drag) this.bitmaps.clear();
    plot.clipped(() => {
      this.#drawBasin(plot, this.kept);
      if (beside && !plane.side) drawSwipe(plot, beside.part, () => this.#drawBasin(plot, true));
      if (plane.crossHair) drawCrossHair(plot, plane.crossHair);
      drawAnnotations(plot, plane.annotated);
      if (this.gestures.line) drawMeasure(plot, this.gestures.line);
      if (this.gestures.box) this.#drawBox(plot, this.gestures.box);
    });
    plot.axes();
    if (beside && (this.kept || !plane.side)) drawLabel(plot, this.kept ? 0 : beside.part, beside.label);
  }

  /** The pictures of a basin, one over the other, with what lies over them. */
  #drawBasin(plot, ofKept) {
    const { plane } = this;
    const { top, newest, preview, drawn } = ofKept ? plane.beside.stack : plane.stack;
    // Where the top one has a mask, all others are seen to be veiled.
    const veiled = plane.hatches && top?.masked;
    for (const picture of drawn) {
      picture.draw(plot);
      if (veiled) layVeil(plot, picture);
    }
    if (newest && !preview) hatchMissing(plot, newest);
    if (top) this.#drawOverlays(plot, top, ofKept);
    for (const [name, { departures, kept }] of plane.motions) {
      if (Boolean(kept) === ofKept) drawMotion(plot, departures.map((each) => plane.inView(each)), name);
    }
  }

  /** Overlays; while the window is dragged, a bitmap of them that moves along. */
  #drawOverlays(plot, picture, ofKept) {
    const { plane } = this;
    const overlays = ofKept ? plane.beside.overlaysOf(plane.overlays) : plane.overlays;
    if (!plane.drag) {
      for (const overlay of overlays) drawOverlay(plot, overlay, picture);
      return;
    }
    if (!this.bitmaps.has(ofKept)) this.bitmaps.set(ofKept, this.#bitmapOf(plane.drag.view, overlays, picture));
    const { canvas, view, left, top } = this.bitmaps.get(ofKept);
    const nearest = Math.round(plane.view.t0 - view.t0);
    for (const turn of [nearest - 1, nearest, nearest + 1]) {
      const [x, y] = [plot.x(view.t0 + turn) - left, plot.y(view.v1) - top];
      plot.context.drawImage(canvas, x, y, plot.size.width, plot.size.height);
    }
  }

  #bitmapOf(view, overlays, picture) {
    const canvas = canvasOf(this.canvas.clientWidth, this.canvas.clientHeight);
    const plot = new Plot(canvas, view, undefined, this.plane.scales);
    plot.clipped(() => overlays.forEach((overlay) => drawOverlay(plot, overlay, picture)));
    return { canvas, view, left: plot.left, top: plot.top };
  }

  #drawBox({ context }, { from, to }) {
    context.strokeStyle = colour("accent");
    context.lineWidth = 1.5;
    context.fillStyle = "rgb(127 180 255 / 18%)";
    const rectangle = [from.x, from.y, to.x - from.x, to.y - from.y];
    context.fillRect(...rectangle);
    context.strokeRect(...rectangle);
  }
}
