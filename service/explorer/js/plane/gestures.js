/** Pointer, wheel and keys on the plane: panning, zooming, boxes, pinches, picking. */

import { scaled, within } from "../state/window.js";
import { doneBy } from "./keys.js";

const CLICK_PIXELS = 4;

function ordered(p, q) {
  return [Math.min(p, q), Math.max(p, q)];
}

/** Midpoint and distance of two pointers. */
function pairOf(pointers) {
  const [one, other] = [...pointers.values()];
  return {
    x: (one.x + other.x) / 2, y: (one.y + other.y) / 2,
    apart: Math.max(Math.hypot(one.x - other.x, one.y - other.y), 1),
  };
}

export class Gestures {
  /**
   * @param {import("./plane.js").Plane} plane
   * @param {import("./pane.js").Pane} pane the canvas's own
   * @param {HTMLCanvasElement} canvas
   */
  constructor(plane, pane, canvas) {
    this.plane = plane;
    this.pane = pane;
    this.canvas = canvas;
    this.drag = null;
    this.pointers = new Map();
    canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    canvas.addEventListener("pointerdown", (event) => this.#press(event));
    canvas.addEventListener("pointermove", (event) => this.#move(event));
    canvas.addEventListener("pointerup", (event) => this.#release(event));
    canvas.addEventListener("pointercancel", (event) => this.#cancel(event));
    canvas.addEventListener("pointerleave", () => this.plane.tell.hovered(null));
    canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  /** Corners of the box that is being drawn, in pixels; null if there is none. */
  get box() {
    return this.drag?.box ? this.drag : null;
  }

  /** The line that is being drawn; null if there is none. */
  get line() {
    const { drag } = this;
    if (!drag?.line || !drag.moved) return null;
    const [a, b] = [drag.plot.point(drag.from.x, drag.from.y), drag.plot.point(drag.to.x, drag.to.y)];
    return { t0: a.t, v0: a.v, t1: b.t, v1: b.v, label: null };
  }

  /** Whether the window is being dragged. */
  get panning() {
    return this.drag !== null && this.drag.moved && !this.drag.box && !this.drag.line;
  }

  #wheel(event) {
    const { plot } = this.pane;
    if (!plot?.contains(event.offsetX, event.offsetY)) return;
    event.preventDefault();
    const factor = Math.exp(Math.min(Math.max(event.deltaY, -200), 200) / 350);
    this.plane.go(scaled(this.plane.view, plot.point(event.offsetX, event.offsetY), factor));
  }

  #press(event) {
    const at = { x: event.offsetX, y: event.offsetY };
    if (event.button !== 0 || !this.pane.plot?.contains(at.x, at.y)) return;
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, at);
    if (this.pointers.size === 2) {
      this.drag = null;
      this.pinch = { ...pairOf(this.pointers), view: this.plane.view, plot: this.pane.plot };
    } else {
      const boxing = this.plane.boxing || event.shiftKey;
      this.drag = { from: at, to: at, view: this.plane.view, plot: this.pane.plot, moved: false, box: false, boxing, line: this.plane.annotating && !event.shiftKey };
    }
  }

  #move(event) {
    const to = { x: event.offsetX, y: event.offsetY };
    if (!this.pointers.has(event.pointerId)) {
      const { pane } = this;
      this.plane.tell.hovered(pane.plot?.contains(to.x, to.y) ? pane.placeAt(to.x, to.y) : null);
      return;
    }
    this.pointers.set(event.pointerId, to);
    if (this.pinch && this.pointers.size === 2) this.#stretch();
    else if (this.drag) this.#pull(to);
  }

  #stretch() {
    const { view, plot, apart, x, y } = this.pinch;
    const now = pairOf(this.pointers);
    const fixed = plot.point(x, y);
    const zoomed = scaled(view, fixed, apart / now.apart);
    const dt = ((now.x - x) / plot.width) * (zoomed.t1 - zoomed.t0);
    const dv = ((now.y - y) / plot.height) * (zoomed.v1 - zoomed.v0);
    this.plane.slide({ t0: zoomed.t0 - dt, t1: zoomed.t1 - dt, v0: zoomed.v0 + dv, v1: zoomed.v1 + dv });
  }

