/** What moves over the basin: the dot of the tooth that is played, the motion under the pointer, and the pointer itself on the other canvas. */

import { colour } from "../page/theme.js";

const MOST = 14;
const ARM = 9;

/**
 * Lines twice, so that they are seen on any colour.
 * @param {CanvasRenderingContext2D} context
 */
export function strokeTwice(context) {
  for (const [style, width] of /** @type {[string, number][]} */ ([["rgb(0 0 0 / 55%)", 3], ["#ffffff", 1.2]])) {
    context.strokeStyle = style;
    context.lineWidth = width;
    context.stroke();
  }
}

export class Marks {
  /** @param {import("./plane.js").Plane} plane */
  constructor(plane) {
    this.plane = plane;
    /** @type {{departure: Departure, name: string, kept: boolean}|null} */
    this.dot = null;
    /** @type {{departures: Departure[], kept: boolean}|null} */
    this.hovered = null;
    /** @type {Place|null} */
    this.pointer = null;
    plane.tell.drawn = () => this.draw();
  }

  /** Show the departure that the tooth has just made; null hides it. */
  showDot(departure, name, kept) {
    if (departure === (this.dot?.departure ?? null)) return;
    this.dot = departure && { departure, name, kept };
    this.draw();
  }

  /** Show departures of the motion under the pointer, and of which basin they are; null hides them. */
  showHovered(departures, kept = false) {
    this.hovered = departures && { departures, kept };
    this.draw();
  }

  /** Show where the pointer is on the canvas beside it; null where it is on none. @param {Place|null} place */
  showPointer(place) {
    this.pointer = place;
    if (this.plane.side) this.draw();
  }

  draw() {
    for (const pane of this.plane.shown) if (pane.plot) this.#drawOn(pane);
  }

  /** @param {import("./pane.js").Pane} pane */
  #drawOn({ marks, plot, kept }) {
    const ratio = window.devicePixelRatio || 1;
    const [wide, high] = [Math.round(plot.size.width * ratio), Math.round(plot.size.height * ratio)];
    if (marks.width !== wide || marks.height !== high) [marks.width, marks.height] = [wide, high];
    const context = marks.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, plot.size.width, plot.size.height);
    context.save();
    context.beginPath();
    context.rect(plot.left, plot.top, plot.width, plot.height);
    context.clip();
    const alone = this.plane.shown.length === 1;
    if (this.hovered && (alone || this.hovered.kept === kept)) this.#drawHovered(context, plot);
    if (this.dot && (alone || this.dot.kept === kept)) this.#drawDot(context, plot);
    if (this.pointer && !alone && this.pointer.kept !== kept) this.#drawPointer(context, plot);
    context.restore();
  }

  #place(plot, departure) {
    const { t, v } = this.plane.inView(departure);
    return [plot.x(t), plot.y(v)];
  }

  #drawPointer(context, plot) {
    const [x, y] = this.#place(plot, this.pointer);
    context.beginPath();
    context.moveTo(x - ARM, y);
    context.lineTo(x + ARM, y);
    context.moveTo(x, y - ARM);
    context.lineTo(x, y + ARM);
    strokeTwice(context);
  }

  #drawHovered(context, plot) {
    const departures = this.hovered.departures.slice(0, MOST);
    context.beginPath();
    departures.forEach((departure, i) => {
      const [x, y] = this.#place(plot, departure);
      if (i) context.lineTo(x, y);
      else context.moveTo(x, y);
    });
    strokeTwice(context);
    for (const departure of departures) {
      const [x, y] = this.#place(plot, departure);
      context.beginPath();
      context.arc(x, y, 2.5, 0, 2 * Math.PI);
      context.fillStyle = "#ffffff";
      context.fill();
    }
  }

  #drawDot(context, plot) {
    const [x, y] = this.#place(plot, this.dot.departure);
    for (const [radius, style] of /** @type {[number, string][]} */ ([[9, "#ffffff"], [7, "#000000"], [5.5, colour(this.dot.name)]])) {
      context.beginPath();
      context.arc(x, y, radius, 0, 2 * Math.PI);
      context.fillStyle = style;
      context.fill();
    }
  }
}
