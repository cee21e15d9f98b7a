/** One basin as far as it is computed: its labels in typed arrays, and a canvas with one pixel per cell. */

import { get, send, whole } from "../net/api.js";
import { maskOf } from "../state/additions.js";
import { viewOf } from "../state/window.js";
import { partsOf, wholeOf } from "./levels.js";
import { loudnessPixels, paintNumbers, paintSolutions, paintTextures, solutionPixels, specialPixel, texturesOf, usualSpeckle } from "./palette.js";
import { Masked } from "./masked.js";
import { inKeptColours } from "./session.js";
import { Veil } from "./veil.js";

const LABELLED = 3;
const AT_A_TIME = 4;
const SHIFTS = [-1, 0, 1];

function share(cells, every) {
  return Math.ceil(cells / every);
}

export class Picture {
  /**
   * @param {string|null} job
   * @param {number} panel
   * @param {Outline} outline as from `/outline`
   * @param {import("./levels.js").Shown} shown the tiles that it is made from
   */
  constructor(job, panel, outline, shown = wholeOf(outline)) {
    this.job = job;
    this.panel = panel;
    this.outline = inKeptColours(outline);
    const { time, velocity } = outline;
    this.shown = shown;
    this.every = shown.every;
    this.width = share(time.cells, this.every);
    this.height = share(velocity.cells, this.every);
    // A cell of the picture is `every` cells wide; the last may reach beyond the window.
    this.cellTime = ((time.stop - time.start) / time.cells) * this.every;
    this.cellVelocity = ((velocity.stop - velocity.start) / velocity.cells) * this.every;
    const cells = this.width * this.height;
    this.solution = new Int16Array(cells).fill(-1);
    this.step = new Int32Array(cells);
    this.group = new Int32Array(cells);
    this.period = new Int32Array(cells);
    // null where nothing was asked for beside the labels.
    const mask = maskOf(outline);
    this.masked = mask && new Masked(mask, cells);
    this.veil = this.masked && new Veil(this.masked, this.width, this.height);
    this.there = new Set();
    this.settled = new Set();
    this.fresh = true;
    this.usual = 0;
    // Whether slow motions are named by their first impacts only, as in a first look.
    this.quick = false;
    this.canvas = document.createElement("canvas");
    this.canvas.width = this.width;
    this.canvas.height = this.height;
    this.context = this.canvas.getContext("2d");
    this.image = this.context.createImageData(this.width, this.height);
    this.pixels = new Int32Array(this.image.data.buffer);
  }

  /** Basin of a job, without cells yet. */
  static async open(job, panel) {
    return new Picture(job, panel, await get(`/v1/jobs/${job}/outline?panel=${panel}`));
  }

  get view() {
    return viewOf(this.outline);
  }

  /** Whether it is a preview, and not the picture of a job. */
  get isPreview() {
    return false;
  }

  get empty() {
    return this.there.size === 0;
  }

  /**
   * The parts of it that a window shows, of more cells than here: none unless it is finished and has levels.
   * @param {View} view
   */
  closer(view) {
    return partsOf(this.outline, this.every, view).map(({ time, velocity, shown }) =>
      new Picture(this.job, this.panel, { ...this.outline, time, velocity }, shown));
  }

  /** State of each tile that is shown. Levels are there as a whole. */
  get states() {
    return this.shown.states ?? this.outline.tiles.states;
  }

  /** Whether every tile is here in its final form. */
  get whole() {
    return this.outline.complete && this.settled.size === this.states.length;
  }

  /**
   * Fetch what has changed.
   * @param {boolean} final whether the job has ended: earlier tiles may have new labels and are fetched again
   * @param {(tile: number) => void} arrived
   */
  async refresh(final, arrived, signal) {
    const before = this.outline.solutions.length;
    if (!this.fresh) this.outline = inKeptColours(await get(`/v1/jobs/${this.job}/outline?panel=${this.panel}`, { signal }));
    this.fresh = false;
    if (this.outline.solutions.length !== before) this.there.clear();
    const settled = final && this.outline.complete;
    const wanted = this.states.flatMap((state, tile) =>
      state === LABELLED && !(settled ? this.settled : this.there).has(tile) ? [tile] : []);
    // From the middle outwards, a few at a time: the eye is there first.
    wanted.sort((one, other) => this.#offCentre(one) - this.#offCentre(other));
    const fetchNext = async () => {
      for (let tile = wanted.shift(); tile !== undefined; tile = wanted.shift()) {
        await this.#fetch(tile, signal);
        this.there.add(tile);
        if (settled) this.settled.add(tile);
        arrived(tile);
      }
    };
    await Promise.all(Array.from({ length: AT_A_TIME }, fetchNext));
  }

  /** Rectangle of cells of the picture that a tile covers. */
  rectangle(tile) {
    const { rows, columns, across, step } = this.shown;
    const row = Math.floor(tile / across), column = tile % across;
    const top = share(row * rows, step), left = share(column * columns, step);
    return {
      left, top,
      right: Math.min(share((column + 1) * columns, step), this.width),
      bottom: Math.min(share((row + 1) * rows, step), this.height),
    };
  }

  /** Distance of a tile from the middle of the picture. */
  #offCentre(tile) {
    const { left, top, right, bottom } = this.rectangle(tile);
    return Math.hypot((left + right) / this.width - 1, (top + bottom) / this.height - 1);
  }

