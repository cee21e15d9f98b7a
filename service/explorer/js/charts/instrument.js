/**
 * A chart to work with: its points are pointed at and named, it is zoomed by a box, the wheel, two fingers and keys, steps
 * back, and is saved as a picture and as a table.
 */

import { asCsv, saveBlob } from "../page/save.js";
import { attempt } from "../page/say.js";
import { Chart } from "./chart.js";
import { pngOf, svgOf } from "./saved.js";
import { holds, inside, middleOf, nearest, nextPoint, sameView, scaledAbout, shifted } from "./view.js";

const REACH = 40;
// Where every place means something, a point is only named next to it.
const NEXT_TO = 12;
const CLICK_PIXELS = 4;
const FACTOR = 0.7;
const REST_MS = 350;
const MOST_STEPS = 30;
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const KEYS = "Arrows mark the next point, with Shift they move the view; plus and minus zoom; 0 shows the whole; Backspace steps back; Enter";

/**
 * What a chart shows. `id`: scenes of the same are newer states of each other. `points` can be pointed at, and `words`
 * says what one is. `key` names the signs that are in a view.
 * @typedef {object} Scene
 * @property {string} id
 * @property {import("./view.js").ChartView} whole
 * @property {string} title
 * @property {string} file name of its files
 * @property {string} xLabel
 * @property {string} yLabel
 * @property {any[]} points each with x and y
 * @property {(point: any, view: import("./view.js").ChartView) => string} words
 * @property {(chart: Chart) => void} draw
 * @property {() => any[][]} table
 * @property {(view: import("./view.js").ChartView) => {sign: SVGElement, name: string}[]} key
 * @property {(place: {x: number, y: number}, view: import("./view.js").ChartView) => string} [place] says what is at a
 *   place without a point
 */

function button(text, title, press) {
  const made = Object.assign(document.createElement("button"), { type: "button", textContent: text, title });
  made.addEventListener("click", press);
  return made;
}

/** Midpoint and distance of two fingers. */
function pairOf(pointers) {
  const [one, other] = [...pointers.values()];
  return {
    at: { clientX: (one.clientX + other.clientX) / 2, clientY: (one.clientY + other.clientY) / 2 },
    apart: Math.max(Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY), 1),
  };
}

