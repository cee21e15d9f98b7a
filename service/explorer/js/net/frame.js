/**
 * What the page lives in: a tab of a browser, or a frame in a notebook, whose requests Python answers. The notebook puts
 * this on the element of the frame before the page begins.
 *
 * @typedef {object} Frame
 * @property {typeof fetch} fetch
 * @property {{address?: string, request?: BasinRequest, job?: string}} opening what is seen first: an address, or a job or a request
 * @property {(seen: import("../page/notebook.js").Told) => void} tell take what is seen now
 * @property {(hear: (parts: import("../page/notebook.js").Parts) => void) => void} listen take the function that shows what Python says
 */

/** @type {Frame|null} null in a tab */
export const frame = /** @type {any} */ (globalThis.frameElement)?.rattle ?? null;
