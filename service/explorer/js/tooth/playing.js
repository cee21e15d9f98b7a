/** A motion as it is played: where the tooth is at a time. Pure, over a history as from `/v1/trajectories`. */

/** Index of the last number not above `value` in an ascending list; -1 if all are above. */
export function lastBelow(values, value) {
  let [low, high] = [0, values.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] <= value) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** Displacement at a time, between samples on a straight line. */
export function displacementAt({ time, displacement }, at) {
  const i = lastBelow(time, at);
  if (i < 0) return displacement[0];
  if (i >= time.length - 1) return displacement[time.length - 1];
  const width = time[i + 1] - time[i];
  const part = width > 0 ? (at - time[i]) / width : 0;
  return displacement[i] + part * (displacement[i + 1] - displacement[i]);
}

/** Contacts that begin after one time and not after another. */
export function impactsBetween({ contacts }, from, to) {
  return contacts.filter(({ time, direction }) => direction !== "out" && time > from && time <= to);
}

/** The last of a list of departures {t, v} that has happened at a time; the first if none has. */
export function departureAt(departures, at) {
  let last = departures[0] ?? null;
  for (const departure of departures) {
    if (departure.t > at) break;
    last = departure;
  }
  return last;
}

/** How strongly each wall glows: the squared speed of recent contacts, fading. At most 1 for the fastest of all. */
export function glowAt(history, at, fade) {
  const fastest = history.contacts.reduce((most, { speed }) => Math.max(most, Math.abs(speed)), 0) || 1;
  const glow = { upper: 0, lower: 0 };
  for (const { time, wall, speed } of impactsBetween(history, at - 4 * fade, at)) {
    const name = wall === 1 ? "upper" : "lower";
    glow[name] = Math.max(glow[name], (speed / fastest) ** 2 * Math.exp(-(at - time) / fade));
  }
  return glow;
}

/** A time that runs through a history again and again. */
export class Clock {
  /** @param {number} from @param {number} to @param {number} speed forcing periods a second */
  constructor(from, to, speed) {
    this.from = from;
    this.to = to;
    this.speed = speed;
    this.at = from;
  }

  /** Go on by some seconds; the time before and after. After the end it begins again. */
  run(seconds) {
    const before = this.at;
    const after = before + seconds * this.speed;
    this.at = after >= this.to ? this.from : after;
    return { before: this.at === this.from ? this.from : before, after: this.at };
  }
}
