/** What moves over the basin: the dot of the tooth that is played, and the motion under the pointer. A canvas of its own. */

import { colour } from "../page/theme.js";

const MOST = 14;

export class Marks {
  /** @param {HTMLCanvasElement} canvas @param {import("./plane.js").Plane} plane */
  constructor(canvas, plane) {
    this.canvas = canvas;
    this.plane = plane;
    this.dot = null;
    this.hovered = null;
    plane.tell.drawn = () => this.draw();
  }

  /** Show the departure that the tooth has just made; null hides it. */
  showDot(departure, name) {
    if (departure === this.dot?.departure) return;
    this.dot = departure && { departure, name };
    this.draw();
  }

  /** Show departures of the motion under the pointer; null hides them. */
  showHovered(departures) {
    this.hovered = departures;
    this.draw();
  }

  draw() {
    const { plot } = this.plane;
    if (!plot) return;
    const ratio = window.devicePixelRatio || 1;
    const [wide, high] = [Math.round(plot.size.width * ratio), Math.round(plot.size.height * ratio)];
    if (this.canvas.width !== wide || this.canvas.height !== high) [this.canvas.width, this.canvas.height] = [wide, high];
    const context = this.canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, plot.size.width, plot.size.height);
    context.save();
    context.beginPath();
    context.rect(plot.left, plot.top, plot.width, plot.height);
    context.clip();
    if (this.hovered) this.#drawHovered(context, plot);
    if (this.dot) this.#drawDot(context, plot);
    context.restore();
  }

  #place(plot, departure) {
    const { t, v } = this.plane.inView(departure);
    return [plot.x(t), plot.y(v)];
  }

  #drawHovered(context, plot) {
    context.beginPath();
    this.hovered.slice(0, MOST).forEach((departure, i) => {
      const [x, y] = this.#place(plot, departure);
      if (i) context.lineTo(x, y);
      else context.moveTo(x, y);
    });
    for (const [style, width] of [["rgb(0 0 0 / 55%)", 3], ["#ffffff", 1.2]]) {
      context.strokeStyle = style;
      context.lineWidth = width;
      context.stroke();
    }
    for (const departure of this.hovered.slice(0, MOST)) {
      const [x, y] = this.#place(plot, departure);
      context.beginPath();
      context.arc(x, y, 2.5, 0, 2 * Math.PI);
      context.fillStyle = "#ffffff";
      context.fill();
    }
  }

  #drawDot(context, plot) {
    const [x, y] = this.#place(plot, this.dot.departure);
    for (const [radius, style] of [[9, "#ffffff"], [7, "#000000"], [5.5, colour(this.dot.name)]]) {
      context.beginPath();
      context.arc(x, y, radius, 0, 2 * Math.PI);
      context.fillStyle = style;
      context.fill();
    }
  }
}
