/** Which parts of a picture's cells are clear of a mask, and why the others are not. */

const NOT_TRIED = 255;

export class Masked {
  /** @param {Mask} mask @param {number} cells */
  constructor(mask, cells) {
    this.mask = mask;
    this.clear = new Uint8Array(cells);
    this.reason = new Uint8Array(cells).fill(NOT_TRIED);
  }

  /**
   * How many parts of a cell are clear, and why not all; a reason of null where it was not tried yet.
   * @returns {Clear}
   */
  at(cell) {
    const reason = this.reason[cell];
    return { parts: this.clear[cell], reason: reason === NOT_TRIED ? null : reason };
  }

  /** Part of a cell that is veiled. */
  veiled(cell) {
    return 1 - this.clear[cell] / this.mask.parts;
  }

  /**
   * Shares of the cells that are here: what is clear of each motion, and what is not, by reason; `tried` is false where some were
   * not tried yet.
   * @param {Int16Array} solution number of each cell's motion, negative where it is not here
   * @param {number} motions
   */
  shares(solution, motions) {
    const { parts, reasons: words } = this.mask;
    const clear = new Float64Array(motions), reasons = new Float64Array(NOT_TRIED + 1);
    let known = 0;
    for (let cell = 0; cell < solution.length; cell++) {
      if (solution[cell] < 0) continue;
      known++;
      clear[solution[cell]] += this.clear[cell];
      reasons[this.reason[cell]] += parts - this.clear[cell];
    }
    const share = (count) => (known ? count / (parts * known) : 0);
    return {
      clear: Array.from(clear, share), tried: reasons[NOT_TRIED] === 0,
      reasons: Object.keys(words).map(Number).map((reason) => ({ reason, share: share(reasons[reason]) })),
    };
  }
}
