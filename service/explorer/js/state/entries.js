/** The page's own history of views: entries of the browser's history, numbered, so that Back never leaves the page. */

const KEY = "rattle-last-entry";

// Number of the last entry. It outlives a reload; a page that is opened anew has none after its first.
const [opened] = /** @type {PerformanceNavigationTiming[]} */ (performance.getEntriesByType("navigation"));
let last = opened?.type === "navigate" ? 0 : Number(sessionStorage.getItem(KEY) ?? 0);

/** Number of the entry that is shown. */
function number() {
  return history.state?.entry ?? 0;
}

/** Whether the page has an earlier entry of its own. */
export function hasEarlier() {
  return number() > 0;
}

/** Whether the page has a later entry of its own. */
export function hasLater() {
  return number() < last;
}

/**
 * Show an address.
 * @param {string} address
 * @param {boolean} isNew whether Back returns to the one before; otherwise it corrects the current entry
 */
export function write(address, isNew) {
  const there = address || location.pathname;
  if (address === location.search) return;
  if (!isNew) {
    history.replaceState({ entry: number() }, "", there);
    return;
  }
  last = number() + 1;
  sessionStorage.setItem(KEY, String(last));
  history.pushState({ entry: last }, "", there);
}
