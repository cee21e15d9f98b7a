/** The service's own picture of a sample or an analysis, which have no cells to draw. */

import { send } from "../net/api.js";

const KINDS = {
  basin: "Sample of a basin", sweep: "Samples of a sweep", bifurcation: "Bifurcation diagram", orbits: "Periodic orbits",
  manifold: "Manifolds of saddles", grazing_curve: "Grazing curve and its pre-images",
};

/** Whether a job computes cells, which the page draws itself. */
export function hasCells({ request }) {
  return request.grid !== undefined && !request.sample;
}

/** Kind of a job, in a word or two. */
export function kindInWords({ kind }) {
  return KINDS[kind];
}

export class Still {
  /** @param {HTMLImageElement} image */
  constructor(image) {
    this.image = image;
  }

  hide() {
    this.image.hidden = true;
    URL.revokeObjectURL(this.image.src);
    this.image.removeAttribute("src");
  }

  /** Show the result of a job so far. It is fetched, not linked, because a link cannot carry the key. */
  async show(job, signal) {
    const picture = URL.createObjectURL(await (await send(job.links.picture.replace(/png$/, "svg"), { signal })).blob());
    URL.revokeObjectURL(this.image.src);
    this.image.src = picture;
    this.image.alt = `${kindInWords(job)}, as the service draws it`;
    this.image.hidden = false;
  }
}
