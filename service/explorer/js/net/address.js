/** The address of the page: the job, the basin of a sweep, and the visible window. */

/** @returns {{job: string|null, panel: number, view: object|null}} */
export function readAddress() {
  const query = new URLSearchParams(location.search);
  const numbers = (query.get("window") || "").split(",").map(Number);
  const whole = numbers.length === 4 && numbers.every(Number.isFinite) && numbers[0] < numbers[1] && numbers[2] < numbers[3];
  const [t0, t1, v0, v1] = numbers;
  return { job: query.get("job"), panel: Number(query.get("panel")) || 0, view: whole ? { t0, t1, v0, v1 } : null };
}

function short(number) {
  return String(Number(number.toPrecision(10)));
}

/**
 * Write the current job, basin and window to the address.
 * @param {{job: string, panel: number, view: object}} place
 * @param {boolean} isNew whether Back undoes it; otherwise it corrects the current entry
 */
export function writeAddress({ job, panel, view }, isNew) {
  const query = [`job=${encodeURIComponent(job)}`];
  if (panel) query.push(`panel=${panel}`);
  if (view) query.push(`window=${[view.t0, view.t1, view.v0, view.v1].map(short).join(",")}`);
  const address = `?${query.join("&")}`;
  if (address === location.search) return;
  history[isNew ? "pushState" : "replaceState"](null, "", address);
}
