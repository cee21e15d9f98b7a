/** Words of the page that a reader may not know, each behind its “?”, and all of them in the menu. */

import { besides } from "./beside.js";

/** @type {Object<string, {word: string, means: string}>} */
export const TERMS = {
  departure: { word: "departure", means: "a tooth leaves +β into freeplay, at phase t (forcing periods) with speed v" },
  solution: { word: "P(m, n+, n−)", means: "a motion of m forcing periods with n+ contacts at +β and n− at −β" },
  grazing: { word: "grazing curve", means: "departures faster than v* reach −β" },
  k: { word: "iterations k", means: "cells are mapped by P^k, then put back on the grid" },
  group: { word: "group", means: "the cycle of cells that is reached" },
  power: { word: "impact power", means: "the sum of v_i²/2 over the impacts of a motion, divided by its m forcing periods" },
};

/**
 * Show the meaning of a word beside its “?”.
 * @param {HTMLElement} place a popover
 * @param {HTMLElement} mark
 */
function explain(place, mark) {
  const { word, means } = TERMS[mark.dataset.term];
  const name = Object.assign(document.createElement("b"), { textContent: word });
  place.replaceChildren(name, `: ${means}.`);
  place.showPopover();
  besides(place, mark.getBoundingClientRect());
}

/**
 * Set up the marks, and list all words.
 * @param {HTMLElement} place a popover
 * @param {HTMLElement} list
 */
export function setUpGlossary(place, list) {
  for (const mark of document.querySelectorAll("button.what")) {
    mark.setAttribute("aria-label", `What is ${TERMS[/** @type {HTMLElement} */ (mark).dataset.term].word}?`);
    mark.addEventListener("click", () => explain(place, /** @type {HTMLElement} */ (mark)));
  }
  list.replaceChildren(...Object.values(TERMS).flatMap(({ word, means }) => [
    Object.assign(document.createElement("dt"), { textContent: word }), Object.assign(document.createElement("dd"), { textContent: `${means}.` }),
  ]));
}
