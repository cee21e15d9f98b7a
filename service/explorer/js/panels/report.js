/** A report on the machine of the form: a job of its own beside what is seen, and a page to open when it is done. */

import { ended } from "../jobs/life.js";
import { stateInWords } from "../jobs/words.js";
import { get, hasKey, pathOf, post, Refusal, send } from "../net/api.js";
import { follow } from "../net/follow.js";
import { frame } from "../net/frame.js";
import { inWords } from "../page/say.js";
import { tolerancesIn } from "../state/machine.js";

const KIND = "report";
/** What may be asked besides, by the field of the request. */
const QUESTIONS = [
  { name: "rate", label: "Torque pulses: how often", placeholder: "none; as in 3 / hour" },
  { name: "size", label: "Torque pulses: size", placeholder: "none; as in 2 mN m s" },
  { name: "numbers", label: "Tolerances", placeholder: "none; as in backlash = 120 +- 20 um; restitution = 0.8 to 1" },
];

function make(tag, properties, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}

export class Report {
  /**
   * @param {HTMLElement} place
   * @param {() => object|null} machine request of the machine; null while there is none, or jobs refuse it
   */
  constructor(place, machine) {
    this.machine = machine;
    this.following = new AbortController();
    /** @type {Job|null} */
    this.job = null;
    this.inputs = new Map(QUESTIONS.map(({ name, placeholder }) => [name, make("input", { id: `report-${name}`, autocomplete: "off", placeholder })]));
    const rows = QUESTIONS.map(({ name, label }) => make("div", { className: "field long" }, make("label", { htmlFor: `report-${name}`, textContent: label }), this.inputs.get(name)));
    this.certain = make("input", { type: "checkbox", id: "report-certain" });
    const certain = make("label", { htmlFor: "report-certain" }, this.certain, " How fast teeth may part and fall quiet for certain, within all tolerances: some minutes more");
    this.button = make("button", { type: "button", id: "report-ask", textContent: "Report", title: "One page that prints: what the machine does, how loud, how often, and which tolerance is to blame" });
    this.cancel = make("button", { type: "button", id: "report-cancel", textContent: "Cancel the report", hidden: true });
    this.said = make("p", { className: "note", id: "report-said" });
    this.said.setAttribute("role", "status");
    this.done = make("p", { id: "report-done" });
    this.section = make("div", { id: "report", hidden: true }, ...rows, certain, this.button, this.cancel, this.said, this.done);
    // What is asked of the report changes nothing of the machine.
    this.section.addEventListener("input", (event) => event.stopPropagation());
    this.button.addEventListener("click", () => this.ask());
    this.cancel.addEventListener("click", () => this.job && post(this.job.links.cancel, {}).catch((error) => this.#say(inWords(error), true)));
    place.append(this.section);
  }

  /** Offer reports where the service has them. */
  offer() {
    this.section.hidden = !pathOf({ kind: KIND });
    this.enable();
  }

  /** The machine of the form has changed. */
  enable() {
    this.button.disabled = this.machine() === null;
  }

  /** Ask for a report on the machine that is written in the form. */
  async ask() {
    const machine = this.machine();
    if (!machine) return;
    this.following.abort();
    const { signal } = (this.following = new AbortController());
    this.done.replaceChildren();
    for (const input of this.inputs.values()) input.removeAttribute("aria-invalid");
    this.#say("Asking.");
    try {
      const job = await post(pathOf({ kind: KIND }), { machine, ...this.#questions() }, { signal });
      await follow(job, (now, place) => this.#show(now, place, signal), (error) => this.#say(inWords(error), true), signal);
    } catch (error) {
      if (!signal.aborted) this.#refused(error);
    }
  }

  /** What is written beside the machine. */
  #questions() {
    const written = [...this.inputs].map(([name, input]) => [name, input.value.trim()]).filter(([, text]) => text);
    const asked = Object.fromEntries(written.map(([name, text]) => [name, name === "numbers" ? tolerancesIn(text) : text]));
    return this.certain.checked ? { ...asked, certain: true } : asked;
  }

  #refused(error) {
    this.cancel.hidden = true;
    const errors = error instanceof Refusal ? error.errors : [];
    for (const { location } of errors) this.inputs.get(location[1])?.setAttribute("aria-invalid", "true");
    this.#say(errors.length ? errors.map(({ message }) => message).join("; ") : inWords(error), true);
  }

  async #show(job, place, signal) {
    this.job = job;
    this.cancel.hidden = ended(job) || job.state === "cancelling";
    if (job.state === "cancelled") return this.#say("The report was cancelled. The same request goes on from where it was.");
    const { text, wrong } = stateInWords(job, place);
    this.#say(text, wrong);
    if (job.state !== "succeeded") return;
    const { answers } = await get(job.links.result, { signal });
    this.#say(answers.join(" "));
    this.done.replaceChildren(this.#page(`${job.links.self}/report.html`));
  }

  /** The page, as a link; to be saved where a link leads nowhere: it carries no key, and a notebook has no addresses. */
  #page(path) {
    if (!hasKey() && !frame) return make("a", { href: path, target: "_blank", rel: "noopener", textContent: "Open the report" });
    const button = make("button", { type: "button", textContent: "Save the report" });
    button.addEventListener("click", async () => {
      try {
        const address = URL.createObjectURL(await (await send(path)).blob());
        make("a", { href: address, download: "report.html" }).click();
        setTimeout(() => URL.revokeObjectURL(address), 1000);
      } catch (error) {
        this.#say(inWords(error), true);
      }
    });
    return button;
  }

  #say(text, wrong = false) {
    this.said.textContent = text;
    this.said.classList.toggle("wrong", wrong);
  }
}
