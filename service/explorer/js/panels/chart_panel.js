/** A chart below the plane that a job computes: asked for, brought back by an address, out of date, closed. */

import { Instrument } from "../charts/instrument.js";
import { Computation } from "../jobs/computation.js";
import { oscillatorInWords } from "../look/caption.js";
import { by } from "../page/by.js";
import { inWords } from "../page/say.js";

/**
 * A scene of a job: of which oscillator, and over which parameter, if there is one.
 * @typedef {import("../charts/instrument.js").Scene & {job: string, oscillator: Oscillator, parameter?: string}} JobScene
 */

/**
 * What differs between such charts.
 * @typedef {object} Shown
 * @property {string} name of its elements
 * @property {string} kind of its jobs
 * @property {string} path of their requests
 * @property {{label: string, act: string, does: string, walks?: string}} words of the chart
 * @property {string} offer what the button says that computes it
 * @property {(wanted: SeenChart) => string} title
 * @property {(oscillator: Oscillator, wanted: SeenChart) => object} body of a request
 * @property {(job: Job, wanted: SeenChart) => boolean} answers whether a job has what is wanted
 * @property {(job: Job) => Promise<JobScene>} sceneOf
 * @property {(scene: JobScene, view: import("../charts/view.js").ChartView) => SeenChart} seenOf
 * @property {(job: Job) => SeenChart} wantedOf what a job was asked for
 * @property {string} note what is seen and what can be done, once it is there
 * @property {string} [none] what is said in its place where there are no points
 * @property {(scene: JobScene, oscillator: Oscillator) => boolean} isOf whether the scene is that of an oscillator
 * @property {(scene: JobScene, view: import("../charts/view.js").ChartView) => Partial<SeenChart>|null} finer what is
 *   computed anew where a part is seen
 * @property {string} [part] what the button says that computes the part which is seen, where that is not done by itself
 * @property {(place: {x: number, y: number}, point: any|null, at: {x: number, y: number}) => void} picked
 * @property {(place: {x: number, y: number}) => void} [walked] the pointer moves over a place
 * @property {() => void} [left] it is over none any more
 * @property {() => void} follow another picture is seen
 */

/**
 * @typedef {object} Page
 * @property {() => Oscillator|null} oscillator that is seen
 * @property {(isNew: boolean) => void} changed what an address holds has changed
 */

export class ChartPanel {
  /**
   * @param {Shown} chart
   * @param {Page} page
   */
  constructor(chart, page) {
    this.chart = chart;
    this.page = page;
    this.section = by(chart.name);
    this.note = by(`${chart.name}-note`);
    /** @type {SeenChart|null} */
    this.wanted = null;
    this.turn = 0;
    this.instrument = new Instrument(by(`${chart.name}-chart`), chart.words, {
      moved: (view) => this.#moved(view), picked: (place, point, at) => chart.picked(place, point, at), closed: () => this.close(),
      ...(chart.walked && { walked: (place) => chart.walked(place), left: () => chart.left() }),
    });
    this.computation = new Computation(by(`${chart.name}-watch`), {
      accepted: (job) => {
        this.wanted.job = job.id;
        page.changed(false);
      },
      done: (job, signal) => this.#done(job, signal),
      ended: (words) => (words ? this.#offer(words) : this.follow()),
    });
  }

  /** What is shown. @returns {JobScene|null} */
  get shown() {
    return /** @type {JobScene|null} */ (this.instrument.scene);
  }

  /** What an address holds of it; null if nothing is seen. @returns {SeenChart|null} */
  get seen() {
    if (this.section.hidden) return null;
    return this.shown ? { ...this.chart.seenOf(this.shown, this.instrument.view), job: this.shown.job } : this.wanted;
  }

  /**
   * Compute what is wanted. A part of what is shown stays there until it comes.
   * @param {Partial<SeenChart>} wanted
   * @param {Oscillator|null} [oscillator]
   * @param {boolean} [part] whether it is a part of what is shown
   */
  ask(wanted, oscillator = this.page.oscillator(), part = false) {
    if (!oscillator) return;
    this.#begin({ x: null, y: null, ...wanted, job: null }, part);
    this.computation.ask(this.chart.path, this.chart.body(oscillator, this.wanted));
    if (part) return;
    this.section.scrollIntoView({ block: "nearest" });
    this.page.changed(true);
  }

  /** Show the chart of a job once it is computed. @param {Job} job @param {SeenChart} [wanted] */
  show(job, wanted = this.chart.wantedOf(job)) {
    this.#begin({ ...wanted, job: job.id }, false);
    this.computation.show(job);
  }

  #begin(wanted, part) {
    this.turn++;
    this.wanted = wanted;
    this.section.hidden = false;
    by(`${this.chart.name}-title`).textContent = this.chart.title(wanted);
    if (part) return;
    this.instrument.clear();
    this.note.textContent = "";
  }

