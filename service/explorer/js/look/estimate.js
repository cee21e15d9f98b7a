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
 * How long a request takes, in words.
 * @param {number} seconds at most, at the speed that the service has measured
 * @param {number|null} part of that which its cells take, where a preview has shown it
 */
export function secondsInWords(seconds, part) {
  const taken = seconds * (part ?? 1);
  const about = part === null ? "Up to about" : "About";
  if (taken < 1) return "Less than a second of computing.";
  if (taken < 90) return `${about} ${Math.ceil(taken)} s of computing.`;
  return `${about} ${Math.ceil(taken / 60)} minutes of computing.`;
}