export class Instrument {
  /**
   * @param {HTMLElement} place
   * @param {{label: string, act: string, does: string, walks?: string}} words what it is; the button that does with a
   *   point what a click does; that as the end of a sentence on keys; what a pointer does that moves over it
   * @param {object} tell
   * @param {(view: import("./view.js").ChartView) => void} tell.moved another view is seen, after a rest
   * @param {(place: {x: number, y: number}, point: any|null, at: {x: number, y: number}) => void} tell.picked a place,
   *   that of the point there if there is one; this point; and where the pointer was
   * @param {(place: {x: number, y: number}) => void} [tell.walked] the pointer moves over a place: then a drag is no box
   * @param {() => void} [tell.left] it is over none any more
   * @param {(() => void)} [tell.closed] it shall be seen no more
   */
  constructor(place, words, tell) {
    this.words = words;
    this.tell = tell;
    /** @type {Scene|null} */
    this.scene = null;
    /** @type {import("./view.js").ChartView|null} */
    this.view = null;
    /** What was seen before. @type {{scene: Scene, view: import("./view.js").ChartView}[]} */
    this.steps = [];
    this.marked = null;
    this.pointers = new Map();
    this.drag = this.pinch = null;
    this.rest = this.soon = 0;
    this.stage = Object.assign(document.createElement("div"), { className: "stage", tabIndex: 0 });
    this.stage.setAttribute("role", "application");
    this.stage.setAttribute("aria-label", `${words.label}. ${KEYS} ${words.does}.${words.walks ? ` ${words.walks}.` : ""}`);
    this.stage.classList.toggle("walked", Boolean(words.walks));
    this.reading = Object.assign(document.createElement("output"), { className: "reading" });
    this.reading.setAttribute("aria-live", "polite");
    place.replaceChildren(this.stage, this.reading, this.#tools());
    this.#listen();
    new ResizeObserver(() => this.draw()).observe(this.stage);
  }

  #tools() {
    this.act = button(this.words.act, "", () => this.#pick());
    this.back = button("← Step back", "what was seen before in this chart (Backspace)", () => this.stepBack());
    const zooms = [
      button("−", "zoom out (−)", () => this.#zoom(1 / FACTOR)), button("+", "zoom in (+)", () => this.#zoom(FACTOR)),
      button("Whole", "all of this chart (0)", () => this.#whole()),
    ];
    zooms[0].setAttribute("aria-label", "zoom out of the chart");
    zooms[1].setAttribute("aria-label", "zoom into the chart");
    const svg = () => svgOf(this.chart.svg, this.scene.title, this.scene.key(this.view));
    const files = { SVG: async () => new Blob([svg()], { type: "image/svg+xml" }), PNG: () => pngOf(svg()), CSV: async () => asCsv(this.scene.table()) };
    const saves = Object.entries(files).map(([ending, get]) => button(ending, `save this chart as ${ending}`, () =>
      attempt(async () => saveBlob(await get(), `${this.scene.file}.${ending.toLowerCase()}`))));
    const tools = Object.assign(document.createElement("p"), { className: "tools" });
    tools.append(this.back, ...zooms, this.act, ...saves);
    if (this.tell.closed) tools.append(button("Close", "", () => this.tell.closed()));
    return tools;
  }

  /**
   * Show a scene. Of the same as before the view stays, unless it was the whole.
   * @param {Scene} scene
   * @param {import("./view.js").ChartView|null} [view]
   */
  show(scene, view = null) {
    const same = this.scene?.id === scene.id;
    const zoomed = same && !sameView(this.view, this.scene.whole);
    this.steps = this.steps.map((step) => (step.scene.id === scene.id ? { ...step, scene } : step));
    this.view = inside(view ?? (zoomed ? this.view : scene.whole), scene.whole);
    this.scene = scene;
    if (!same) this.#unmark();
    this.draw();
  }

  /** Show another view of the scene, as an address has it, without an event. */
  look(view) {
    clearTimeout(this.rest);
    this.rest = 0;
    this.view = inside(view ?? this.scene.whole, this.scene.whole);
    this.draw();
  }

  /** Forget all. */
  clear() {
    clearTimeout(this.rest);
    [this.scene, this.view, this.steps, this.rest] = [null, null, [], 0];
    this.#unmark();
    this.stage.replaceChildren();
  }

  /** Whether only a part of what there is to see is seen. */
  get zoomed() {
    return this.scene !== null && !sameView(this.view, this.scene.whole);
  }

  /** Draw with the next frame. */
  draw() {
    this.soon ||= requestAnimationFrame(() => {
      this.soon = 0;
      if (this.scene && this.stage.clientWidth) this.#draw();
    });
  }

  #draw() {
    const { scene, view } = this;
    const { xLabel, yLabel } = scene;
    const chart = (this.chart = new Chart(this.stage, { height: this.stage.clientHeight, ...view, xLabel, yLabel, label: scene.title, cut: true }));
    chart.add("rect", { class: "target", ...chart.frame });
    scene.draw(chart);
    this.mark = chart.add("circle", { class: "mark", r: 7, visibility: "hidden" });
    this.box = chart.add("rect", { class: "box", visibility: "hidden" });
    this.#showMark();
    this.back.disabled = this.steps.length === 0;
  }

  #showMark() {
    const { marked, chart } = this;
    this.act.disabled = !marked;
    if (!chart) return;
    this.mark.setAttribute("visibility", marked ? "visible" : "hidden");
    if (!marked) return;
    this.mark.setAttribute("cx", String(chart.x(marked.x)));
    this.mark.setAttribute("cy", String(chart.y(marked.y)));
  }

  #point(point) {
    if (point === this.marked || !point) return;
    this.marked = point;
    this.reading.textContent = this.scene.words(point, this.view);
    this.#showMark();
  }

