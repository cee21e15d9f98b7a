/** The paper's examples: a list, and small pictures of them. */

import { sourceOf } from "../net/api.js";

export class Examples {
  /**
   * @param {HTMLSelectElement} select
   * @param {HTMLElement} gallery
   * @param {HTMLElement} note
   * @param {(request: BasinRequest) => void} chosen
   */
  constructor(select, gallery, note, chosen) {
    this.select = select;
    this.gallery = gallery;
    this.note = note;
    this.chosen = chosen;
    this.presets = [];
    select.addEventListener("change", () => this.choose(select.value));
  }

  /** Offer examples, as in presets.json: those of one heading follow each other. */
  offer(presets) {
    this.presets = presets;
    for (const heading of new Set(presets.map((each) => each.heading))) {
      const own = presets.filter((each) => each.heading === heading);
      const group = Object.assign(document.createElement("optgroup"), { label: heading });
      group.append(...own.map(({ name, label }) => new Option(label, name)));
      this.select.append(group);
      const list = document.createElement("ul");
      list.append(...own.map((each) => this.#pictured(each)));
      const section = document.createElement("div");
      section.append(Object.assign(document.createElement("h3"), { textContent: heading }), list);
      this.gallery.append(section);
    }
  }

  #pictured({ name, short, label }) {
    const button = Object.assign(document.createElement("button"), { type: "button", title: label });
    const image = Object.assign(document.createElement("img"), { alt: "", loading: "lazy" });
    sourceOf(`explorer/thumbnails/${name}.png`).then((source) => (image.src = source));
    button.append(image, short);
    button.addEventListener("click", () => this.choose(name));
    const item = document.createElement("li");
    item.append(button);
    return item;
  }

  /** Choose an example by its name. */
  choose(name) {
    const preset = this.presets.find((each) => each.name === name);
    this.note.textContent = preset?.note ?? "";
    if (!preset) return;
    this.chosen(preset.request);
    this.select.value = name;
  }
}
