/** Colours of a legend. */

import { element } from "../charts/chart.js";
import { inkOn } from "../plane/palette.js";

// Stripes up, as on the plane, where speeds increase upwards; stripes down; dots.
export const TEXTURES = ["", "M15 9L9 15 M15 1L1 15 M7 1L1 7", "M1 9L7 15 M1 1L15 15 M9 1L15 7", "M4 4h.1 M12 4h.1 M8 8h.1 M4 12h.1 M12 12h.1"];

/** A colour; hatched for what a mask marks; with the texture that marks its cells. */
export function swatch(colour, hatched = false, texture = 0) {
  const drawn = element("svg", { class: "swatch", viewBox: "0 0 16 16", "aria-hidden": "true" });
  drawn.append(element("rect", { width: 16, height: 16, rx: 3, fill: colour, stroke: "rgb(128 128 128)" }));
  if (hatched) drawn.append(element("path", { d: "M1 9L7 15 M1 1L15 15 M9 1L15 7", stroke: "#282828", "stroke-width": 1 }));
  if (texture) drawn.append(element("path", { d: TEXTURES[texture], stroke: inkOn(colour), "stroke-width": texture === 3 ? 2.4 : 1.4, "stroke-linecap": "round" }));
  return drawn;
}
