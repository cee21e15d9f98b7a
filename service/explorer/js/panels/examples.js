/** The paper's examples: a list, and small pictures of them. */

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

  /** Offer examples, as in presets.json. */
  offer(presets) {
    this.presets = presets;
    for (const { name, label } of presets) {
      this.select.append(new Option(label, name));
      const button = Object.assign(document.createElement("button"), { type: "button", title: label });
      button.setAttribute("aria-label", label);
      button.append(Object.assign(document.createElement("img"), { src: `explorer/thumbnails/${name}.png`, alt: "", loading: "lazy" }));
      button.addEventListener("click", () => this.choose(name));
      this.gallery.append(button);
    }
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
