/** One request at a time, the newest next: what a slider that moves needs. */

export class Latest {
  /**
   * @param {(wish: any, signal: AbortSignal) => Promise<any>} ask
   * @param {(answer: any, wish: any) => void} show called with answers that are not stale
   * @param {(error: Error, wish: any) => void} failed
   */
  constructor(ask, show, failed) {
    this.ask = ask;
    this.show = show;
    this.failed = failed;
    /** @type {AbortController|null} */
    this.running = null;
    /** @type {{wish: any}|null} */
    this.next = null;
    /** What is asked for just now. */
    this.wish = null;
  }

  /** Ask for this next. A wish that has not begun is replaced; one under way is finished, so that pictures keep coming. */
  want(wish) {
    if (this.running) this.next = { wish };
    else this.#run(wish);
  }

  /** Drop what is under way and what waits. */
  drop() {
    this.running?.abort();
    this.running = this.next = this.wish = null;
  }

  async #run(wish) {
    const running = (this.running = new AbortController());
    this.wish = wish;
    try {
      const answer = await this.ask(wish, running.signal);
      if (this.running === running) this.show(answer, wish);
    } catch (error) {
      // A newer wish matters more than the failure of an older one.
      if (this.running === running && !this.next) this.failed(error, wish);
    }
    if (this.running !== running) return;
    const { next } = this;
    this.running = this.next = this.wish = null;
    if (next) this.#run(next.wish);
  }
}
