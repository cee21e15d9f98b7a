/** The buttons around the plane, the menus and the drawer. */

import { by } from "./by.js";
import { entries } from "../state/entries.js";
import { setUpGlossary } from "../help/glossary.js";
import { setUpOverview } from "../help/overview.js";
import { Tour } from "../help/tour.js";
import { listRecent } from "./recent.js";
import { attempt } from "./say.js";

function toggle(button, attribute = "aria-pressed") {
  const on = button.getAttribute(attribute) !== "true";
  button.setAttribute(attribute, String(on));
  return on;
}

/** Menus close when something else is clicked, or with Escape. */
function setUpMenus() {
  const menus = [by("away"), by("display"), by("help")];
  document.addEventListener("click", (event) => {
    for (const menu of menus) if (!menu.contains(event.target)) menu.open = false;
  });
  document.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    const open = menus.find((menu) => menu.open);
    if (!open) return;
    open.open = false;
    open.querySelector("summary").focus();
  });
}

/** Let the window be moved, or not where there is none. */
export function enableTools(on) {
  for (const id of ["in", "out", "whole", "box", "annotate", "layer", "keep"]) by(id).disabled = !on;
}

/** Let Back and Forward be pressed where they lead somewhere. */
export function enableSteps() {
  by("back").disabled = !entries.hasEarlier;
  by("forward").disabled = !entries.hasLater;
}

function setUpHelp() {
  setUpGlossary(by("term"), by("words"));
  setUpOverview(by("keys"), by("keys-list"), by("keys-open"));
  const tour = new Tour(by("tour"), by("help").querySelector("summary"));
  by("tour-begin").addEventListener("click", () => {
    by("help").open = false;
    tour.start();
  });
}

/**
 * Set up the controls.
 * @param {object} page
 * @param {import("../plane/plane.js").Plane} page.plane
 * @param {import("../jobs/jobs.js").Jobs} page.jobs
 * @param {(look: object) => void} page.restyle
 * @param {(axes: string) => void} page.axes
 * @param {() => void} page.whole
 * @param {() => void} page.takeaway
 */
export function setUpControls({ plane, jobs, restyle, axes, whole, takeaway }) {
  by("cancel").addEventListener("click", () => jobs.cancel());
  by("back").addEventListener("click", () => entries.turn(-1));
  by("forward").addEventListener("click", () => entries.turn(1));
  by("in").addEventListener("click", () => plane.zoom(0.7));
  by("out").addEventListener("click", () => plane.zoom(1 / 0.7));
  by("whole").addEventListener("click", whole);
  by("box").addEventListener("click", () => (plane.boxing = toggle(by("box"))));
  by("layer").addEventListener("change", () => restyle({ layer: by("layer").value }));
  by("axes").addEventListener("change", () => axes(by("axes").value));
  by("palette").addEventListener("change", () => restyle({ palette: by("palette").value }));
  by("open-drawer").addEventListener("click", () => {
    by("ask").hidden = !toggle(by("open-drawer"), "aria-expanded");
    if (!by("ask").hidden) by("ask").querySelector("select, input").focus();
  });
  by("away").addEventListener("toggle", () => by("away").open && takeaway());
  by("recent").addEventListener("toggle", () => by("recent").open && attempt(() => listRecent(by("recent").querySelector("ul"))));
  setUpMenus();
  setUpHelp();
}