  #pull(to) {
    const { from, view, plot, boxing, line } = this.drag;
    this.drag.to = to;
    this.drag.moved ||= Math.hypot(to.x - from.x, to.y - from.y) > CLICK_PIXELS;
    if (!this.drag.moved) return;
    if (line) {
      this.plane.draw();
      return;
    }
    if (boxing) {
      this.drag.box = true;
      this.plane.draw();
      return;
    }
    this.canvas.classList.add("panning");
    const dt = ((to.x - from.x) / plot.width) * (view.t1 - view.t0);
    const dv = ((to.y - from.y) / plot.height) * (view.v1 - view.v0);
    this.plane.slide({ t0: view.t0 - dt, t1: view.t1 - dt, v0: view.v0 + dv, v1: view.v1 + dv });
  }

  #release(event) {
    const { drag } = this;
    const pinched = this.pinch;
    const { line } = this;
    this.#cancel(event);
    if (pinched) {
      this.plane.go(this.plane.view);
    } else if (line) {
      this.plane.tell.annotated("measure", { t: line.t1, v: line.v1 }, { t: line.t0, v: line.v0 });
    } else if (drag?.box) {
      const [a, b] = [drag.plot.point(drag.from.x, drag.from.y), drag.plot.point(drag.to.x, drag.to.y)];
      const flat = Math.abs(drag.to.x - drag.from.x) < CLICK_PIXELS || Math.abs(drag.to.y - drag.from.y) < CLICK_PIXELS;
      const [t0, t1] = ordered(a.t, b.t), [v0, v1] = ordered(a.v, b.v);
      if (!flat) this.plane.go({ t0, t1, v0, v1 });
    } else if (drag?.moved) {
      this.plane.go(this.plane.view);
    } else if (drag?.line) {
      this.plane.tell.annotated("pin", drag.plot.point(drag.from.x, drag.from.y));
    } else if (drag) {
      this.plane.tell.picked(this.pane.place(drag.plot.point(drag.from.x, drag.from.y)), event.shiftKey);
    }
  }

  #cancel(event) {
    this.pointers.delete(event.pointerId);
    if (this.pointers.size < 2) this.pinch = null;
    this.drag = null;
    this.canvas.classList.remove("panning");
    this.plane.draw();
  }

  #key(event) {
    const done = doneBy(event);
    const { plane } = this;
    if (!done || ["pick", "second", "pin", "end", "unpin"].includes(done) && !plane.crossHair) return;
    const [across, up] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key] ?? [0, 0];
    const { t0, t1, v0, v1 } = plane.view;
    const [dt, dv] = [((t1 - t0) / 8) * across, ((v1 - v0) / 8) * up];
    /** @type {Object<string, () => void>} */
    const acts = {
      shift: () => plane.go({ t0: t0 + dt, t1: t1 + dt, v0: v0 + dv, v1: v1 + dv }),
      point: () => this.#moveCrossHair([across, up]),
      nearer: () => plane.zoom(0.7),
      farther: () => plane.zoom(1 / 0.7),
      whole: () => plane.tell.whole(),
      pick: () => plane.tell.picked(this.pane.place(plane.crossHair), false),
      second: () => plane.tell.picked(this.pane.place(plane.crossHair), true),
      pin: () => plane.tell.annotated("pin", plane.crossHair),
      end: () => plane.tell.annotated("end", plane.crossHair),
      unpin: () => plane.tell.annotated("unpin", plane.crossHair),
      drop: () => (plane.crossHair = null),
    };
    acts[done]();
    event.preventDefault();
    plane.draw();
  }

  #moveCrossHair([across, up]) {
    const { t0, t1, v0, v1 } = within(this.plane.view);
    const at = this.plane.crossHair ?? { t: (t0 + t1) / 2, v: (v0 + v1) / 2 };
    const clamp = (value, least, most) => Math.min(Math.max(value, least), most);
    this.plane.crossHair = { t: clamp(at.t + (across * (t1 - t0)) / 100, t0, t1), v: clamp(at.v + (up * (v1 - v0)) / 100, v0, v1) };
    this.plane.tell.hovered(this.pane.place(this.plane.crossHair));
  }
}
