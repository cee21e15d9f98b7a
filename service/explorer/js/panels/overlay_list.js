/** The list of overlays: turns them on and off, and fetches those that the service has to compute. */

import { get } from "../net/api.js";
import { element } from "../charts/chart.js";
import { MARKS } from "../look/explain.js";
import { addMasks, OVERLAYS } from "../plane/overlays.js";

function signOf({ d, stroke }) {
  const sign = element("svg", { viewBox: "0 0 26 16", "aria-hidden": "true" });
  sign.append(element("rect", { width: 26, height: 16, rx: 3, fill: "#48505c" }));
  sign.append(element("path", { d, stroke, "stroke-width": 2, fill: "none", "stroke-linecap": "round" }));
  return sign;
}

function key({ label, colour, marker }) {
  const line = document.createElement("span");
  line.className = "key";
  line.append(signOf({ d: marker === null ? "M1 12 C9 1 17 1 25 12" : "M13 2V14 M7 8H19", stroke: colour }), label);
  return line;
}

export class OverlayList {
  /**
   * @param {HTMLElement} place
   * @param {import("../plane/plane.js").Plane} plane
   * @param {() => void} changed called when other overlays are on
   */
  constructor(place, plane, changed) {
    this.plane = plane;
    this.source = null;
    this.boxes = new Map();
    /** Names of those that what is seen does not have. */
    this.lacking = new Set();
    this.place = place;
    this.changed = changed;
  }

  /** List all overlays, with the masks that the service knows. @param {Mask[]} masks */
  list(masks) {
    addMasks(masks);
    const notes = { ...MARKS, ...Object.fromEntries(masks.map(({ name, note }) => [name, note])) };
    for (const overlay of OVERLAYS) {
      const line = document.createElement("label");
      line.title = notes[overlay.name];
      const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: overlay.on });
      this.boxes.set(overlay.name, box);
      overlay.note = Object.assign(document.createElement("p"), { className: "note" });
      overlay.note.setAttribute("role", "status");
      box.addEventListener("change", () => {
        this.#turn(overlay, box.checked);
        this.changed();
      });
      line.append(box, signOf(overlay.sign), overlay.label);
      this.place.append(line, overlay.note);
    }
    for (const { name } of masks) this.offer(name, false);
    this.#show();
  }

  /** Names of the overlays that are on. */
  get names() {
    return OVERLAYS.filter(({ on }) => on).map(({ name }) => name);
  }

  /** Names of those that are drawn: some come later, and some models lack some. */
  get drawn() {
    return OVERLAYS.filter(({ name, on, fetched }) => on && fetched?.length !== 0 && !this.lacking.has(name)).map(({ name }) => name);
  }

  /** Offer an overlay, or not where what is seen does not have it. */
  offer(name, there) {
    if (there) this.lacking.delete(name);
    else this.lacking.add(name);
    this.boxes.get(name).parentElement.hidden = !there;
  }

  /** Turn on the overlays of these names, and no others. */
  choose(names) {
    for (const overlay of OVERLAYS) {
      const on = names.includes(overlay.name);
      this.boxes.get(overlay.name).checked = on;
      if (on !== overlay.on) this.#turn(overlay, on);
    }
  }

  #turn(overlay, on) {
    overlay.on = on;
    overlay.note.textContent = on && overlay.fetched && !this.source ? "comes with a computed basin" : "";
    this.#fetch(overlay);
    this.#show();
  }

  #show() {
    this.plane.overlays = OVERLAYS.filter(({ on }) => on);
    this.plane.draw();
  }

  /** Forget what was computed for another oscillator. */
  forget() {
    this.source = null;
    for (const overlay of OVERLAYS) {
      overlay.note.textContent = "";
      overlay.asked = null;
      if (overlay.fetched) overlay.fetched = [];
    }
  }

  /**
   * Set the basin that overlays are computed for: the first one of an oscillator, at any zoom.
   * @param {string} job
   * @param {number} panel
   * @param {boolean} ready whether its motions are known
   */
  of(job, panel, ready) {
    if (this.source || !ready) return;
    this.source = { job, panel };
    OVERLAYS.forEach((overlay) => this.#fetch(overlay));
  }

  async #fetch(overlay) {
    const { source } = this;
    if (!overlay.fetched || !overlay.on || !source || overlay.asked === source) return;
    overlay.asked = source;
    overlay.note.textContent = "computing\u2026";
    try {
      const { overlays } = await get(`/v1/jobs/${source.job}/overlays/${overlay.name}?panel=${source.panel}`);
      if (this.source !== source) return;
      overlay.fetched = overlays;
      overlay.note.replaceChildren(...(overlays.length ? overlays.map(key) : ["there are none"]));
    } catch (error) {
      if (this.source !== source) return;
      overlay.asked = null;
      overlay.note.textContent = error.message;
    }
    this.#show();
  }
}
