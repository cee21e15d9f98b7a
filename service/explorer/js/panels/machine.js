/** The form of a machine in its own units: while it is filled in, the oscillator follows. */

import { by } from "../page/by.js";
import { Latest } from "../net/latest.js";
import { post, Refusal } from "../net/api.js";
import { FIELDS, gammaInWords, inUnits, machineOf, parts, PUMP, writtenOf } from "../state/machine.js";
import { NUMBERS, USUAL } from "../state/oscillator.js";
import { Report } from "./report.js";

const WAIT_MS = 180;

export class MachineForm {
  /**
   * @param {HTMLDetailsElement} place
   * @param {object} tell
   * @param {(answer: import("../state/machine.js").MachineAnswer) => void} tell.converted called with the machine in the model
   * @param {() => void} tell.changed called when what is seen has other units, or none
   */
  constructor(place, tell) {
    this.place = place;
    this.tell = tell;
    /** What the fields say in the model; null while they say nothing. @type {import("../state/machine.js").MachineAnswer|null} */
    this.answer = null;
    this.rows = new Map(FIELDS.map((field) => [field.name, this.#row(field)]));
    this.said = Object.assign(document.createElement("p"), { className: "note", id: "machine-said" });
    this.said.setAttribute("role", "status");
    const pump = Object.assign(document.createElement("button"), { type: "button", textContent: "The paper's pump" });
    pump.title = "Numbers of the paper's pump; its speed, radius and inertia are guesses";
    pump.addEventListener("click", () => (this.fill(PUMP), this.#ask()));
    place.append(...[...this.rows.values()].map(({ row }) => row), pump, this.said);
    this.report = new Report(place, () => (this.answer ? machineOf(this.written) ?? this.answer.machine : null));
    const convert = (machine, signal) => post("/v1/machines", machine, { signal });
    this.ofJob = new Latest(convert, (answer, machine) => this.#showOfJob(answer, machine), (error) => this.#fail(error));
    this.latest = new Latest(convert, (answer) => this.#show(answer), (error) => this.#fail(error));
    place.addEventListener("input", () => {
      clearTimeout(this.timer);
      this.timer = setTimeout(() => this.#ask(), WAIT_MS);
    });
  }

  /** @param {typeof FIELDS[number]} field */
  #row({ name, label, units, optional, means }) {
    const row = Object.assign(document.createElement("div"), { className: "field", title: `${label} ${means}` });
    const text = Object.assign(document.createElement("label"), { textContent: label, htmlFor: `machine-${name}` });
    const input = Object.assign(document.createElement("input"), { id: `machine-${name}`, inputMode: "decimal", autocomplete: "off", placeholder: optional ? "none" : "" });
    const hint = Object.assign(document.createElement("span"), { className: "hint", id: `machine-hint-${name}` });
    input.setAttribute("aria-describedby", hint.id);
    row.append(text, input);
    let unit = null;
    if (units.length) {
      unit = document.createElement("select");
      unit.setAttribute("aria-label", `unit of ${label.toLowerCase()}`);
      unit.append(...units.map((each) => new Option(each.replace("u", "µ").replace("^2", "²"), each)));
      row.append(unit);
    }
    row.append(hint);
    return { row, input, unit, hint };
  }

  /** What is written in the fields, as texts with units. @returns {Object<string, string>} */
  get written() {
    return Object.fromEntries([...this.rows].map(([name, { input, unit }]) => {
      const text = input.value.trim().replace(",", ".");
      return [name, text && unit ? `${text} ${unit.value}` : text];
    }));
  }

  /** Fill the fields. @param {Object<string, string>} machine */
  fill(machine) {
    for (const [name, { input, unit }] of this.rows) {
      const { number, unit: written } = parts(machine[name] ?? "");
      input.value = number;
      if (unit && written) unit.value = written;
    }
    this.place.open = true;
  }

  /** Show a machine of an address, whose oscillator the address has as well. @param {Object<string, string>} machine */
  async open(machine) {
    this.fill(machine);
    const request = machineOf(this.written);
    if (request) this.#take(await post("/v1/machines", request));
  }

  /** Show the machine of a job. What is written stays if it is that machine. @param {Object<string, any>} machine in SI */
  read(machine) {
    this.ofJob.drop();
    if (JSON.stringify(this.answer?.machine) === JSON.stringify(machine)) return;
    this.latest.drop();
    this.ofJob.want(machine);
  }

  #showOfJob(answer, machine) {
    const written = writtenOf(machine);
    this.fill(written ?? {});
    this.#take(answer);
    if (!written) this.#say(`The machine of this job has numbers for which there are no fields here. ${this.said.textContent}`, false);
    this.tell.changed();
  }

  /** A request with the machine that its oscillator is: its result then has SI units wherever it is opened. @param {BasinRequest} request */
  named(request) {
    if (!this.answer || !this.scalesOf(request.oscillator)) return request;
    const { machine, oscillator } = this.answer;
    // An address has fewer digits than the machine.
    const numbers = Object.fromEntries([...NUMBERS, "harmonics"].filter((name) => name in oscillator).map((name) => [name, oscillator[name]]));
    return { ...request, machine, oscillator: { ...request.oscillator, ...numbers } };
  }

  /** Offer what the service has besides, once its kinds of jobs are known. */
  offer() {
    this.report.offer();
  }

  /** What one unit of the model is, if an oscillator is that of the machine; null otherwise. @param {Oscillator|null} oscillator */
  scalesOf(oscillator) {
    return oscillator && this.answer && same(oscillator, this.answer.oscillator) ? this.answer.scales : null;
  }

  #ask() {
    this.ofJob.drop();
    const machine = machineOf(this.written);
    for (const { input, hint } of this.rows.values()) {
      input.removeAttribute("aria-invalid");
      hint.textContent = "";
      hint.classList.remove("wrong");
    }
    if (machine) return this.latest.want(machine);
    this.latest.drop();
    this.answer = null;
    this.#say("Fill in what has no “none”: the oscillator follows.", false);
    this.tell.changed();
  }

  #take(answer) {
    this.answer = answer;
    const { scales } = answer;
    const units = `One forcing period is ${inUnits(scales.time, "s")}, a speed of 1 is ${inUnits(scales.speed, "m/s")}, an impact power of 1 is ${inUnits(scales.power, "W")}.`;
    this.#say(`${gammaInWords(answer)} ${units}`, false);
  }

  #show(answer) {
    this.#take(answer);
    this.tell.converted(answer);
    this.tell.changed();
  }

  #fail(error) {
    this.answer = null;
    const errors = error instanceof Refusal ? error.errors : [];
    const elsewhere = errors.filter(({ location, message }) => {
      const row = this.rows.get(location[1]);
      if (!row) return true;
      row.input.setAttribute("aria-invalid", "true");
      row.hint.textContent = message.replace(/^Input should be /, "must be ");
      row.hint.classList.add("wrong");
      return false;
    });
    const message = errors.length ? elsewhere.map((each) => each.message).join("; ") : error.message;
    this.#say(message || "Not yet: see the field marked.", true);
    this.tell.changed();
  }

  #say(text, wrong) {
    this.said.textContent = text;
    this.said.classList.toggle("wrong", wrong);
    this.report.enable();
  }
}

/** Whether two oscillators are the same to the digits that a form has. */
function same(one, other) {
  const close = (a, b) => Math.abs(a - b) <= 1e-9 * Math.max(Math.abs(a), Math.abs(b));
  const numbers = (/** @type {Oscillator} */ oscillator) => [
    ...NUMBERS.map((name) => oscillator[name] ?? USUAL[name] ?? 0),
    ...(oscillator.harmonics ?? []).flatMap(({ order, amplitude, phase = 0 }) => [order, amplitude, phase]),
  ];
  const [mine, its] = [numbers(one), numbers(other)];
  return (one.model ?? "impacting") === other.model && mine.length === its.length && mine.every((value, i) => close(value, its[i]));
}

/** The form of the page. @param {ConstructorParameters<typeof MachineForm>[1]} tell */
export function machineForm(tell) {
  return new MachineForm(by("machine"), tell);
}
