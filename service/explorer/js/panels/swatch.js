/** Colours of a legend. */

import { element } from "../charts/chart.js";

/** A colour; hatched for what is not proven. */
export function swatch(colour, hatched = false) {
  const drawn = element("svg", { class: "swatch", viewBox: "0 0 16 16", "aria-hidden": "true" });
  drawn.append(element("rect", { width: 16, height: 16, rx: 3, fill: colour, stroke: "rgb(128 128 128)" }));
  if (hatched) drawn.append(element("path", { d: "M1 9L7 15 M1 1L15 15 M9 1L15 7", stroke: "#282828", "stroke-width": 1 }));
  return drawn;
}
