/** Downloads: the picture, the data, the request. */

import { pathOf, send } from "../net/api.js";
import { hasCells } from "./still.js";

function copyable(title, text) {
  const heading = document.createElement("h3");
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

/** Fetch a file and save it. A plain link could not carry the key. */
async function save(path, name) {
  const picture = URL.createObjectURL(await (await send(path)).blob());
  Object.assign(document.createElement("a"), { href: picture, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(picture), 1000);
}

const FILES = [["Picture (PNG)", "png"], ["SVG", "svg"], ["PDF", "pdf"], ["Table (CSV)", "csv"]];

/** Path of a file of a job: a picture, of cells in a layer, or the table of what is found. */
function fileOf(job, ending, layer) {
  if (ending === "csv") return job.links.result + ".csv";
  return job.links.picture.replace(/png$/, ending) + (layer ? `?layer=${layer}` : "");
}

/** Show the downloads of a job. */
export function showTakeaway(place, job, layer) {
  const cells = hasCells(job);
  const name = `${job.kind}-${job.id.slice(0, 8)}`;
  const downloads = FILES.map(([text, ending]) => {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: text });
    button.addEventListener("click", () => save(fileOf(job, ending, cells ? layer : null), `${name}.${ending}`));
    return button;
  });
  const zarr = new URL(job.links.zarr, location.href).href;
  const python = `import rattle\nresult = rattle.open("${zarr}")\nresult.rattle.plot()`;
  const body = JSON.stringify(job.request, null, 1);
  const url = new URL(pathOf(job), location.href).href;
  const curl = `curl -X POST ${url} \\\n  -H 'content-type: application/json' \\\n  -d '${JSON.stringify(job.request)}'`;
  place.replaceChildren(...downloads, ...copyable("Zarr store", zarr), ...copyable("Python", python), ...copyable("curl", curl), ...copyable("JSON", body));
}
