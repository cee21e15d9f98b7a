/** The form: the paper's examples, fields with their bounds, and errors that the service would report, shown beforehand. */

import { secondsInWords } from "../look/estimate.js";
import { by } from "../page/by.js";
import { post, Unreachable } from "../net/api.js";
import { additions } from "../state/additions.js";
import { harmonicParameters, harmonicsOf, harmonicsText, NUMBERS, ONLY_IN, parameterInWords, USUAL, withValues } from "../state/oscillator.js";
import { faultInWords, fieldsOf } from "./faults.js";

const GRID = ["time.start", "time.stop", "time.cells", "velocity.start", "velocity.stop", "velocity.cells"];
const CELLS = 500;
const USUAL_REQUEST = { grid: { time: { start: 0, stop: 1, cells: CELLS }, velocity: { start: 0, stop: 7, cells: CELLS } }, iterations: 1499 };
const WAIT_MS = 180;
const RETRY_MS = 2000;

/** Value of a field: a number if possible, otherwise the text itself, which the service then refuses. */
function valueOf(input) {
  const text = input.value.trim().replace(",", ".");
  return text !== "" && Number.isFinite(Number(text)) ? Number(text) : input.value;
}

function hintOf(bound) {
  const limits = [];
  if (bound.above !== null) limits.push(`above ${Number(bound.above.toPrecision(5))}`);
  if (bound.below !== null) limits.push(`below ${Number(bound.below.toPrecision(5))}`);
  if (bound.between) {
    const [from, to] = bound.between.map((end) => end && Number(end.toPrecision(5)));
    limits.push(to === null ? `below ${from}` : `not from ${from} to ${to}`);
  }
  if (bound.loose_from !== null) limits.push(`loose from ${Number(bound.loose_from.toPrecision(5))}`);
  return { text: limits.join(", "), why: bound.why };
}

