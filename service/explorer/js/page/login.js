/** The log-in: a field for a key, shown when the service requires one. */

import { by } from "./by.js";

const dialog = by("login");
const note = by("login-note");
const field = by("key");
const greeting = note.textContent;
let asking = null;

/** Ask for a key. Requests that need one at the same time share one prompt. */
export function askForKey(wrong) {
  note.textContent = wrong ? `${wrong}. ${greeting}` : greeting;
  asking ??= new Promise((resolve) => {
    dialog.addEventListener("cancel", (event) => event.preventDefault());
    dialog.addEventListener("close", () => {
      asking = null;
      const key = field.value.trim();
      field.value = "";
      resolve(key);
    }, { once: true });
    dialog.showModal();
  });
  return asking;
}
