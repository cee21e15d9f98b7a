/** The plane of departures: pictures of basins, one over the other, with overlays and motions, on one canvas or on two. */

import { maskNames } from "../state/additions.js";
import { same, scaled, within } from "../state/window.js";
import { markAt } from "./overlays.js";
import { Pane } from "./pane.js";
import { paintOfName } from "./session.js";
import { Stack } from "./stack.js";

export class Plane {
  /**
   * @param {{canvas: HTMLCanvasElement, marks: HTMLCanvasElement}[]} canvases of the basin that is seen, and of one beside it
   * @param {object} tell
   * @param {(view: View) => void} tell.moved
   * @param {(place: Place|null) => void} tell.hovered
   * @param {(place: Place, second: boolean) => void} tell.picked
   * @param {() => void} tell.whole
   * @param {(done: string, place: Departure, from?: Departure) => void} tell.annotated by "pin", "measure", "end" or "unpin"
   * @param {() => void} [tell.drawn]
   */
  constructor(canvases, tell) {
    this.tell = tell;
    this.view = { t0: 0, t1: 1, v0: 0, v1: 7 };
    /** @type {Look} */
    /** One unit of the model in SI, while the axes are those of a machine. @type {Scales|null} */
    this.scales = null;
    this.look = { layer: "solution", palette: "colour_blind", highlight: null, ground: "#ffffff" };
    this.stack = new Stack();
    /** Another basin that is compared. @type {import("./half.js").Half|null} */
    this.beside = null;
    /** Whether that one has a canvas of its own, and is not swiped over this one. */
    this.side = false;
    this.overlays = [];
    this.motions = new Map();
    this.crossHair = null;
    this.boxing = false;
    /** Whether a click pins a point and a drag measures a distance. */
    this.annotating = false;
    /** @type {import("../state/annotations.js").Annotated} */
    this.annotated = { notes: [], measures: [] };
    this.sliding = false;
    this.soon = 0;
    this.panes = canvases.map((each, i) => new Pane(this, each, i > 0));
  }

  /** The canvases that are seen. */
  get shown() {
    return this.panes.filter(({ kept }) => !kept || (this.beside && this.side));
  }

  /** The drag that moves the window just now; null if there is none. */
  get drag() {
    return this.panes.find(({ gestures }) => gestures.panning)?.gestures.drag ?? null;
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

  /** Show a preview in place of the last one, unless that is better. */
  preview(picture) {
    picture.paint(this.look);
    this.stack.offer(picture);
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

  /** Colour and texture of a motion by its name, as it is drawn or would be. */
  paintOf(name) {
    return paintOfName(name, this.look.palette);
  }

  /** Whether at a time of the view the basin that was kept is swiped over the other. */
  isSwiped(t) {
    if (!this.beside || this.side) return false;
    const { t0, t1 } = this.view;
    return (t - t0) / (t1 - t0) > this.beside.part;
  }

  /** The basin that was kept, if a place is in that; else null. @param {{kept?: boolean}} place */
  keptAt({ kept }) {
    return kept ? this.beside : null;
  }

  /** What is known at a place. @param {Place} place */
  at(place) {
    return (this.keptAt(place) ?? this).stack.at(place.t, place.v);
  }

  /** The saddle whose cross is at a place, as "saddle P(1,1,0)"; null if there is none. @param {Place} place */
  saddleAt(place) {
    const kept = this.keptAt(place);
    const { plot } = this.panes[kept && this.side ? 1 : 0];
    return plot && markAt(plot, kept ? kept.overlaysOf(this.overlays) : this.overlays, this.inView(place));
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
      for (const pane of this.shown) pane.draw();
      this.tell.drawn?.();
    });
  }

  /** Whether what a mask marks is to be hatched. */
  get hatches() {
    return this.overlays.some(({ name }) => maskNames().includes(name));
  }

  /** The same departure, in the visible period. */
  inView({ t, v }) {
    const { t0 } = this.view;
    return { t: t - Math.floor(t - t0), v };
  }
}
