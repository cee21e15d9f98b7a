/** An overview of keys and gestures, on the key “?”. */

import { KEYS } from "../plane/keys.js";

const ANYWHERE = [{ shown: "?", words: "this overview" }, { shown: "Esc", words: "close a menu, or what lies over the page" }];
const POINTER = [
  { shown: "click", words: "follow the motion from a point" },
  { shown: "Shift + click", words: "follow a second one" },
  { shown: "drag", words: "move the window" },
  { shown: "Shift + drag", words: "draw a box to zoom into" },
  { shown: "wheel, two fingers", words: "zoom" },
];

function table(title, rows) {
  const heading = Object.assign(document.createElement("h3"), { textContent: title });
  const list = document.createElement("dl");
  for (const { shown, words } of rows) {
    const name = document.createElement("dt");
    name.append(Object.assign(document.createElement("kbd"), { textContent: shown }));
    list.append(name, Object.assign(document.createElement("dd"), { textContent: words }));
  }
  return [heading, list];
}

/** Whether a key that is pressed there is a letter of a text. @param {EventTarget} target */
function isText(target) {
  return target instanceof HTMLElement && target.matches("input:not([type=range], [type=checkbox]), textarea, select");
}

/**
 * Set up the overview.
 * @param {HTMLDialogElement} dialog
 * @param {HTMLElement} place in it
 * @param {HTMLElement} button that opens it, too
 */
export function setUpOverview(dialog, place, button) {
  place.replaceChildren(...table("On the plane, once it has the focus", KEYS), ...table("Anywhere", ANYWHERE), ...table("With a pointer", POINTER));
  button.addEventListener("click", () => dialog.showModal());
  document.addEventListener("keydown", (event) => {
    if (event.key !== "?" || event.ctrlKey || event.metaKey || event.altKey || isText(event.target)) return;
    if (document.querySelector("dialog[open]")) return;
    event.preventDefault();
    dialog.showModal();
  });
}
