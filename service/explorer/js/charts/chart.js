/** A line chart as SVG: a frame with axes, and lines and marks in it. */

import { axisTicks } from "./ticks.js";

const SVG = "http://www.w3.org/2000/svg";
const MARGIN = { left: 58, right: 24, top: 8, bottom: 38 };
let charts = 0;

/** An SVG element. */
export function element(name, attributes = {}, text = "") {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text) made.textContent = text;
  return made;
}

export class Chart {
  /**
   * @param {HTMLElement} place whose content is replaced
   * @param {{height: number, x: number[], y: number[], xLabel: string, yLabel: string, label: string, cut?: boolean}} what
   * `cut`: whether what leaves the frame is not drawn
   */
  constructor(place, { height, x, y, xLabel, yLabel, label, cut = false }) {
    this.width = Math.max(place.clientWidth, 240);
    this.height = height;
    this.range = x;
    this.reach = y;
    this.svg = element("svg", { viewBox: `0 0 ${this.width} ${height}`, role: "img", "aria-label": label });
    this.into = this.svg;
    const { left, bottom, top, right } = MARGIN;
    this.bottom = height - bottom;
    const frame = { class: "axis", x: left, y: top, width: this.width - left - right, height: this.bottom - top };
    this.svg.append(element("rect", frame));
    const [across, up] = [axisTicks(x[0], x[1], (this.width - left - right) / 80), axisTicks(y[0], y[1], (this.bottom - top) / 36)];
    for (const { at, label: told } of across.ticks) {
      this.add("path", { class: "axis", d: `M${this.x(at)} ${this.bottom}v5` });
      this.add("text", { x: this.x(at), y: this.bottom + 18, "text-anchor": "middle" }, told);
    }
    for (const { at, label: told } of up.ticks) {
      this.add("path", { class: "axis", d: `M${left} ${this.y(at)}h-5` });
      this.add("text", { x: left - 8, y: this.y(at) + 4, "text-anchor": "end" }, told);
    }
    this.add("text", { x: (left + this.width - right) / 2, y: height - 4, "text-anchor": "middle" }, xLabel + across.title);
    const middle = (top + this.bottom) / 2;
    this.add("text", { x: 12, y: middle, "text-anchor": "middle", transform: `rotate(-90 12 ${middle})` }, yLabel + up.title);
    if (cut) this.into = this.#cut(frame);
    place.replaceChildren(this.svg);
  }

  #cut({ x, y, width, height }) {
    const id = `cut-${++charts}`;
    const path = this.add("clipPath", { id });
    path.append(element("rect", { x, y, width, height }));
    return this.add("g", { "clip-path": `url(#${id})` });
  }

  x(value) {
    const [from, to] = this.range;
    return MARGIN.left + ((value - from) / (to - from)) * (this.width - MARGIN.left - MARGIN.right);
  }

  y(value) {
    const [from, to] = this.reach;
    return this.bottom - ((value - from) / (to - from)) * (this.bottom - MARGIN.top);
  }

  /**
   * Value on the x axis at a pointer event.
   * @param {{clientX: number}} event
   */
  valueAt(event) {
    const box = this.svg.getBoundingClientRect();
    const x = ((event.clientX - box.left) / box.width) * this.width;
    const part = (x - MARGIN.left) / (this.width - MARGIN.left - MARGIN.right);
    return this.range[0] + part * (this.range[1] - this.range[0]);
  }

  /**
   * Place at a pointer event, also beyond the frame.
   * @param {{clientX: number, clientY: number}} event
   */
  placeAt(event) {
    const box = this.svg.getBoundingClientRect();
    const down = ((event.clientY - box.top) / box.height) * this.height;
    const [from, to] = this.reach;
    return { x: this.valueAt(event), y: from + ((this.bottom - down) / (this.bottom - MARGIN.top)) * (to - from) };
  }

  /** What one pixel is along each axis. */
  get unit() {
    const [[x0, x1], [y0, y1]] = [this.range, this.reach];
    return { x: (x1 - x0) / (this.width - MARGIN.left - MARGIN.right), y: (y1 - y0) / (this.bottom - MARGIN.top) };
  }

  /** A rectangle over the whole frame. */
  get frame() {
    const [x, y] = [this.x(this.range[0]), this.y(this.reach[1])];
    return { x, y, width: this.x(this.range[1]) - x, height: this.y(this.reach[0]) - y };
  }

  add(name, attributes, text) {
    const made = element(name, attributes, text);
    this.into.append(made);
    return made;
  }

  /** A line through points; a gap where one is missing. */
  line(xs, ys, attributes) {
    let pen = "M";
    const d = xs.flatMap((value, i) => {
      if (ys[i] === null) {
        pen = "M";
        return [];
      }
      const step = `${pen}${this.x(value).toFixed(1)} ${this.y(ys[i]).toFixed(1)}`;
      pen = "L";
      return [step];
    });
    return this.add("path", { d: d.join(""), ...attributes });
  }
}
