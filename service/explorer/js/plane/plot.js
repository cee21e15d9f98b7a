/** The frame of the basin: maps time and velocity to the canvas, and draws the axes. */

import { colour } from "../page/theme.js";
import { axisTicks } from "../charts/ticks.js";
import { axisUnit } from "../state/machine.js";

const RIGHT = 14;
const TOP = 10;
const BOTTOM = 44;
const TITLE = 22;
const LEAST_LEFT = 44;
const IN_PERIODS = { factor: 1, unit: "forcing periods" };
const PLAIN = { factor: 1, unit: "" };
const FONT = '12px system-ui, "DejaVu Sans", sans-serif';

/** Title of an axis; `common` is what its labels have in common. */
function titled(name, common, { factor, unit }) {
  const counted = unit && (!common || factor !== 1) ? ` (${unit})` : "";
  return common ? `${name}${common}${counted}` : `${name} of departure${counted}`;
}

export class Plot {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {{t0: number, t1: number, v0: number, v1: number}} view
   * @param {number} [ratio] pixels of the canvas for each of the page
   * @param {Scales|null} [scales] of a machine in whose units the axes are
   */
  constructor(canvas, view, ratio = window.devicePixelRatio || 1, scales = null) {
    this.view = view;
    this.units = {
      t: scales ? axisUnit(view.t1 - view.t0, scales.time, "s") : IN_PERIODS,
      v: scales ? axisUnit(view.v1 - view.v0, scales.speed, "m/s") : PLAIN,
    };
    this.size = { width: canvas.clientWidth, height: canvas.clientHeight };
    const [wide, high] = [Math.round(this.size.width * ratio), Math.round(this.size.height * ratio)];
    if (canvas.width !== wide || canvas.height !== high) [canvas.width, canvas.height] = [wide, high];
    this.context = canvas.getContext("2d");
    this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.context.imageSmoothingEnabled = false;
    this.context.font = FONT;
    this.top = TOP;
    this.height = Math.max(1, this.size.height - TOP - BOTTOM);
    this.speeds = this.#ticks(view.v0, view.v1, this.height / 60, this.units.v);
    // As wide as its labels: deep in a zoom they have many digits.
    const widest = Math.max(...this.speeds.ticks.map(({ label }) => this.context.measureText(label).width), 0);
    this.left = Math.max(LEAST_LEFT, Math.ceil(widest) + 12 + TITLE);
    this.width = Math.max(1, this.size.width - this.left - RIGHT);
    canvas.dataset.frame = [this.left, this.top, this.width, this.height].join();
  }

  x(t) {
    return this.left + ((t - this.view.t0) / (this.view.t1 - this.view.t0)) * this.width;
  }

  y(v) {
    return this.top + ((this.view.v1 - v) / (this.view.v1 - this.view.v0)) * this.height;
  }

  /** Time and velocity of a point on the canvas. */
  point(x, y) {
    const { t0, t1, v0, v1 } = this.view;
    return { t: t0 + ((x - this.left) / this.width) * (t1 - t0), v: v1 - ((y - this.top) / this.height) * (v1 - v0) };
  }

  contains(x, y) {
    return x >= this.left && x <= this.left + this.width && y >= this.top && y <= this.top + this.height;
  }

  /** Draw, clipped to the frame. */
  clipped(draw) {
    this.context.save();
    this.context.beginPath();
    this.context.rect(this.left, this.top, this.width, this.height);
    this.context.clip();
    draw();
    this.context.restore();
  }

  clear() {
    this.context.clearRect(0, 0, this.size.width, this.size.height);
    this.context.fillStyle = colour("plot");
    this.context.fillRect(this.left, this.top, this.width, this.height);
  }

  axes() {
    const { context } = this;
    const { t0, t1 } = this.view;
    const phases = this.#ticks(t0, t1, this.width / 90, this.units.t);
    context.strokeStyle = colour("quiet");
    context.fillStyle = colour("quiet");
    context.lineWidth = 1;
    context.font = FONT;
    context.strokeRect(this.left - 0.5, this.top - 0.5, this.width + 1, this.height + 1);
    context.textAlign = "center";
    context.textBaseline = "top";
    const bottom = this.top + this.height;
    for (const { at, label } of phases.ticks) {
      this.#tick(this.x(at), bottom, 0, 5);
      context.fillText(label, this.x(at), bottom + 8);
    }
    context.fillText(titled("time t", phases.title, this.units.t), this.left + this.width / 2, bottom + 26);
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (const { at, label } of this.speeds.ticks) {
      this.#tick(this.left, this.y(at), -5, 0);
      context.fillText(label, this.left - 8, this.y(at));
    }
    context.save();
    context.translate(11, this.top + this.height / 2);
    context.rotate(-Math.PI / 2);
    context.textAlign = "center";
    context.fillText(titled("velocity v", this.speeds.title, this.units.v), 0, 0);
    context.restore();
  }

  /** Ticks at round numbers of a unit, at their places in the model. */
  #ticks(from, to, about, { factor }) {
    const { ticks, title } = axisTicks(from * factor, to * factor, about);
    return { ticks: ticks.map(({ at, label }) => ({ at: at / factor, label })), title };
  }

  #tick(x, y, dx, dy) {
    this.context.beginPath();
    this.context.moveTo(Math.round(x) + 0.5, Math.round(y) + 0.5);
    this.context.lineTo(Math.round(x) + 0.5 + dx, Math.round(y) + 0.5 + dy);
    this.context.stroke();
  }
}
