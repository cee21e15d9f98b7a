/** A small line chart as SVG: a frame with axes, and lines and marks in it. */

import { ticks } from "./ticks.js";

const SVG = "http://www.w3.org/2000/svg";
const MARGIN = { left: 58, right: 24, top: 8, bottom: 38 };

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
   * @param {{height: number, x: number[], y: number[], xLabel: string, yLabel: string, label: string}} what
   */
  constructor(place, { height, x, y, xLabel, yLabel, label }) {
    this.width = Math.max(place.clientWidth, 240);
    this.height = height;
    this.range = x;
    this.reach = y;
    this.svg = element("svg", { viewBox: `0 0 ${this.width} ${height}`, role: "img", "aria-label": label });
    const { left, bottom, top, right } = MARGIN;
    this.bottom = height - bottom;
    const frame = { class: "axis", x: left, y: top, width: this.width - left - right, height: this.bottom - top };
    this.svg.append(element("rect", frame));
    for (const { at, label: told } of ticks(...x, (this.width - left - right) / 80)) {
      this.add("path", { class: "axis", d: `M${this.x(at)} ${this.bottom}v5` });
      this.add("text", { x: this.x(at), y: this.bottom + 18, "text-anchor": "middle" }, told);
    }
    for (const { at, label: told } of ticks(...y, (this.bottom - top) / 36)) {
      this.add("path", { class: "axis", d: `M${left} ${this.y(at)}h-5` });
      this.add("text", { x: left - 8, y: this.y(at) + 4, "text-anchor": "end" }, told);
    }
    this.add("text", { x: (left + this.width - right) / 2, y: height - 4, "text-anchor": "middle" }, xLabel);
    const middle = (top + this.bottom) / 2;
    this.add("text", { x: 12, y: middle, "text-anchor": "middle", transform: `rotate(-90 12 ${middle})` }, yLabel);
    place.replaceChildren(this.svg);
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

  add(name, attributes, text) {
    const made = element(name, attributes, text);
    this.svg.append(made);
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
