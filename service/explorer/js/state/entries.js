/** The page's own history of views: entries of the browser's history, numbered, so that Back never leaves the page. */

/** Number of the entry that is shown. */
function number() {
  return history.state?.entry ?? 0;
}

/** Whether the page has an earlier entry of its own. */
export function hasEarlier() {
  return number() > 0;
}

/**
 * Show an address.
 * @param {string} address
 * @param {boolean} isNew whether Back returns to the one before; otherwise it corrects the current entry
 */
export function write(address, isNew) {
  const there = address || location.pathname;
  if (address === location.search) return;
  if (isNew) history.pushState({ entry: number() + 1 }, "", there);
  else history.replaceState({ entry: number() }, "", there);
}
