/** What is proven of a picture's cells, and why not all of it. */

/** Parts of a cell that are counted. */
export const PARTS = 64;
const NOT_TRIED = 255;
const REASONS = [1, 2, 3, 4];

export class Proof {
  /** @param {number} cells */
  constructor(cells) {
    this.proven = new Uint8Array(cells);
    this.reason = new Uint8Array(cells).fill(NOT_TRIED);
  }

  /**
   * What is proven of a cell: how many of its parts, and why not all; a reason of null where it was not tried yet.
   * @returns {Proven}
   */
  at(cell) {
    const reason = this.reason[cell];
    return { parts: this.proven[cell], reason: reason === NOT_TRIED ? null : reason };
  }

  /** Part of a cell that is not proven. */
  unproven(cell) {
    return 1 - this.proven[cell] / PARTS;
  }

  /**
   * Shares of the cells that are here: what is proven of each motion, and what is not, by reason; `tried` is false where some were
   * not tried yet.
   * @param {Int16Array} solution number of each cell's motion, negative where it is not here
   * @param {number} motions
   */
  shares(solution, motions) {
    const proven = new Float64Array(motions), reasons = new Float64Array(NOT_TRIED + 1);
    let known = 0;
    for (let cell = 0; cell < solution.length; cell++) {
      if (solution[cell] < 0) continue;
      known++;
      proven[solution[cell]] += this.proven[cell];
      reasons[this.reason[cell]] += PARTS - this.proven[cell];
    }
    const share = (parts) => (known ? parts / (PARTS * known) : 0);
    return {
      proven: Array.from(proven, share), tried: reasons[NOT_TRIED] === 0,
      reasons: REASONS.map((reason) => ({ reason, share: share(reasons[reason]) })),
    };
  }
}
