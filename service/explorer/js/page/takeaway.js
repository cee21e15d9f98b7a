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

/** Fetched rather than linked to, as a link cannot carry the key. */
async function save(path, name) {
  const picture = URL.createObjectURL(await (await send(path)).blob());
  Object.assign(document.createElement("a"), { href: picture, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(picture), 1000);
}

/** Show what there is of a job. */
export function showTakeaway(place, job, layer) {
  const cells = hasCells(job);
  const png = Object.assign(document.createElement("button"), { type: "button", textContent: "Picture (PNG)" });
  png.addEventListener("click", () => save(cells ? `${job.links.picture}?layer=${layer}` : job.links.picture, `${job.kind}-${job.id.slice(0, 8)}.png`));
  const zarr = new URL(job.links.zarr, location.href).href;
  const first = (cells ? job.request.vary ?? [] : []).map(({ parameter }) => `${parameter}=0`).join(", ");
  const basin = first ? `basin.solution.isel(${first})` : "basin.solution";
  const python = cells
    ? `import xarray as xr\nbasin = xr.open_zarr("${zarr}")\n${basin}.plot()`
    : `import xarray as xr\nresult = xr.open_zarr("${zarr}")\nprint(result)`;
  const body = JSON.stringify(job.request, null, 1);
  const url = new URL(pathOf(job), location.href).href;
  const curl = `curl -X POST ${url} \\\n  -H 'content-type: application/json' \\\n  -d '${JSON.stringify(job.request)}'`;
  place.replaceChildren(png, ...copyable("Zarr store", zarr), ...copyable("Python", python), ...copyable("curl", curl), ...copyable("JSON", body));
}
