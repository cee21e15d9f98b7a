/** What can be taken away: the picture that is seen, the tables, the request, the code that computes it. */

import { Filming } from "../film/filming.js";
import { captionOf } from "../look/caption.js";
import { pythonOf } from "../look/python.js";
import { get, pathOf, send } from "../net/api.js";
import { frame } from "../net/frame.js";
import { paintsText } from "../plane/session.js";
import { annotationFields } from "../state/annotations.js";
import { windowText } from "../state/address.js";
import { stepsOf } from "../state/steps.js";
import { hasCells } from "./still.js";
import { FIELDS, printingOf, USUAL } from "./paper.js";
import { pictureOf } from "./photograph.js";
import { asCsv, saveBlob } from "./save.js";
import { attempt } from "./say.js";

/** The size on paper that was last asked for. */
const paper = { ...USUAL };
const filming = new Filming(saveBlob);
/** The program and the paper to cite, once they are known. @type {{program: string, paper: string}|null} */
let cited = null;

function copyable(title, text) {
  const heading = document.createElement("h2");
  heading.textContent = title;
  const button = Object.assign(document.createElement("button"), { type: "button", textContent: "Copy" });
  button.setAttribute("aria-label", `Copy ${title}`);
  button.addEventListener("click", async () => {
    await navigator.clipboard.writeText(text);
    button.textContent = "Copied";
    setTimeout(() => (button.textContent = "Copy"), 1500);
  });
  heading.append(button);
  const code = document.createElement("pre");
  code.tabIndex = 0;
  code.setAttribute("aria-label", title);
  code.textContent = text;
  return [heading, code];
}

/** A file of the service. A plain link could not carry the key. */
async function fetched(path) {
  return (await send(path)).blob();
}

function historyCsv(motions) {
  const rows = [["motion", "time", "displacement", "velocity"]];
  for (const [name, { shown }] of motions.followed) {
    shown.time.forEach((time, i) => rows.push([name, time, shown.displacement[i], shown.velocity[i]]));
  }
  return asCsv(rows);
}

function sharesCsv(picture) {
  const shares = picture.shares();
  return asCsv([["solution", "share"], ...picture.outline.solutions.map(({ name, number }) => [name, shares[number]])]);
}

/** What the service's picture takes of what is seen, beside what makes it one for a paper. */
function asQuery({ layer, palette, window, overlays, panel, colours, annotated }) {
  const given = Object.entries({ layer, palette, window, overlays, panel, colours }).filter(([, value]) => value !== undefined);
  return [...given, ...(annotated ? annotationFields(annotated) : [])];
}

/** How the service makes a picture one for a paper. */
function printed() {
  return Object.entries({ ...printingOf(paper), editable: true, overlay_key: true, caption: true });
}

/** Files that can be saved: a title, a name, and how to get it. */
function filesOf({ job, plane, motions, title, caption, overlays, panel }) {
  const cells = !job || hasCells(job);
  const name = job ? `${job.kind}-${job.id.slice(0, 8)}` : "preview";
  const files = [];
  const drawn = (ending, query) => () => fetched(`${job.links.picture.replace(/png$/, ending)}?${new URLSearchParams([...query, ...printed()])}`);
  if (cells && plane.picture) files.push(["What is seen (PNG)", `${name}.png`, () => pictureOf(plane, { title, caption, overlays }, paper)]);
  const look = cells && job ? { ...plane.look, colours: plane.picture ? paintsText(plane.picture.outline.solutions, plane.look.palette) : undefined } : {};
  if (cells && job) {
    const query = asQuery({ ...look, window: windowText(plane.view), overlays: overlays.join(","), panel, annotated: plane.annotated });
    for (const ending of ["svg", "pdf"]) {
      files.push([`What is seen (${ending.toUpperCase()})`, `${name}.${ending}`, drawn(ending, query)]);
    }
  }
  if (cells && plane.picture) files.push(["Shares (CSV)", `${name}-shares.csv`, () => sharesCsv(plane.picture)]);
  if (motions.followed.size) files.push(["Histories (CSV)", `${name}-histories.csv`, () => historyCsv(motions)]);
  if (!job) return files;
  for (const ending of ["png", "svg", "pdf"]) {
    files.push([`Whole job (${ending.toUpperCase()})`, `${name}-whole.${ending}`, drawn(ending, asQuery(look))]);
  }
  files.push(["Table (CSV)", `${name}.csv`, () => fetched(`${job.links.result}.csv`)]);
  files.push(["Result (NetCDF)", `${name}.nc`, () => fetched(`${job.links.result}.nc`)]);
  return files;
}

/** Fields of a size on paper, as pictures are saved. */
function paperFields() {
  const set = Object.assign(document.createElement("fieldset"), { className: "paper" });
  set.append(Object.assign(document.createElement("legend"), { textContent: "Size on paper; empty: as on the screen" }));
  for (const [name, words] of FIELDS) {
    const label = Object.assign(document.createElement("label"), { textContent: words });
    const input = Object.assign(document.createElement("input"), { name, value: paper[name], inputMode: "decimal", autocomplete: "off" });
    input.addEventListener("input", () => (paper[name] = input.value));
    label.append(input);
    set.append(label);
  }
  return set;
}

/** What the plane shows, in sentences; empty where it shows no cells, or nothing is known of what to cite. */
function captionHere({ plane, job, oscillator }) {
  if (!plane.picture || !oscillator || !cited) return "";
  return captionOf({ oscillator, picture: plane.picture, view: plane.view, layer: plane.look.layer, iterations: job?.request.iterations ?? null, cited });
}

/** Show what can be taken away: at once, and with a caption as soon as it is known what to cite. */
export async function showTakeaway(place, given) {
  list(place, given);
  if (cited) return;
  cited = await get("explorer/citation.json");
  list(place, given);
}

function curlOf(job, request) {
  const url = new URL(pathOf(job ?? { kind: stepsOf(request).length ? "sweep" : "basin" }), location.href).href;
  return `curl -X POST ${url} \\\n  -H 'content-type: application/json' \\\n  -d '${JSON.stringify(request)}'`;
}

function list(place, given) {
  const seen = { ...given, caption: captionHere(given) };
  const { job, request } = seen;
  const files = document.createElement("p");
  files.className = "files";
  files.append(...filesOf(seen).map(([title, name, get]) => {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: title });
    button.addEventListener("click", () => attempt(async () => saveBlob(await get(), name)));
    return button;
  }));
  const blocks = seen.caption ? copyable("Caption", seen.caption) : [];
  // In a notebook nothing has an address.
  if (job && !frame) {
    const zarr = new URL(job.links.zarr, location.href).href;
    blocks.push(...copyable("Zarr store", zarr), ...copyable("Python", `import rattle\nresult = rattle.open("${zarr}")\nresult.rattle.plot()`));
  }
  // A design is a list of machines, which Python would give in other words.
  if (request.grid && !request.sample && !request.design) blocks.push(...copyable("Python that computes it", pythonOf(request)));
  if (!frame) blocks.push(...copyable("curl", curlOf(job, request)));
  blocks.push(...copyable("JSON", JSON.stringify(request, null, 1)));
  filming.offer(seen);
  place.replaceChildren(paperFields(), files, filming.place, ...blocks);
}
