/** What can be taken away: the picture that is seen, the tables, the request, the code that computes it. */

import { pythonOf } from "../look/python.js";
import { pathOf, send } from "../net/api.js";
import { frame } from "../net/frame.js";
import { windowText } from "../state/address.js";
import { stepsOf } from "../state/steps.js";
import { hasCells } from "./still.js";
import { pictureOf } from "./photograph.js";
import { asCsv, saveBlob } from "./save.js";
import { attempt } from "./say.js";

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

/** What the service's picture takes of what is seen. */
function asQuery({ layer, palette, window, overlays, panel }) {
  const given = Object.entries({ layer, palette, window, overlays, panel }).filter(([, value]) => value !== undefined);
  return `?${new URLSearchParams(given)}`;
}

/** Files that can be saved: a title, a name, and how to get it. */
function filesOf({ job, plane, motions, caption, overlays, panel }) {
  const cells = !job || hasCells(job);
  const name = job ? `${job.kind}-${job.id.slice(0, 8)}` : "preview";
  const files = [];
  const drawn = (ending, query) => () => fetched(`${job.links.picture.replace(/png$/, ending)}${query}`);
  if (cells && plane.picture) files.push(["What is seen (PNG)", `${name}.png`, () => pictureOf(plane, caption)]);
  if (cells && job) {
    const query = asQuery({ ...plane.look, window: windowText(plane.view), overlays: overlays.join(","), panel });
    for (const ending of ["svg", "pdf"]) {
      files.push([`What is seen (${ending.toUpperCase()})`, `${name}.${ending}`, drawn(ending, query)]);
    }
  }
  if (cells && plane.picture) files.push(["Shares (CSV)", `${name}-shares.csv`, () => sharesCsv(plane.picture)]);
  if (motions.followed.size) files.push(["Histories (CSV)", `${name}-histories.csv`, () => historyCsv(motions)]);
  if (!job) return files;
  for (const ending of ["png", "svg", "pdf"]) {
    files.push([`Whole job (${ending.toUpperCase()})`, `${name}-whole.${ending}`, drawn(ending, cells ? asQuery(plane.look) : "")]);
  }
  files.push(["Table (CSV)", `${name}.csv`, () => fetched(`${job.links.result}.csv`)]);
  return files;
}

/** Show what can be taken away. */
export function showTakeaway(place, seen) {
  const { job, request } = seen;
  const files = document.createElement("p");
  files.className = "files";
  files.append(...filesOf(seen).map(([title, name, get]) => {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: title });
    button.addEventListener("click", () => attempt(async () => saveBlob(await get(), name)));
    return button;
  }));
  const blocks = [];
  // In a notebook nothing has an address.
  if (job && !frame) {
    const zarr = new URL(job.links.zarr, location.href).href;
    blocks.push(...copyable("Zarr store", zarr), ...copyable("Python", `import rattle\nresult = rattle.open("${zarr}")\nresult.rattle.plot()`));
  }
  // A design is a list of machines, which Python would give in other words.
  if (request.grid && !request.sample && !request.design) blocks.push(...copyable("Python that computes it", pythonOf(request)));
  blocks.push(...copyable("JSON", JSON.stringify(request, null, 1)));
  place.replaceChildren(files, ...blocks);
  if (frame) return;
  const url = new URL(pathOf(job ?? { kind: stepsOf(request).length ? "sweep" : "basin" }), location.href).href;
  const curl = `curl -X POST ${url} \\\n  -H 'content-type: application/json' \\\n  -d '${JSON.stringify(request)}'`;
  place.append(...copyable("curl", curl));
}
