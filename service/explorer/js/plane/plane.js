/** The plane of departures: pictures of basins, one over the other, with panning, zooming and picking. */

import { hatchMissing } from "./hatching.js";
import { drawCrossHair, drawMotion, drawOverlay } from "./overlays.js";
import { Plot } from "./plot.js";
import { colour } from "../page/theme.js";

// Largest number of pictures. Older ones stay underneath until a new one has arrived.
const MOST_PICTURES = 8;
const SMALLEST = 1e-9;
const CLICK_PIXELS = 4;

/** A window that the service accepts: at most a period wide, starting at a phase, without negative speeds. */
export function within(view) {
  const width = Math.min(Math.max(view.t1 - view.t0, SMALLEST), 1);
  let t0 = view.t0 + (view.t1 - view.t0 - width) / 2;
  t0 -= Math.floor(t0);
  const height = Math.max(view.v1 - view.v0, SMALLEST);
  const v0 = Math.max(view.v0, 0);
  return { t0, t1: t0 + width, v0, v1: v0 + height };
}

function scaled(view, { t, v }, factor) {
  return {
    t0: t + (view.t0 - t) * factor, t1: t + (view.t1 - t) * factor,
    v0: v + (view.v0 - v) * factor, v1: v + (view.v1 - v) * factor,
  };
}

export class Plane {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {{moved: (view: object) => void, hovered: (place: object|null) => void, picked: (place: object, second: boolean) => void}} tell
   */
  constructor(canvas, tell) {
    this.canvas = canvas;
    this.tell = tell;
    this.view = { t0: 0, t1: 1, v0: 0, v1: 7 };
    this.look = { layer: "solution", palette: "paper", highlight: null, ground: "#ffffff" };
    this.pictures = [];
    this.overlays = [];
    this.motions = new Map();
    this.crossHair = null;
    this.boxing = false;
    this.pointers = null;
    this.waiting = false;
    new ResizeObserver(() => this.draw()).observe(canvas);
    canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    canvas.addEventListener("pointerdown", (event) => this.#press(event));
    canvas.addEventListener("pointermove", (event) => this.#move(event));
    canvas.addEventListener("pointerup", (event) => this.#release(event));
    canvas.addEventListener("pointercancel", () => (this.pointers = null, this.draw()));
    canvas.addEventListener("pointerleave", () => this.tell.hovered(null));
    canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  /** The picture on top. */
  get picture() {
    return this.pictures.at(-1) ?? null;
  }

  /** Put a picture on top. Pictures without cells, and the oldest, are removed. */
  show(picture) {
    this.pictures = this.pictures.filter((older) => !older.empty).slice(1 - MOST_PICTURES);
    this.pictures.push(picture);
    this.draw();
  }

  /** Remove all pictures, before another oscillator. */
  clear() {
    this.pictures = [];
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
    for (const picture of this.pictures) picture.paint(this.look);
    this.draw();
  }

  /** What is known at a point, from the newest picture that has it. */
  at(t, v) {
    for (const picture of this.pictures.toReversed()) {
      const known = picture.at(t, v);
      if (known) return known;
    }
    return null;
  }

  /** Move to another window, without an event. */
  lookAt(view) {
    this.view = view;
    this.draw();
  }

  /** Move to another window, with an event. */
  go(view) {
    this.view = within(view);
    this.draw();
    this.tell.moved(this.view);
  }

  /** Zoom about the centre; a factor below 1 zooms in. */
  zoom(factor) {
    const { t0, t1, v0, v1 } = this.view;
    this.go(scaled(this.view, { t: (t0 + t1) / 2, v: (v0 + v1) / 2 }, factor));
  }

  /** Draw at the next frame. */
  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.#draw();
    });
  }

  #draw() {
    if (!this.canvas.clientWidth) return;
    const plot = (this.plot = new Plot(this.canvas, this.view));
    plot.clear();
    const top = this.picture;
    plot.clipped(() => {
      for (const picture of this.pictures) picture.draw(plot);
      if (top) hatchMissing(plot, top);
      if (top) for (const overlay of this.overlays) drawOverlay(plot, overlay, top);
      for (const [name, departures] of this.motions) drawMotion(plot, departures.map((each) => this.#inView(each)), name);
      if (this.crossHair) drawCrossHair(plot, this.crossHair);
      if (this.pointers?.box) this.#drawBox(plot);
    });
    plot.axes();
  }

  /** The same departure, in the visible period. */
  #inView({ t, v }) {
    const { t0 } = this.view;
    return { t: t - Math.floor(t - t0), v };
  }

  #drawBox({ context }) {
    const { from, to } = this.pointers;
    context.strokeStyle = colour("accent");
    context.lineWidth = 1.5;
    context.fillStyle = "rgb(127 180 255 / 18%)";
    const rectangle = [from.x, from.y, to.x - from.x, to.y - from.y];
    context.fillRect(...rectangle);
    context.strokeRect(...rectangle);
  }