  #unmark() {
    this.marked = null;
    this.reading.textContent = "";
    this.#showMark();
  }

  // Moving.

  #go(view, scene = this.scene) {
    const next = inside(view, scene.whole);
    if (scene === this.scene && sameView(next, this.view)) return;
    // Many notches of a wheel are one step.
    if (!this.rest) this.steps = [...this.steps.slice(1 - MOST_STEPS), { scene: this.scene, view: this.view }];
    this.#see(scene, next);
  }

  #see(scene, view) {
    if (scene.id !== this.scene.id) this.#unmark();
    [this.scene, this.view] = [scene, view];
    this.draw();
    clearTimeout(this.rest);
    this.rest = setTimeout(() => {
      this.rest = 0;
      this.tell.moved(this.view);
    }, REST_MS);
  }

  /** Show what was seen before. */
  stepBack() {
    const step = this.steps.at(-1);
    if (!step) return;
    this.steps = this.steps.slice(0, -1);
    this.#see(step.scene, step.view);
  }

  /** Show the whole of what came first. */
  #whole() {
    if (!this.scene) return;
    const { scene } = this.steps[0] ?? this;
    this.#go(scene.whole, scene);
  }

  #zoom(factor, about = this.marked ?? (this.view && middleOf(this.view))) {
    if (this.scene) this.#go(scaledAbout(this.view, about, factor));
  }

  #pick() {
    if (this.marked) this.tell.picked(this.marked, this.marked, this.marked);
  }

  // Pointer, wheel and keys.

  #listen() {
    const { stage } = this;
    stage.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    stage.addEventListener("pointerdown", (event) => this.#press(event));
    stage.addEventListener("pointermove", (event) => this.#move(event));
    stage.addEventListener("pointerup", (event) => this.#release(event));
    stage.addEventListener("pointercancel", (event) => this.#drop(event));
    stage.addEventListener("pointerleave", () => this.pointers.size || this.tell.left?.());
    stage.addEventListener("keydown", (event) => this.#key(event));
  }

  #nearestTo(event) {
    return nearest(this.scene.points, this.chart.placeAt(event), this.view, this.chart.unit, this.tell.walked ? NEXT_TO : REACH);
  }

  /** A pointer passes over a place. */
  #pass(event) {
    const point = this.#nearestTo(event);
    this.#point(point);
    if (!this.tell.walked) return;
    const place = this.chart.placeAt(event);
    if (!holds(this.view, place)) return this.tell.left();
    if (!point) this.#unmark();
    if (!point) this.reading.textContent = this.scene.place(place, this.view);
    this.tell.walked(place);
  }

  /** Without Ctrl, which two fingers on a pad have as well, the wheel scrolls the page. */
  #wheel(event) {
    if (!event.ctrlKey || !this.chart) return;
    event.preventDefault();
    this.#zoom(Math.exp(Math.min(Math.max(event.deltaY, -200), 200) / 350), this.chart.placeAt(event));
  }

  #press(event) {
    if (event.button !== 0 || !this.scene) return;
    this.stage.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, event);
    if (this.pointers.size === 2) {
      this.drag = null;
      this.pinch = { ...pairOf(this.pointers), view: this.view, fixed: this.chart.placeAt(pairOf(this.pointers).at) };
    } else {
      this.drag = { from: event, moved: false };
    }
  }

  #move(event) {
    if (!this.scene || !this.chart) return;
    if (!this.pointers.has(event.pointerId)) return this.#pass(event);
    this.pointers.set(event.pointerId, event);
    if (this.pinch && this.pointers.size === 2) {
      const { apart, view, fixed } = this.pinch;
      this.#go(scaledAbout(view, fixed, apart / pairOf(this.pointers).apart));
    } else if (this.drag) this.#pull(event);
  }

  #pull(event) {
    const { from } = this.drag;
    this.drag.moved ||= Math.hypot(event.clientX - from.clientX, event.clientY - from.clientY) > CLICK_PIXELS;
    if (!this.drag.moved) return;
    if (!this.#isBox) return this.#pass(event);
    const { x, y } = this.#boxTo(event);
    const [left, top] = [this.chart.x(x[0]), this.chart.y(y[1])];
    const drawn = { x: left, y: top, width: this.chart.x(x[1]) - left, height: this.chart.y(y[0]) - top, visibility: "visible" };
    for (const [name, value] of Object.entries(drawn)) this.box.setAttribute(name, String(value));
  }

  /** Whether what is dragged is a box. */
  get #isBox() {
    return !this.tell.walked || this.drag.from.shiftKey;
  }

  /** The box from where the pointer was pressed. One that is flat in a direction leaves that as it is. */
  #boxTo(event) {
    const [a, b] = [this.chart.placeAt(this.drag.from), this.chart.placeAt(event)];
    const along = (name, pixels, /** @type {number[]} */ [least, most]) => {
      if (pixels < 2 * CLICK_PIXELS) return [least, most];
      return [Math.max(Math.min(a[name], b[name]), least), Math.min(Math.max(a[name], b[name]), most)];
    };
    const { from } = this.drag;
    return {
      x: along("x", Math.abs(event.clientX - from.clientX), this.view.x),
      y: along("y", Math.abs(event.clientY - from.clientY), this.view.y),
    };
  }

  #release(event) {
    const { drag } = this;
    const touch = event.pointerType === "touch";
    if (drag?.moved && this.#isBox) this.#go(this.#boxTo(event));
    else if (drag?.moved && touch) this.tell.left();
    this.#drop(event);
    if (!drag || drag.moved) return;
    const point = this.#nearestTo(event);
    // A finger cannot point: its first tap does.
    if (touch && point !== this.marked && !this.tell.walked) return this.#point(point);
    this.#point(point);
    const at = this.chart.placeAt(event);
    this.tell.picked(point ?? at, point, at);
  }

  #drop(event) {
    this.pointers.delete(event.pointerId);
    if (this.pointers.size < 2) this.pinch = null;
    this.drag = null;
    this.box?.setAttribute("visibility", "hidden");
  }

  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || !this.scene) return;
    const way = ARROWS[event.key];
    if (way && event.shiftKey) this.#go(shifted(this.view, way[0] / 8, way[1] / 8));
    else if (way) this.#point(nextPoint(this.scene.points, this.marked ?? middleOf(this.view), way, this.view));
    else if (event.key === "+" || event.key === "=") this.#zoom(FACTOR);
    else if (event.key === "-") this.#zoom(1 / FACTOR);
    else if (event.key === "0") this.#whole();
    else if (event.key === "Backspace") this.stepBack();
    else if (event.key === "Enter") this.#pick();
    else if (event.key === "Escape") this.#unmark();
    else return;
    event.preventDefault();
  }
}