export class Form {
  /**
   * @param {HTMLFormElement} form
   * @param {object} tell
   * @param {(request: BasinRequest) => void} tell.submitted
   * @param {() => void} tell.edited called after each change
   * @param {(bounds: object[]) => void} tell.bounds called with the bounds that apply
   * @param {(request: BasinRequest) => number|null} tell.part of its iterations that a request's cells take, where that is known
   * @param {() => number} tell.busy how many times as long the last preview took as on a machine that does nothing else
   * @param {(sound: boolean) => void} tell.sound called with whether the service would take the oscillator and the window
   */
  constructor(form, tell) {
    this.form = form;
    this.tell = tell;
    this.preset = by("preset");
    this.verdict = by("verdict");
    this.button = by("compute");
    this.asked = 0;
    /** What is asked of each addition, by name. @type {Object<string, object|true>} */
    this.added = {};
    /** Seconds that the service gives at most; null where it refuses, or has not said. @type {number|null} */
    this.seconds = null;
    form.querySelectorAll(".field").forEach((field) => {
      const hint = document.createElement("span");
      hint.className = "hint";
      field.append(hint);
      /** @type {NodeListOf<HTMLInputElement>} */
      const inputs = field.querySelectorAll("input, select");
      hint.id = `hint-${inputs[0].name}`;
      inputs.forEach((input) => input.setAttribute("aria-describedby", hint.id));
    });
    form.addEventListener("input", () => this.#edited());
    form.addEventListener("submit", async (event) => {
      event.preventDefault();
      if (await this.check()) this.tell.submitted(this.request());
      else this.#point();
    });
    // After an outage the verdict is about the outage, until the service answers again.
    setInterval(() => this.unanswered && this.check(), RETRY_MS);
  }

  /** Offer what packages add to basins, each by a box. */
  offer() {
    for (const { name, box: { label, title } } of additions) {
      const box = Object.assign(document.createElement("label"), { className: "tick", title });
      box.append(Object.assign(document.createElement("input"), { type: "checkbox", name }), ` ${label}`);
      by("added").append(box);
    }
  }

  /** The service does not answer others: check until it does. */
  doubt() {
    this.unanswered = true;
  }

  #edited() {
    this.preset.value = "";
    this.seconds = null;
    this.#shape();
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.check(), WAIT_MS);
    this.tell.edited();
  }

  /** Take what has just been filled in for an edit. */
  take() {
    this.#edited();
  }

  /** Set numbers of the oscillator, as a slider or a chart does. @param {Object<string, number>} values */
  set(values) {
    for (const [name, value] of Object.entries(values)) {
      if (this.#field("vary").value === name) this.#field("vary").value = "";
      if (NUMBERS.includes(name)) this.#field(name).value = value;
      else this.#setHarmonic(name, value);
    }
    this.#edited();
  }

  #setHarmonic(name, value) {
    const field = this.#field("harmonics");
    field.value = harmonicsText(withValues({ harmonics: harmonicsOf(field.value) }, { [name]: value }).harmonics);
  }

  /** Show the window that is looked at. */
  showWindow(grid) {
    for (const axis of ["time", "velocity"]) {
      for (const end of ["start", "stop"]) this.#field(`${axis}.${end}`).value = grid[axis][end];
    }
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.check(), WAIT_MS);
  }

  /** @returns {any} */
  #field(name) {
    return this.form.elements.namedItem(name);
  }

  /** Fill the form from a request. */
  fill(request) {
    const { oscillator, grid, iterations, vary } = request;
    this.#field("model").value = oscillator.model ?? "impacting";
    for (const name of NUMBERS) {
      const value = oscillator[name] ?? USUAL[name];
      if (value !== undefined) this.#field(name).value = value;
    }
    this.#field("harmonics").value = harmonicsText(oscillator.harmonics);
    this.#offerHarmonics();
    this.#field("permanent_contact").value = oscillator.permanent_contact ?? "envelope";
    this.#field("allow_no_quiet_solution").checked = oscillator.allow_no_quiet_solution === true;
    for (const name of GRID) {
      const [axis, end] = name.split(".");
      // A sample has no cells, but the form requires some.
      const value = grid[axis][end] ?? (end === "cells" ? CELLS : undefined);
      if (value !== undefined) this.#field(name).value = value;
    }
    this.#field("iterations").value = iterations;
    for (const { name } of additions) {
      this.#field(name).checked = Boolean(request[name]);
      // Parts of them have no fields: those of the request stay.
      this.added[name] = typeof request[name] === "object" ? request[name] : true;
    }
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
    this.form.querySelectorAll("[data-model]").forEach((/** @type {HTMLElement} */ part) => (part.hidden = part.dataset.model !== model));
    const vary = this.#field("vary");
    this.#offerHarmonics();
    for (const [name, only] of Object.entries(ONLY_IN)) {
      vary.querySelector(`[value=${name}]`).disabled = model !== only;
      if (model !== only && vary.value === name) vary.value = "";
    }
    this.form.querySelectorAll("[data-vary]").forEach((/** @type {HTMLElement} */ part) => (part.hidden = vary.value === ""));
    for (const { name, box } of additions) this.#field(name).parentElement.hidden = model !== box.model || vary.value !== "";
    // The sweep sets the values of this parameter.
    for (const name of NUMBERS) this.#field(name).disabled = name === vary.value;
    this.button.textContent = vary.value ? "Compute the sweep" : "Compute";
    if (model === "piecewise_linear" && this.#field("stiffness").value === "") this.#field("stiffness").value = "1000";
  }

  /** Offer the numbers of the harmonics that are written down for a sweep. */
  #offerHarmonics() {
    const vary = this.#field("vary"), before = vary.value;
    const names = harmonicParameters(harmonicsOf(this.#field("harmonics").value));
    vary.querySelectorAll("[data-harmonic]").forEach((option) => option.remove());
    for (const name of names) {
      const option = Object.assign(document.createElement("option"), { value: name, textContent: parameterInWords(name) });
      option.dataset.harmonic = "";
      vary.append(option);
    }
    vary.value = [...vary.options].some(({ value }) => value === before) ? before : "";
  }

  /** Request that the form describes. */
  request() {
    const value = (name) => valueOf(this.#field(name));
    const model = this.#field("model").value;
    const oscillator = { model, damping: value("damping"), eccentricity: value("eccentricity"), half_backlash: value("half_backlash") };
    for (const [name, usual] of Object.entries(USUAL)) {
      if (ONLY_IN[name] === model && value(name) !== usual) oscillator[name] = value(name);
    }
    const harmonics = harmonicsOf(this.#field("harmonics").value);
    if (harmonics.length) oscillator.harmonics = harmonics;
    if (model === "piecewise_linear") {
      oscillator.stiffness = value("stiffness");
      oscillator.permanent_contact = this.#field("permanent_contact").value;
      if (this.#field("allow_no_quiet_solution").checked) oscillator.allow_no_quiet_solution = true;
    }
    const axis = (name) => ({ start: value(`${name}.start`), stop: value(`${name}.stop`), cells: value(`${name}.cells`) });
    const request = { oscillator, grid: { time: axis("time"), velocity: axis("velocity") }, iterations: value("iterations") };
    const parameter = this.#field("vary").value;
    if (parameter) request.vary = [{ parameter, start: value("vary.start"), stop: value("vary.stop"), count: value("vary.count") }];
    else for (const { name, box } of additions) if (model === box.model && this.#field(name).checked) request[name] = this.added[name] ?? true;
    return request;
  }

  /** Request for another oscillator in the window of the form, or in the usual one while the form is empty. */
  requestFor(oscillator) {
    const { grid, iterations } = this.request();
    return typeof iterations === "number" ? { oscillator, grid, iterations } : { ...USUAL_REQUEST, oscillator };
  }

  /** Let the service check the request, show the outcome, and return whether it would be accepted. */
  async check() {
    clearTimeout(this.timer);
    const number = ++this.asked;
    try {
      const verdict = await post("/v1/checks", this.request());
      if (number !== this.asked) return false;
      this.unanswered = false;
      this.#show(verdict);
      return verdict.accepted;
    } catch (error) {
      this.unanswered = error instanceof Unreachable;
      if (number === this.asked) this.seconds = null;
      if (number === this.asked) this.#say(error instanceof Unreachable ? "The service does not answer." : error.message, true);
      return false;
    }
  }

  /** Oscillator of the form if all its values are numbers; null otherwise. */
  oscillator() {
    const { oscillator } = this.request();
    const numbers = NUMBERS.every((name) => oscillator[name] === undefined || typeof oscillator[name] === "number");
    return numbers && typeof oscillator.harmonics !== "string" ? oscillator : null;
  }

  #say(text, wrong) {
    // Readers of the screen would hear the same again.
    if (this.verdict.textContent !== text) this.verdict.textContent = text;
    this.verdict.classList.toggle("wrong", wrong);
    // It can still be pressed: it then leads to the field at fault.
    this.button.setAttribute("aria-disabled", String(wrong));
  }

  /** Lead to the first field that is marked. */
  #point() {
    /** @type {HTMLElement|null} */
    const marked = this.form.querySelector("[aria-invalid]");
    if (!marked) return;
    if (this.form.hidden) by("open-drawer").click();
    marked.focus();
  }

  #show({ accepted, errors, seconds, bounds }) {
    this.tell.bounds(bounds);
    this.tell.sound(!errors.some(({ location }) => ["oscillator", "grid"].includes(location[1])));
    this.form.querySelectorAll(".hint").forEach((hint) => this.#hint(hint, "", "", false));
    this.form.querySelectorAll("[aria-invalid]").forEach((input) => input.removeAttribute("aria-invalid"));
    for (const bound of bounds) {
      const { text, why } = hintOf(bound);
      this.#hint(by(`hint-${bound.field}`), text, why, false);
    }
    for (const error of errors) this.#blame(error);
    this.seconds = accepted ? seconds : null;
    if (accepted) this.price();
    else this.#say(errors.map((error) => this.#named(error)).join(" "), true);
  }

  /** Say how long a request takes that the service would take. */
  price() {
    if (this.seconds !== null) this.#say(secondsInWords(this.seconds, this.tell.part(this.request()), this.tell.busy()), false);
  }

  #hint(hint, text, why, wrong) {
    hint.textContent = text;
    hint.title = why;
    hint.classList.toggle("wrong", wrong);
  }

  /** What is wrong, in a sentence that names the field, if it is about one. */
  #named(error) {
    const [field] = fieldsOf(error.location);
    const input = this.#field(field ?? "");
    const name = input?.getAttribute?.("aria-label") ?? input?.labels?.[0]?.textContent.trim() ?? "";
    const words = faultInWords(error, input?.value ?? "");
    const sentence = name && !words.startsWith(field) ? `${name}: ${words}.` : `${words}.`;
    return sentence[0].toUpperCase() + sentence.slice(1);
  }

  /** Mark the fields at fault, with what is wrong beside them: one line for two fields of a pair. */
  #blame(error) {
    for (const input of fieldsOf(error.location).map((field) => this.#field(field))) {
      const hint = by(input?.getAttribute?.("aria-describedby"));
      if (!hint) continue;
      input.setAttribute("aria-invalid", "true");
      const words = input.closest(".pair") ? this.#named(error) : faultInWords(error, input.value);
      const before = hint.classList.contains("wrong") && hint.textContent !== words ? `${hint.textContent} ` : "";
      this.#hint(hint, before + words, "", true);
    }
  }
}
