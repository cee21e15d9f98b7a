/** The form: the paper's examples, fields with their bounds, and errors that the service would report, shown beforehand. */

import { post, Unreachable } from "../net/api.js";
import { grouped } from "../charts/ticks.js";

const OSCILLATOR = ["damping", "eccentricity", "half_backlash", "stiffness"];
const GRID = ["time.start", "time.stop", "time.cells", "velocity.start", "velocity.stop", "velocity.cells"];
const CELLS = 500;
const WAIT_MS = 180;

/** Value of a field: a number if possible, otherwise the text itself, which the service then refuses. */
function valueOf(input) {
  const text = input.value.trim().replace(",", ".");
  return text !== "" && Number.isFinite(Number(text)) ? Number(text) : input.value;
}

function hintOf(bound) {
  const limits = [];
  if (bound.above !== null) limits.push(`above ${Number(bound.above.toPrecision(5))}`);
  if (bound.below !== null) limits.push(`below ${Number(bound.below.toPrecision(5))}`);
  return { text: limits.join(", "), why: bound.why };
}

/** Name of the form's field that contains an error of the request; null if there is none. */
function fieldOf(location) {
  const [, part, ...rest] = location;
  if (part === "oscillator") return rest[0] ?? null;
  if (part === "grid") return rest.join(".");
  if (part === "vary") return ["start", "stop", "count"].includes(rest[1]) ? `vary.${rest[1]}` : "vary.start";
  return part ?? null;
}

export class Form {
  /** @param {HTMLFormElement} form @param {(request: object) => void} submit */
  constructor(form, submit) {
    this.form = form;
    this.verdict = form.querySelector("#verdict");
    this.button = form.querySelector("#compute");
    this.asked = 0;
    form.querySelectorAll(".field").forEach((field) => {
      const hint = document.createElement("span");
      hint.className = "hint";
      field.append(hint);
      const inputs = field.querySelectorAll("input, select");
      hint.id = `hint-${inputs[0].name}`;
      inputs.forEach((input) => input.setAttribute("aria-describedby", hint.id));
    });
    form.addEventListener("input", (event) => {
      if (event.target.id !== "preset") form.querySelector("#preset").value = "";
      this.#shape();
      clearTimeout(this.timer);
      this.timer = setTimeout(() => this.check(), WAIT_MS);
    });
    form.addEventListener("submit", async (event) => {
      event.preventDefault();
      if (await this.check()) submit(this.request());
    });
  }

  /** List the examples, and fill in the one of this name. */
  offer(presets, name) {
    const select = this.form.querySelector("#preset");
    for (const { name: value, label } of presets) select.append(new Option(label, value));
    const choose = () => {
      const preset = presets.find((each) => each.name === select.value);
      this.form.querySelector("#preset-note").textContent = preset?.note ?? "";
      if (preset) this.fill(preset.request);
    };
    select.addEventListener("change", choose);
    select.value = name;
    choose();
  }

