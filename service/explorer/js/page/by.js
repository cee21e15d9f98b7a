/**
 * An element of the page by its id.
 * @param {string} id
 * @returns {any}
 */
export function by(id) {
  return document.getElementById(id);
}
