/** The list of overlays: turns them on and off, and fetches those that the service has to compute. */

import { get } from "../net/api.js";
import { element } from "../charts/chart.js";
import { OVERLAYS } from "../plane/overlays.js";

function signOf({ d, stroke }) {
  const sign = element("svg", { viewBox: "0 0 26 16", "aria-hidden": "true" });
  sign.append(element("rect", { width: 26, height: 16, rx: 3, fill: "#48505c" }));
  sign.append(element("path", { d, stroke, "stroke-width": 2, fill: "none", "stroke-linecap": "round" }));
  return sign;
}

export class OverlayList {
  /** @param {HTMLElement} place @param {import("../plane/plane.js").Plane} plane */
  constructor(place, plane) {
    this.plane = plane;
    this.source = null;
    for (const overlay of OVERLAYS) {
      const line = document.createElement("label");
      const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: overlay.on });
      overlay.note = Object.assign(document.createElement("p"), { className: "note" });
      overlay.note.setAttribute("role", "status");
      box.addEventListener("change", () => {
        overlay.on = box.checked;
        if (!overlay.on) overlay.note.textContent = "";
        this.#fetch(overlay);
        this.#show();
      });
      line.append(box, signOf(overlay.sign), overlay.label);
      place.append(line, overlay.note);
    }
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
    let told = "";
    try {
      const { overlays } = await get(`/v1/jobs/${source.job}/overlays/${overlay.name}?panel=${source.panel}`);
      if (this.source !== source) return;
      overlay.fetched = overlays;
      told = overlays.length ? overlays.map(({ label }) => label).join(", ") : "there are none";
    } catch (error) {
      if (this.source !== source) return;
      overlay.asked = null;
      told = error.message;
    }
    overlay.note.textContent = told;
    this.#show();
  }
}
