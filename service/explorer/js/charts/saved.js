/** A chart as a picture that needs nothing else: its colours and fonts are in it, and its text stays text. */

import { colour } from "../page/theme.js";
import { element } from "./chart.js";

const SCALE = 2;
const ROW = 20;
const COLUMN = 330;
const ROOM = 12;
const STYLES = [
  "fill", "stroke", "stroke-width", "stroke-dasharray", "stroke-linecap", "opacity", "font-size", "font-family",
];
const DRAWN = ["path", "rect", "circle", "text"];
/** What belongs to the pointer, not to the picture. */
const OF_POINTER = ".target, .mark, .box, [visibility=hidden]";

/** A copy whose elements have what the style sheet says of them. @param {SVGElement} drawn */
function styled(drawn) {
  const copy = /** @type {SVGElement} */ (drawn.cloneNode(true));
  const originals = drawn.querySelectorAll("*");
  for (const [i, each] of copy.querySelectorAll("*").entries()) {
    const style = getComputedStyle(originals[i]);
    if (DRAWN.includes(each.nodeName)) for (const name of STYLES) each.setAttribute(name, style.getPropertyValue(name));
  }
  for (const each of copy.querySelectorAll(OF_POINTER)) each.remove();
  for (const each of copy.querySelectorAll("*")) each.removeAttribute("class");
  return copy;
}

/**
 * Text of an SVG file: the chart as it is drawn, its title above and the key of its signs below.
 * @param {SVGSVGElement} drawn
 * @param {string} title
 * @param {{sign: SVGElement, name: string}[]} key
 */
export function svgOf(drawn, title, key) {
  const { width, height } = drawn.viewBox.baseVal;
  const { fontFamily } = getComputedStyle(drawn);
  const across = Math.max(1, Math.floor((width - 2 * ROOM) / COLUMN));
  const all = height + ROW * (2 + Math.ceil(key.length / across));
  const svg = element("svg", { xmlns: "http://www.w3.org/2000/svg", width, height: all, viewBox: `0 0 ${width} ${all}` });
  const text = { fill: colour("ink"), "font-family": fontFamily };
  const chart = styled(drawn);
  for (const [name, value] of Object.entries({ x: 0, y: ROW * 1.5, width, height })) chart.setAttribute(name, String(value));
  svg.append(element("rect", { width, height: all, fill: colour("paper") }));
  svg.append(element("text", { x: ROOM, y: ROW, "font-size": "13px", ...text }, title), chart);
  for (const [i, { sign, name }] of key.entries()) {
    const [x, y] = [ROOM + COLUMN * (i % across), height + ROW * (1.7 + Math.floor(i / across))];
    const own = /** @type {SVGElement} */ (sign.cloneNode(true));
    own.removeAttribute("class");
    for (const [part, value] of Object.entries({ x, y, width: 12, height: 12 })) own.setAttribute(part, String(value));
    svg.append(own, element("text", { x: x + 18, y: y + 10, "font-size": "12px", ...text }, name));
  }
  return new XMLSerializer().serializeToString(svg);
}

/** A picture of an SVG file. @param {string} svg @returns {Promise<Blob>} */
export async function pngOf(svg) {
  const address = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
  const image = new Image();
  image.src = address;
  await image.decode();
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [SCALE * image.naturalWidth, SCALE * image.naturalHeight];
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  URL.revokeObjectURL(address);
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}
