/** The plane of departures: pictures of basins, one over the other, with overlays and motions. */

import { same, scaled, within } from "../state/window.js";
import { Gestures } from "./gestures.js";
import { hatchMissing } from "./hatching.js";
import { drawCrossHair, drawMotion, drawOverlay } from "./overlays.js";
import { Plot } from "./plot.js";
import { colourOfName } from "./session.js";
import { Stack } from "./stack.js";
import { drawSwipe } from "./swipe.js";
import { hatchUnproven } from "./unproven.js";
import { colour } from "../page/theme.js";

export class Plane {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {object} tell
   * @param {(view: View) => void} tell.moved
   * @param {(place: Departure|null) => void} tell.hovered
   * @param {(place: Departure, second: boolean) => void} tell.picked
   * @param {() => void} tell.whole
   * @param {() => void} [tell.drawn]
   */
  constructor(canvas, tell) {
    this.canvas = canvas;
    this.tell = tell;
    this.view = { t0: 0, t1: 1, v0: 0, v1: 7 };
    /** @type {Look} */
    this.look = { layer: "solution", palette: "colour_blind", highlight: null, ground: "#ffffff" };
    this.stack = new Stack();
    /** Another basin that is compared. @type {import("./half.js").Half|null} */
    this.beside = null;
    this.overlays = [];
    this.motions = new Map();
    this.crossHair = null;
    this.sliding = false;
    this.soon = 0;
    this.gestures = new Gestures(this, canvas);
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  /** The picture that is seen on top. */
  get picture() {
    return this.stack.top;
  }

  /** Put the picture of a job on top. */
  show(picture) {
    this.stack.add(picture);
    this.draw();
  }

  /** Show parts of the newest picture, of more cells, in place of the last ones. */
  closer(pictures) {
    this.stack.closer = pictures;
    this.draw();
  }

  /** Show a preview in place of the last one. */
  preview(picture) {
    picture.paint(this.look);
    this.stack.preview = picture;
    this.draw();
  }

  /** Remove all pictures, before another oscillator. */
  clear() {
    this.stack.clear();
    this.motions.clear();
    this.crossHair = null;
    this.draw();
  }

  /** A tile of a picture has arrived. */
  arrived(picture, tile) {
    // With a colour scale, one tile may change the colours of all.
    picture.paint(this.look, this.look.layer === "solution" ? tile : null);
    this.draw();
  }

  /** Repaint everything in another style. */
  restyle(look) {
    Object.assign(this.look, look);
    for (const picture of [...this.stack.drawn, ...(this.beside?.stack.drawn ?? [])]) picture.paint(this.look);
    this.draw();
  }

  /** Colour of a motion by its name, as it is drawn or would be. */
  colourOf(name) {
    return colourOfName(name, this.look.palette);
  }

  /** Whether a time of the view lies in the half of the basin that was kept. */
  isKept(t) {
    if (!this.beside) return false;
    const { t0, t1 } = this.view;
    return (t - t0) / (t1 - t0) > this.beside.part;
  }

  /** What is known at a point, of the half in which it is unless that is given. */
  at(t, v, kept = this.isKept(t)) {
    return (kept && this.beside ? this.beside : this).stack.at(t, v);
  }

  /** Move to another window, without an event. */
  lookAt(view) {
    this.view = view;
    this.draw();
  }

  /** Move while a gesture goes on: drawn with the next frame, without an event. */
  slide(view) {
    this.view = within(view);
    this.sliding = true;
    this.draw();
  }

  /** Move to another window, with an event, unless it is the same. */
  go(view) {
    const next = within(view);
    const stays = same(next, this.view) && !this.sliding;
    this.view = next;
    this.sliding = false;
    this.draw();
    if (!stays) this.tell.moved(this.view);
  }

  /** Zoom about the cross-hair or the middle. */
  zoom(factor) {
    const { t0, t1, v0, v1 } = this.view;
    this.go(scaled(this.view, this.crossHair ?? { t: (t0 + t1) / 2, v: (v0 + v1) / 2 }, factor));
  }

  /** Draw with the next frame. */
  draw() {
    this.soon ||= requestAnimationFrame(() => {
      this.soon = 0;
      this.#draw();
    });
  }

  #draw() {
    if (!this.canvas.clientWidth) return;
    const plot = (this.plot = new Plot(this.canvas, this.view));
    plot.clear();
    const { top, newest, preview, drawn } = this.stack;
    const { beside } = this;
    plot.clipped(() => {
      this.#drawPictures(plot, drawn, top);
      if (newest && !preview) hatchMissing(plot, newest);
      if (top) this.#drawOverlays(plot, top);
      this.#drawMotions(plot, false);
      if (beside) drawSwipe(plot, beside, () => {
        this.#drawPictures(plot, beside.stack.drawn, beside.picture);
        if (beside.picture) for (const overlay of beside.overlaysOf(this.overlays)) drawOverlay(plot, overlay, beside.picture);
        this.#drawMotions(plot, true);
      });
      if (this.crossHair) drawCrossHair(plot, this.crossHair);
      if (this.gestures.box) this.#drawBox(plot, this.gestures.box);
    });
    plot.axes();
    this.tell.drawn?.();
  }

  /** Pictures one over the other. Where the top one has a proof, all others are seen not to be proven. */
  #drawPictures(plot, pictures, top) {
    const hatched = this.hatches && top?.proof;
    for (const picture of pictures) {
      picture.draw(plot);
      if (hatched) hatchUnproven(plot, picture);
    }
  }

  #drawMotions(plot, ofKept) {
    for (const [name, { departures, kept }] of this.motions) {
      if (Boolean(kept) === ofKept) drawMotion(plot, departures.map((each) => this.inView(each)), name);
    }
  }

  /** Whether what is not proven is to be hatched. */
  get hatches() {
    return this.overlays.some(({ name }) => name === "proven");
  }

  /** Overlays; while the window is dragged, a bitmap of them that moves along. */
  #drawOverlays(plot, picture) {
    const { overlays } = this;
    if (!this.gestures.panning) {
      this.bitmap = null;
      for (const overlay of overlays) drawOverlay(plot, overlay, picture);
      return;
    }
    this.bitmap ??= this.#bitmapOf(this.gestures.drag);
    const { canvas, view, left, top } = this.bitmap;
    const nearest = Math.round(this.view.t0 - view.t0);
    for (const turn of [nearest - 1, nearest, nearest + 1]) {
      const [x, y] = [plot.x(view.t0 + turn) - left, plot.y(view.v1) - top];
      plot.context.drawImage(canvas, x, y, plot.size.width, plot.size.height);
    }
  }

  #bitmapOf({ view }) {
    const canvas = document.createElement("canvas");
    for (const name of ["clientWidth", "clientHeight"]) Object.defineProperty(canvas, name, { value: this.canvas[name] });
    const plot = new Plot(canvas, view);
    plot.clipped(() => this.overlays.forEach((overlay) => drawOverlay(plot, overlay, this.picture)));
    return { canvas, view, left: plot.left, top: plot.top };
  }

  /** The same departure, in the visible period. */
  inView({ t, v }) {
    const { t0 } = this.view;
    return { t: t - Math.floor(t - t0), v };
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
