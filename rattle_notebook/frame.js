/**
 * An explorer as an output of a notebook: a frame that holds the page's own modules, and whose requests Python answers.
 *
 * The page, its style and its modules come by the same messages as everything else, so that they are the service's.
 */

const EVENTS_MS = 500;
const HEIGHT = "min(85vh, 860px)";
/** Parts of a view that Python may say, and the traits that hold them. */
const PARTS = { address: "address", oscillator: "_oscillator", window: "window", departure: "departure", solution: "solution" };

/** A `fetch` whose requests are messages to Python. */
function asking(model) {
  // Answers reach all outputs of a widget; each has names of its own for what it asked.
  const output = Math.random().toString(36).slice(2);
  const asked = new Map();
  let count = 0;
  const answered = ({ id, status, headers }, buffers) => {
    const resolve = asked.get(id);
    if (!resolve) return;
    asked.delete(id);
    resolve(new Response([204, 304].includes(status) ? null : buffers[0], { status, headers }));
  };
  model.on("msg:custom", answered);
  const ask = (path, { method = "GET", headers = {}, body = null, signal = null } = {}) =>
    new Promise((resolve, reject) => {
      const id = `${output}-${++count}`;
      const stop = () => {
        asked.delete(id);
        reject(new DOMException("The request was aborted.", "AbortError"));
      };
      if (signal?.aborted) return stop();
      signal?.addEventListener("abort", stop, { once: true });
      // A stream of events would hold the kernel. Without one the page asks for the job itself, again and again.
      if (path.endsWith("/events")) return setTimeout(() => resolve(new Response(null, { status: 204 })), EVENTS_MS);
      asked.set(id, resolve);
      model.send({ id, method, path: path.startsWith("/") ? path : `/${path}`, headers, body });
    });
  return { ask, stop: () => model.off("msg:custom", answered) };
}

/** Text of the page for a frame without an address, in which modules cannot name each other by their paths. */
async function pageFor(ask) {
  const text = async (path) => (await ask(path)).text();
  const page = new DOMParser().parseFromString(await text("/"), "text/html");
  const links = [...page.querySelectorAll("link")];
  const hrefs = (rel) => links.filter((link) => link.rel === rel).map((link) => link.getAttribute("href"));
  const main = page.querySelector("script[type=module]");
  const [modules, styles] = [[...hrefs("modulepreload"), main.getAttribute("src")], hrefs("stylesheet")];
  const [sources, sheets] = await Promise.all([modules, styles].map((paths) => Promise.all(paths.map(text))));
  const named = (path, other) => `rattle${new URL(other, `http://rattle/${path}`).pathname}`;
  const imports = Object.fromEntries(modules.map((path, i) => {
    const source = sources[i].replaceAll(/^(import .* from )"(\.[^"]*)";$/gm, (_, of, other) => `${of}"${named(path, other)}";`);
    return [named("", path), URL.createObjectURL(new Blob([source], { type: "text/javascript" }))];
  }));
  for (const each of [...links, main]) each.remove();
  const add = (name, type, content) => page.head.append(Object.assign(page.createElement(name), { type, textContent: content }));
  for (const sheet of sheets) add("style", "text/css", sheet);
  add("script", "importmap", JSON.stringify({ imports }));
  add("script", "module", `import "${named("", main.getAttribute("src"))}";`);
  page.documentElement.classList.add("in-notebook");
  return { html: `<!doctype html>${page.documentElement.outerHTML}`, stop: () => Object.values(imports).forEach((url) => URL.revokeObjectURL(url)) };
}

async function render({ model, el }) {
  const { ask, stop: stopAsking } = asking(model);
  const told = Object.entries(PARTS);
  let telling = false;
  /** Shows what Python says, once the page listens; until then it is kept. */
  let hear = null;
  // What was set before anything was seen; afterwards the address has it all.
  const set = told.filter(([part]) => part !== "address").map(([part, trait]) => [part, model.get(trait)]);
  let unheard = model.get("history").length ? {} : Object.fromEntries(set.filter(([, value]) => value));
  const say = (parts) => {
    if (hear) hear(parts);
    else Object.assign(unheard, parts);
  };
  const changes = told.map(([part, trait]) => [`change:${trait}`, () => telling || say({ [part]: model.get(trait) })]);
  for (const [event, changed] of changes) model.on(event, changed);
  const compute = (message) => message.compute && say({ compute: true });
  model.on("msg:custom", compute);

  const frame = document.createElement("iframe");
  frame.title = "Explorer of gear-rattle";
  Object.assign(frame.style, { width: "100%", height: HEIGHT, border: "0", display: "block" });
  frame.rattle = {
    fetch: ask,
    // A frame that is moved in its notebook begins anew, where it was.
    get opening() {
      const [address, job] = [model.get("address"), model.get("job")];
      return address ? { address: job ? `${address}&job=${job}` : address } : model.get("_opening");
    },
    tell(seen) {
      telling = true;
      for (const [name, value] of Object.entries(seen)) model.set(PARTS[name] ?? name, value);
      telling = false;
      model.save_changes();
    },
    listen(heard) {
      hear = heard;
      const parts = unheard;
      unheard = {};
      if (Object.keys(parts).length) hear(parts);
    },
  };
  const { html, stop: forget } = await pageFor(ask);
  frame.srcdoc = html;
  el.append(frame);
  return () => {
    forget();
    stopAsking();
    model.off("msg:custom", compute);
    for (const [event, changed] of changes) model.off(event, changed);
  };
}

export default { render };
