/** A basin that is kept beside the one that is seen: a plane of its own, with pictures, overlays and motions. */

import { get } from "../net/api.js";
import { follow } from "../net/follow.js";
import { ended } from "../jobs/life.js";
import { Live } from "../look/live.js";
import { OVERLAYS } from "./overlays.js";
import { Picture } from "./picture.js";
import { Stack } from "./stack.js";

/**
 * What is kept, as an address holds it.
 * @typedef {{oscillator: Oscillator, request: BasinRequest, job: string|null, panel: number}} Kept
 */

export class Half {
  /**
   * @param {Kept} kept
   * @param {Stack} seen pictures that are there at the beginning
   * @param {number} part of the width at which it begins
   * @param {string} label
   * @param {(error: Error) => void} failed
   */
  constructor(kept, seen, part, label, failed) {
    this.oscillator = kept.oscillator;
    this.request = kept.request;
    this.job = kept.job;
    this.panel = kept.panel;
    this.part = part;
    this.label = label;
    this.stack = new Stack();
    [this.stack.jobs, this.stack.preview, this.stack.closer] = [[...seen.jobs], seen.preview, [...seen.closer]];
    this.fetched = new Map(OVERLAYS.map(({ name, fetched }) => [name, fetched]));
    /** Names of overlays that were asked for. */
    this.asked = new Set();
    this.following = new AbortController();
    this.live = new Live({ show: (preview) => (this.stack.offer(preview), this.changed(preview)), failed, alone: () => this.job === null });
    /** @type {(picture: Picture|import("../look/preview.js").Preview, tile?: number) => void} */
    this.changed = () => {};
  }

  get picture() {
    return this.stack.top;
  }

  /** The overlays that are on, with what was computed for this basin; what is lacking is fetched. */
  overlaysOf(overlays) {
    for (const { name, fetched } of overlays) {
      if (fetched && !this.fetched.get(name).length && this.job && this.picture?.outline.complete && !this.picture.isPreview) this.#fetch(name);
    }
    return overlays.map((overlay) => (overlay.fetched ? { ...overlay, fetched: this.fetched.get(overlay.name) } : overlay));
  }

  async #fetch(name) {
    if (this.asked.has(name)) return;
    this.asked.add(name);
    try {
      this.fetched.set(name, (await get(`/v1/jobs/${this.job}/overlays/${name}?panel=${this.panel}`)).overlays);
      this.changed(this.picture);
    } catch {
      // The other half says why: it asks for the same.
    }
  }

  /** Look at a window: where no job has cells, a preview shows it. */
  look(view) {
    this.live.want(this.oscillator, view);
  }

  /** Fetch what its job computes, whatever the other half does meanwhile. */
  async load() {
    if (this.job === null) return;
    const { signal } = this.following;
    const job = await get(`/v1/jobs/${this.job}`);
    let picture = null;
    await follow(job, async (now) => {
      if (!now.progress || signal.aborted) return;
      picture ??= await Picture.open(this.job, this.panel);
      if (signal.aborted) return;
      if (!this.stack.jobs.includes(picture)) this.stack.add(picture);
      await picture.refresh(ended(now), (tile) => this.changed(picture, tile), signal);
      this.changed(picture);
    }, () => {}, signal);
  }

  /** Fetch nothing more. */
  close() {
    this.following.abort();
    this.live.drop();
  }
}
