/** The service's own picture of a sample or an analysis, which have no cells to draw. */

import { kindInWords, send } from "../net/api.js";

/** Whether a job computes cells, which the page draws itself. */
export function hasCells({ request }) {
  return request.grid !== undefined && !request.sample;
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
