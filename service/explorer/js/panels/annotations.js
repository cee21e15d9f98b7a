/** Pins points with labels on the plane and draws lines, by pointer and keys. */

import { measureInWords, withOne } from "../state/annotations.js";
import { annotationAt } from "../plane/annotations.js";

export class Annotations {
  /**
   * @param {{button: HTMLElement, box: HTMLElement}} parts its switch, and the box with the label of a point or a line
   * @param {import("../plane/plane.js").Plane} plane
   * @param {() => void} changed
   */
  constructor({ button, box }, plane, changed) {
    this.plane = plane;
    this.changed = changed;
    this.button = button;
    this.box = box;
    this.input = /** @type {HTMLInputElement} */ (box.querySelector("input"));
    /** The end of a distance that is measured with keys. @type {Departure|null} */
    this.from = null;
    /** What the box is about. @type {{note?: import("../state/annotations.js").Note, measure?: import("../state/annotations.js").Measure}|null} */
    this.open = null;
    button.addEventListener("click", () => this.#turn(!plane.annotating));
    // After a tap the browser would give the plane the focus, and so take it from the label.
    for (const { canvas } of plane.panes) canvas.addEventListener("mousedown", (event) => plane.annotating && event.preventDefault());
    box.querySelector("button").addEventListener("click", () => this.#remove(this.open));
    this.input.addEventListener("input", () => {
      (this.open.note ?? this.open.measure).label = this.input.value;
      this.#tell();
    });
    box.addEventListener("keydown", (event) => {
      if (!["Enter", "Escape"].includes(event.key) || event.target !== this.input) return;
      event.stopPropagation();
      this.close();
      plane.panes[0].canvas.focus();
    });
    box.addEventListener("focusout", (event) => !box.contains(/** @type {Node} */ (event.relatedTarget)) && this.close());
  }

  /** Show those of an address. @param {import("../state/annotations.js").Annotated} annotated */
  show(annotated) {
    this.close();
    this.plane.annotated = annotated;
    this.plane.draw();
  }

  /** A click in this mode: what is there is opened, else a point is pinned. @param {Departure} place */
  pin(place) {
    const { plot } = this.plane.panes[0];
    const there = plot && annotationAt(plot, this.plane.annotated, plot.x(place.t), plot.y(place.v));
    if (there) return this.#edit(there);
    const note = { t: place.t - Math.floor(place.t), v: place.v, label: "" };
    this.plane.annotated = { ...this.plane.annotated, notes: withOne(this.plane.annotated.notes, note) };
    this.#tell();
    if (this.plane.annotated.notes.includes(note)) this.#edit({ note });
  }

  /** A distance from one place to another. @param {Departure} from @param {Departure} to */
  measure(from, to) {
    this.close();
    const turn = Math.floor(from.t);
    const measure = { t0: from.t - turn, v0: from.v, t1: to.t - turn, v1: to.v, label: null };
    this.plane.annotated = { ...this.plane.annotated, measures: withOne(this.plane.annotated.measures, measure) };
    this.#tell();
  }

  /** One end of a distance at the cross-hair, then the other. @param {Departure} place */
  end(place) {
    if (this.from) this.measure(this.from, place);
    this.from = this.from ? null : { ...place };
  }

  /** Remove what is nearest to the cross-hair. @param {Departure} place */
  drop(place) {
    const { plot } = this.plane.panes[0];
    const nearest = plot && annotationAt(plot, this.plane.annotated, plot.x(place.t), plot.y(place.v), Infinity);
    if (nearest) this.#remove(nearest);
  }

  close() {
    this.open = null;
    this.box.hidden = true;
  }

  #turn(on) {
    this.plane.annotating = on;
    this.button.setAttribute("aria-pressed", String(on));
    for (const { canvas } of this.plane.panes) canvas.classList.toggle("annotating", on);
    this.close();
  }

  #remove(which) {
    const { notes, measures } = this.plane.annotated;
    this.plane.annotated = { notes: notes.filter((note) => note !== which.note), measures: measures.filter((measure) => measure !== which.measure) };
    this.close();
    this.#tell();
    this.plane.panes[0].canvas.focus();
  }

  #edit(which) {
    const { plot } = this.plane.panes[0];
    const { note, measure } = which;
    this.open = which;
    this.box.hidden = false;
    this.input.value = note ? note.label : measureInWords(measure);
    this.input.setAttribute("aria-label", note ? "label of the point" : "label of the line: empty for a plain line");
    const { t, v } = this.plane.inView(note ? note : { t: (measure.t0 + measure.t1) / 2, v: (measure.v0 + measure.v1) / 2 });
    this.box.style.left = `${Math.max(0, Math.min(plot.x(t), plot.size.width - this.box.offsetWidth))}px`;
    this.box.style.top = `${Math.max(0, Math.min(plot.y(v) + 12, plot.size.height - this.box.offsetHeight))}px`;
    this.input.focus();
    this.input.select();
  }

  #tell() {
    this.plane.draw();
    this.changed();
  }
}