  #field(name) {
    return this.form.elements.namedItem(name);
  }

  /** Fill the form from a request. */
  fill(request) {
    const { oscillator, grid, iterations, vary } = request;
    this.#field("model").value = oscillator.model ?? "impacting";
    for (const name of OSCILLATOR) if (oscillator[name] !== undefined) this.#field(name).value = oscillator[name];
    this.#field("permanent_contact").value = oscillator.permanent_contact ?? "envelope";
    this.#field("allow_no_quiet_solution").checked = oscillator.allow_no_quiet_solution === true;
    for (const name of GRID) {
      const [axis, end] = name.split(".");
      // A sample has no cells, but the form requires some.
      const value = grid[axis][end] ?? (end === "cells" ? CELLS : undefined);
      if (value !== undefined) this.#field(name).value = value;
    }
    this.#field("iterations").value = iterations;
    const swept = vary?.length === 1 ? vary[0] : null;
    this.#field("vary").value = swept?.parameter ?? "";
    if (swept) {
      this.#field("vary.start").value = swept.start ?? swept.values[0];
      this.#field("vary.stop").value = swept.stop ?? swept.values.at(-1);
      this.#field("vary.count").value = swept.count ?? swept.values.length;
    }
    this.#shape();
    this.check();
  }

  /** Show the fields that the selected options need. */
  #shape() {
    const model = this.#field("model").value;
    this.form.querySelectorAll("[data-model]").forEach((part) => (part.hidden = part.dataset.model !== model));
    const vary = this.#field("vary");
    vary.querySelector("[value=stiffness]").disabled = model === "impacting";
    if (model === "impacting" && vary.value === "stiffness") vary.value = "";
    this.form.querySelectorAll("[data-vary]").forEach((part) => (part.hidden = vary.value === ""));
    // The sweep sets the values of this parameter.
    for (const name of OSCILLATOR) this.#field(name).disabled = name === vary.value;
    this.button.textContent = vary.value ? "Compute the sweep" : "Compute";
    if (model === "piecewise_linear" && this.#field("stiffness").value === "") this.#field("stiffness").value = "1000";
  }

  /** Request that the form describes. */
  request() {
    const value = (name) => valueOf(this.#field(name));
    const model = this.#field("model").value;
    const oscillator = { model, damping: value("damping"), eccentricity: value("eccentricity"), half_backlash: value("half_backlash") };
    if (model === "piecewise_linear") {
      oscillator.stiffness = value("stiffness");
      oscillator.permanent_contact = this.#field("permanent_contact").value;
      if (this.#field("allow_no_quiet_solution").checked) oscillator.allow_no_quiet_solution = true;
    }
    const axis = (name) => ({ start: value(`${name}.start`), stop: value(`${name}.stop`), cells: value(`${name}.cells`) });
    const request = { oscillator, grid: { time: axis("time"), velocity: axis("velocity") }, iterations: value("iterations") };
    const parameter = this.#field("vary").value;
    if (parameter) request.vary = [{ parameter, start: value("vary.start"), stop: value("vary.stop"), count: value("vary.count") }];
    return request;
  }

  /** Let the service check the request, show the outcome, and return whether it would be accepted. */
  async check() {
    clearTimeout(this.timer);
    const number = ++this.asked;
    try {
      const told = await post("/v1/checks", this.request());
      if (number !== this.asked) return false;
      this.#tell(told);
      return told.accepted;
    } catch (error) {
      if (number === this.asked) this.#say(error instanceof Unreachable ? "The service does not answer." : error.message, true);
      return false;
    }
  }

  #say(text, wrong) {
    this.verdict.textContent = text;
    this.verdict.classList.toggle("wrong", wrong);
    this.button.disabled = wrong;
  }

  #tell({ accepted, errors, applications, bounds }) {
    this.form.querySelectorAll(".hint").forEach((hint) => this.#hint(hint, "", "", false));
    this.form.querySelectorAll("[aria-invalid]").forEach((input) => input.removeAttribute("aria-invalid"));
    for (const bound of bounds) {
      const { text, why } = hintOf(bound);
      this.#hint(this.form.querySelector(`#hint-${bound.field}`), text, why, false);
    }
    const elsewhere = errors.filter((error) => !this.#blame(error)).map(({ message }) => message);
    if (accepted) this.#say(`Up to ${grouped(applications)} applications of the impact map.`, false);
    else this.#say(elsewhere.join("; ") || "Not yet: see the field marked above.", true);
  }

  #hint(hint, text, why, wrong) {
    hint.textContent = text;
    hint.title = why;
    hint.classList.toggle("wrong", wrong);
  }

  /** Mark the field at fault; false if there is none. */
  #blame({ location, message }) {
    const input = this.#field(fieldOf(location) ?? "");
    if (!input?.setAttribute) return false;
    input.setAttribute("aria-invalid", "true");
    this.#hint(document.getElementById(input.getAttribute("aria-describedby")), message, "", true);
    return true;
  }
}
