/** The status line. */

const line = document.getElementById("state");

/** Say something. */
export function say(text, wrong = false) {
  line.textContent = text;
  line.classList.toggle("wrong", wrong);
}

/** What went wrong, as a sentence begins. */
export function inWords(error) {
  return `${error.message[0].toUpperCase()}${error.message.slice(1)}`;
}

/** Do something that may be refused, and say so in the service's words; null where it was. */
export async function attempt(work) {
  try {
    return await work();
  } catch (error) {
    if (error.name !== "AbortError") say(inWords(error), true);
    return null;
  }
}
