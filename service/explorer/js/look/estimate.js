/** How long a job is going to take. */

/**
 * Part of all iterations that cells take: those that settle take no more than a preview's, which has so few that they do.
 * @param {{kind: string, share: number|null}[]} solutions
 * @param {number} few iterations of the preview, as a part
 */
export function partTaken(solutions, few) {
  const settled = solutions.filter(({ kind }) => ["permanent_contact", "periodic"].includes(kind));
  const share = settled.reduce((sum, each) => sum + (each.share ?? 0), 0);
  return 1 - share * (1 - Math.min(few, 1));
}

/**
 * How many times as long a preview took as on a machine that does nothing else.
 * @param {string|null} timing header Server-Timing: the milliseconds that went by, and those on a processor
 */
export function busyness(timing) {
  const [wall, cpu] = ["wall", "cpu"].map((name) => Number(new RegExp(`\\b${name};dur=([0-9.]+)`).exec(timing ?? "")?.[1]));
  return cpu > 0 && wall > cpu ? wall / cpu : 1;
}

// Below this ratio another run of the same preview can be on the other side.
const BUSY = 1.5;

/**
 * How long a request takes, in words.
 * @param {number} seconds at most, at the speed that the service has measured when it started
 * @param {number|null} part of that which its cells take, where a preview has shown it
 * @param {number} busy how many times as long the last preview took as on a machine that does nothing else
 */
export function secondsInWords(seconds, part, busy) {
  const taken = seconds * (part ?? 1) * busy;
  const about = part === null ? "Up to about" : "About";
  const why = busy < BUSY ? "." : ": the machine is busy.";
  if (taken < 1) return "Less than a second of computing.";
  if (taken < 90) return `${about} ${Math.ceil(taken)} s of computing${why}`;
  return `${about} ${Math.ceil(taken / 60)} minutes of computing${why}`;
}