  async #fetch(tile, signal) {
    const { first, across, stride, query } = this.shown;
    const number = first + Math.floor(tile / across) * stride + (tile % across);
    const answer = await send(`/v1/jobs/${this.job}/tiles/${number}?${query}`, { signal });
    const [rows, columns] = answer.headers.get("rattle-shape").split(" ").map(Number);
    const bytes = await whole(() => answer.arrayBuffer());
    const cells = rows * columns;
    /** @type {[Int32Array|Int16Array|Uint8Array, Int32Array|Int16Array|Uint8Array][]} */
    const parts = [
      [this.step, new Int32Array(bytes, 0, cells)],
      [this.group, new Int32Array(bytes, 4 * cells, cells)],
      [this.period, new Int32Array(bytes, 8 * cells, cells)],
      [this.solution, new Int16Array(bytes, 12 * cells, cells)],
    ];
    // The mask comes after the labels, and may not be there yet.
    if (this.masked && bytes.byteLength === 16 * cells) {
      parts.push([this.masked.clear, new Uint8Array(bytes, 14 * cells, cells)], [this.masked.reason, new Uint8Array(bytes, 15 * cells, cells)]);
    }
    const { left, top, bottom } = this.rectangle(tile);
    for (const [whole, part] of parts) {
      for (let row = 0; row < rows; row++) {
        // Speeds increase upwards, pixel rows downwards.
        const at = (this.height - 1 - top - row) * this.width + left;
        whole.set(part.subarray(row * columns, (row + 1) * columns), at);
      }
    }
    this.veil?.paint(left, this.height - bottom, columns, rows);
  }

  /** Largest value of one of Hsu's numbers so far. */
  highest(layer) {
    return this[layer].reduce((most, value) => (value > most ? value : most), 0);
  }

  /** Paint one tile, or all, in a style. */
  paint(look, tile = null) {
    const loud = look.layer === "loudness";
    const numbers = look.layer !== "solution" && !loud;
    const special = specialPixel("#8a8f98");
    const usual = usualSpeckle(this.outline, this.solution, this.group);
    const everything = { left: 0, top: 0, right: this.width, bottom: this.height };
    const { left, top, right, bottom } = tile === null || usual !== this.usual ? everything : this.rectangle(tile);
    this.usual = usual;
    // Loudness has no speckle: a cell has the colour of its motion, whatever its group.
    const kinds = loud ? 0 : this.outline.speckle.length;
    const table = numbers ? null : loud ? loudnessPixels(this.outline, special) : solutionPixels(this.outline, look, usual);
    const textures = numbers || loud ? null : texturesOf(this.outline, look);
    const highest = numbers ? this.highest(look.layer) : 0;
    for (let row = top; row < bottom; row++) {
      const from = (this.height - 1 - row) * this.width + left;
      const to = from + right - left;
      if (numbers) paintNumbers(this.pixels, this[look.layer], this.solution, look.layer, highest, special, from, to);
      else paintSolutions(this.pixels, this.solution, this.group, table, kinds, from, to);
      if (textures) paintTextures(this.pixels, this.solution, textures, this.width, from, to);
    }
    this.context.putImageData(this.image, 0, 0, left, this.height - bottom, right - left, bottom - top);
  }

  /** Draw what is known into a plot. */
  draw(plot) {
    this.lay(plot, this.canvas, plot.context);
  }

  /** Lay a canvas with a pixel for each cell over a plot, or over a canvas of its size; phases repeat. */
  lay(plot, canvas, context) {
    const { t0, t1, v0, v1 } = this.view;
    const width = this.width * this.cellTime, height = this.height * this.cellVelocity;
    const low = Math.max(plot.view.v0, v0), high = Math.min(plot.view.v1, v1);
    for (const shift of SHIFTS) {
      const early = Math.max(plot.view.t0, t0 + shift), late = Math.min(plot.view.t1, t1 + shift);
      if (!(early < late && low < high)) continue;
      const source = [
        ((early - t0 - shift) / width) * this.width, this.height - ((high - v0) / height) * this.height,
        ((late - early) / width) * this.width, ((high - low) / height) * this.height,
      ];
      context.drawImage(canvas, ...source, plot.x(early), plot.y(high), plot.x(late) - plot.x(early), plot.y(low) - plot.y(high));
    }
  }

  /**
   * What is known of the cell at a point; null outside, or if it is missing.
   * @returns {Known|null}
   */
  at(t, v) {
    const { t0, v0 } = this.view;
    const column = Math.floor((t - t0 - Math.floor(t - t0 + 1e-12)) / this.cellTime);
    const row = Math.floor((v - v0) / this.cellVelocity);
    if (column < 0 || row < 0 || column >= this.width || row >= this.height) return null;
    const i = (this.height - 1 - row) * this.width + column;
    if (this.solution[i] < 0) return null;
    const solution = this.outline.solutions[this.solution[i]];
    // If only every n-th cell is shown, it is the first of its neighbours.
    const t1 = t0 + column * this.cellTime + this.cellTime / this.every / 2;
    const v1 = v0 + row * this.cellVelocity + this.cellVelocity / this.every / 2;
    const known = { solution, step: this.step[i], group: this.group[i], period: this.period[i], t: t1, v: v1 };
    return this.masked ? { ...known, clear: this.masked.at(i), mask: this.masked.mask } : known;
  }

  /** Share of each solution among the cells that are here. */
  shares() {
    const counts = new Float64Array(this.outline.solutions.length);
    let known = 0;
    for (const number of this.solution) {
      if (number >= 0) {
        counts[number]++;
        known++;
      }
    }
    return Array.from(counts, (count) => (known ? count / known : 0));
  }
}