  #wheel(event) {
    if (!this.plot?.contains(event.offsetX, event.offsetY)) return;
    event.preventDefault();
    const factor = Math.exp(Math.min(Math.max(event.deltaY, -200), 200) / 350);
    this.go(scaled(this.view, this.plot.point(event.offsetX, event.offsetY), factor));
  }

  #press(event) {
    if (event.button !== 0 || !this.plot?.contains(event.offsetX, event.offsetY)) return;
    this.canvas.setPointerCapture(event.pointerId);
    const from = { x: event.offsetX, y: event.offsetY };
    this.pointers = { from, to: from, view: this.view, moved: false, box: false, boxing: this.boxing || event.shiftKey };
  }

  #move(event) {
    const to = { x: event.offsetX, y: event.offsetY };
    if (!this.pointers) {
      this.tell.hovered(this.plot?.contains(to.x, to.y) ? this.plot.point(to.x, to.y) : null);
      return;
    }
    const { from, view, boxing } = this.pointers;
    this.pointers.to = to;
    this.pointers.moved ||= Math.hypot(to.x - from.x, to.y - from.y) > CLICK_PIXELS;
    if (!this.pointers.moved) return;
    if (boxing) {
      this.pointers.box = true;
    } else {
      this.canvas.classList.add("panning");
      const dt = ((to.x - from.x) / this.plot.width) * (view.t1 - view.t0);
      const dv = ((to.y - from.y) / this.plot.height) * (view.v1 - view.v0);
      this.view = within({ t0: view.t0 - dt, t1: view.t1 - dt, v0: view.v0 + dv, v1: view.v1 + dv });
    }
    this.draw();
  }

  #release(event) {
    if (!this.pointers) return;
    const { from, to, moved, box } = this.pointers;
    this.pointers = null;
    this.canvas.classList.remove("panning");
    if (box) {
      const [a, b] = [this.plot.point(from.x, from.y), this.plot.point(to.x, to.y)];
      const order = (p, q) => [Math.min(p, q), Math.max(p, q)];
      const [t0, t1] = order(a.t, b.t), [v0, v1] = order(a.v, b.v);
      this.go({ t0, t1, v0, v1 });
    } else if (moved) {
      this.go(this.view);
    } else {
      this.tell.picked(this.plot.point(from.x, from.y), event.shiftKey);
    }
  }

  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { t0, t1, v0, v1 } = this.view;
    const along = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (along && event.shiftKey) {
      const [dt, dv] = [((t1 - t0) / 8) * along[0], ((v1 - v0) / 8) * along[1]];
      this.go({ t0: t0 + dt, t1: t1 + dt, v0: v0 + dv, v1: v1 + dv });
    } else if (along) {
      this.#moveCrossHair(along);
    } else if (event.key === "+" || event.key === "=") this.zoom(0.7);
    else if (event.key === "-") this.zoom(1 / 0.7);
    else if (event.key === "0") this.tell.whole();
    else if (event.key === "Enter" && this.crossHair) this.tell.picked(this.crossHair, false);
    else if (event.key === "b" && this.crossHair) this.tell.picked(this.crossHair, true);
    else if (event.key === "Escape") this.crossHair = null;
    else return;
    event.preventDefault();
    this.draw();
  }

  #moveCrossHair([across, up]) {
    const { t0, t1, v0, v1 } = this.view;
    const at = this.crossHair ?? { t: (t0 + t1) / 2, v: (v0 + v1) / 2 };
    const clamp = (value, least, most) => Math.min(Math.max(value, least), most);
    this.crossHair = { t: clamp(at.t + (across * (t1 - t0)) / 100, t0, t1), v: clamp(at.v + (up * (v1 - v0)) / 100, v0, v1) };
    this.tell.hovered(this.crossHair);
  }
}
