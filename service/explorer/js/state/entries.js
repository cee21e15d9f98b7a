/** The page's own history of views, numbered, so that Back never leaves the page. */

import { frame } from "../net/frame.js";

const KEY = "rattle-last-entry";

/** In a tab: entries of the browser's history. */
class OfTab {
  constructor() {
    const [opened] = /** @type {PerformanceNavigationTiming[]} */ (performance.getEntriesByType("navigation"));
    // Number of the last entry. It outlives a reload; a page that is opened anew has none after its first.
    this.last = opened?.type === "navigate" ? 0 : Number(sessionStorage.getItem(KEY) ?? 0);
  }

  get #number() {
    return history.state?.entry ?? 0;
  }

  get address() {
    return location.search;
  }

  get hasEarlier() {
    return this.#number > 0;
  }

  get hasLater() {
    return this.#number < this.last;
  }

  write(address, isNew) {
    const there = address || location.pathname;
    if (address === location.search) return;
    if (!isNew) {
      history.replaceState({ entry: this.#number }, "", there);
      return;
    }
    this.last = this.#number + 1;
    sessionStorage.setItem(KEY, String(this.last));
    history.pushState({ entry: this.last }, "", there);
  }

  turn(by) {
    history.go(by);
  }

  whenTurned(show) {
    addEventListener("popstate", show);
  }
}

/** In a frame of a notebook, which has no address, and whose Back would turn the notebook's page: a list. */
export class OfFrame {
  constructor() {
    this.addresses = [""];
    this.number = 0;
    this.show = () => {};
  }

  get address() {
    return this.addresses[this.number];
  }

  get hasEarlier() {
    return this.number > 0;
  }

  get hasLater() {
    return this.number < this.addresses.length - 1;
  }

  write(address, isNew) {
    if (address === this.address) return;
    if (isNew) this.addresses.splice(++this.number);
    this.addresses[this.number] = address;
  }

  turn(by) {
    const number = this.number + by;
    if (!(number in this.addresses)) return;
    this.number = number;
    this.show();
  }

  whenTurned(show) {
    this.show = show;
  }
}

/**
 * @typedef {object} Entries
 * @property {string} address of the view that is seen
 * @property {boolean} hasEarlier whether the page has an earlier view of its own
 * @property {boolean} hasLater
 * @property {(address: string, isNew: boolean) => void} write show an address; unless it is new it corrects the current one
 * @property {(by: number) => void} turn go so many views on, or back
 * @property {(show: () => void) => void} whenTurned what is called then
 */

/** @type {Entries} */
export const entries = frame || typeof history === "undefined" ? new OfFrame() : new OfTab();
