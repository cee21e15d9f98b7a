/** The status line. */

import { by } from "./by.js";

const line = by("state");

/** Show a message. */
export function say(text, wrong = false) {
  line.textContent = text;
  line.classList.toggle("wrong", wrong);
}

/** Message of an error, with a capital letter. */
export function inWords(error) {
  return `${error.message[0].toUpperCase()}${error.message.slice(1)}`;
}

/** Result of work that may fail. If it fails, show the error and return null. */
export async function attempt(work) {
  try {
    return await work();
  } catch (error) {
    if (error.name !== "AbortError") say(inWords(error), true);
    return null;
  }
}