  async #done(job, signal) {
    const scene = await this.chart.sceneOf(job);
    if (signal.aborted) return;
    const { x, y } = this.shown ? this.instrument.view : this.wanted;
    this.instrument.show(scene, { x: x ?? scene.whole.x, y: y ?? scene.whole.y });
    this.note.textContent = scene.points.length ? this.chart.note : this.chart.none ?? "There are none.";
    this.page.changed(false);
  }

  /** Offer to compute what is wanted. */
  #offer(words) {
    const { x, y, parameter } = this.wanted;
    this.computation.offer(words, this.chart.offer, () => this.ask({ x, y, parameter }));
  }

  /**
   * Show what an address has: without asking for anything that nobody has computed.
   * @param {SeenChart|null} seen
   */
  async open(seen) {
    const turn = ++this.turn;
    if (!seen) return this.#hide();
    const step = this.shown && [{ scene: this.shown }, ...this.instrument.steps].find(({ scene }) => /** @type {JobScene} */ (scene).job === seen.job);
    if (step) {
      this.computation.drop();
      const { whole } = step.scene;
      const view = { x: seen.x ?? whole.x, y: seen.y ?? whole.y };
      if (step.scene === this.shown) this.instrument.look(view);
      else this.instrument.show(step.scene, view);
      return this.follow();
    }
    try {
      const job = seen.job && (await this.computation.find(seen.job));
      if (turn !== this.turn) return;
      if (job && job.kind === this.chart.kind && this.chart.answers(job, seen)) return this.show(job, seen);
      this.computation.drop();
      this.#begin({ ...seen, job: null }, false);
      this.#offer("Nobody has computed this here yet.");
    } catch (error) {
      this.section.hidden = false;
      this.computation.offer(inWords(error));
    }
  }

  /** Another view is seen. */
  #moved(view) {
    const finer = this.chart.finer(this.shown, view);
    // What was asked for a view that is no longer seen is wanted no more.
    if (finer) this.ask(finer, this.shown.oscillator, true);
    else if (this.computation.busy) this.computation.drop();
    this.follow();
    this.page.changed(true);
  }

  /** Another oscillator may be seen: then this chart is none of it, and says so. */
  follow() {
    this.chart.follow();
    const seen = this.page.oscillator();
    if (!this.shown || !seen || this.computation.busy) return;
    if (this.chart.isOf(this.shown, seen)) return this.#offerPart();
    const own = oscillatorInWords(this.shown.oscillator, this.shown.parameter);
    const words = `This chart is not of the basin that is seen, but of ${own[0].toLowerCase()}${own.slice(1)}.`;
    this.computation.offer(words, "Compute it anew", () => this.ask({ ...this.chart.seenOf(this.shown, this.shown.whole) }));
  }

  #offerPart() {
    const { part } = this.chart;
    if (!part || !this.instrument.zoomed) return this.computation.offer();
    this.computation.offer("", part, () => this.ask(this.chart.seenOf(this.shown, this.instrument.view)));
  }

  /** Draw it in other colours. */
  repaint() {
    this.instrument.draw();
  }

  /** See it no more. */
  close() {
    this.#hide();
    this.page.changed(true);
  }

  #hide() {
    this.computation.drop();
    this.instrument.clear();
    this.section.hidden = true;
  }
}
