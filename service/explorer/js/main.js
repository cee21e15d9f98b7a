/** The page: connects its parts. */

import { get, pathOf, post, send, whenKeyIsNeeded } from "./net/api.js";
import { readAddress, writeAddress } from "./net/address.js";
import { ended, follow } from "./net/follow.js";
import { Form } from "./panels/form.js";
import { showLegend } from "./panels/legend.js";
import { askForKey } from "./page/login.js";
import { Motions } from "./panels/motions.js";
import { OverlayList } from "./panels/overlay_list.js";
import { Picture } from "./plane/picture.js";
import { Plane } from "./plane/plane.js";
import { listRecent } from "./page/recent.js";
import { attempt, inWords, say } from "./page/say.js";
import { stateInWords, showProgress } from "./page/state.js";
import { hasCells, Still } from "./page/still.js";
import { Sweep } from "./panels/sweep.js";
import { showTakeaway } from "./page/takeaway.js";
import { colour, setUpTheme } from "./page/theme.js";
import { reading } from "./charts/ticks.js";

const FIRST_PRESET = "fig7bottom";
const ZOOM_REST_MS = 350;

const by = (id) => document.getElementById(id);
const at = { job: null, panel: 0, result: null, following: null, zoom: null, mine: null, whole: null, pointed: null };

const plane = new Plane(by("plane"), {
  moved, hovered, picked: (place, second) => at.job && motions.pick(place, second), whole: showWhole,
});
const form = new Form(by("ask"), (request) => submit(request, false));
const sweep = new Sweep(by("sweep"), openPanel);
const motions = new Motions(by("history"), plane, oscillatorHere);
const overlays = new OverlayList(by("overlays"), plane);
const still = new Still(by("still"));

/** Return to the requested window, before any zooming. */
function showWhole() {
  if (at.whole) plane.go(at.whole);
}

// Jobs.

async function submit(request, zooming) {
  clearTimeout(at.zoom);
  await attempt(async () => {
    await withdraw();
    const answer = await send(pathOf({ kind: request.vary ? "sweep" : "basin" }), {
      method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(request),
    });
    const job = await answer.json();
    // The same request may belong to another client's job. Only a new job is ours to cancel.
    at.mine = Date.parse(job.created) >= Date.parse(answer.headers.get("date")) - 1000 ? job.id : null;
    await open(job, 0, zooming ? plane.view : null, zooming);
  });
}

/** Cancel a job of this page that is no longer shown. */
async function withdraw() {
  const superseded = at.mine && at.job?.id === at.mine && !ended(at.job);
  at.mine = null;
  // If it cannot be cancelled it continues, and the next one is computed anyway.
  if (superseded) await post(at.job.links.cancel, {}).catch(() => {});
}

/**
 * Show a job.
 * @param {object} job
 * @param {number} panel
 * @param {object|null} view null for the job's own window
 * @param {boolean} over whether older pictures stay underneath
 */
async function open(job, panel, view, over) {
  at.following?.abort();
  const { signal } = (at.following = new AbortController());
  const same = over && sameOscillator(at.job?.request, job.request);
  if (!same) motions.forget();
  if (!same) overlays.forget();
  if (!over) plane.clear();
  still.hide();
  [at.job, at.panel, at.result] = [job, panel, null];
  if (hasCells(job)) lookAt(job, view, over);
  writeAddress({ job: job.id, panel, view }, true);
  if (hasCells(job) && job.request.vary) sweep.show(job.request.vary, panel);
  else sweep.hide();
  showTakeaway(by("takeaway"), job, plane.look.layer);
  showTools();
  await watch(job, panel, signal);
}

function lookAt(job, view, over) {
  const { time, velocity } = job.request.grid;
  const asked = { t0: time.start, t1: time.stop, v0: velocity.start, v1: velocity.stop };
  if (!over) at.whole = asked;
  plane.lookAt(view ?? asked);
}

function sameOscillator(one, other) {
  return JSON.stringify(one?.oscillator) === JSON.stringify(other.oscillator);
}

function tell(job, place) {
  const { text, wrong } = stateInWords(job, place);
  say(text, wrong);
  showProgress(by("progress"), job);
  by("cancel").hidden = ended(job) || job.state === "cancelling";
}

/** Follow a job, and draw one of its basins as it is computed. */
async function watch(job, panel, signal) {
  let picture = null;
  const report = async (now, place) => {
    at.job = now;
    // Completion is announced below, once the picture is complete.
    if (!ended(now)) tell(now, place);
    // A job has a store once it has reported progress.
    if (!hasCells(now)) {
      if (ended(now) && now.progress) await still.show(now, signal);
    } else if (now.progress) {
      picture ??= await begin(now, panel, signal);
      if (picture && !signal.aborted) await draw(picture, now, signal);
    }
    if (!signal.aborted) tell(now, place);
  };
  const lost = (error) => say(`${inWords(error)}; trying again.`, true);
  await attempt(() => follow(job, report, lost, signal));
}

async function begin(job, panel, signal) {
  try {
    const picture = await Picture.open(job.id, panel);
    if (!signal.aborted) plane.show(picture);
    return picture;
  } catch (error) {
    // The store of a cancelled job may have passed to the next job of the same request.
    if (error.kind === "not-ready") return null;
    throw error;
  }
}

async function draw(picture, job, signal) {
  await picture.refresh(ended(job), (tile) => {
    if (!signal.aborted) plane.arrived(picture, tile);
  }, signal);
  if (signal.aborted) return;
  plane.draw();
  legend();
  read();
  overlays.of(picture.job, picture.panel, picture.outline.complete);
  await motions.again();
  if (job.request.vary) await chartShares(picture, job);
}

async function chartShares(picture, job) {
  const done = job.progress.basins_done;
  if (!at.result || at.charted !== done) {
    at.result = await get(job.links.result);
    at.charted = done;
  }
  if (at.job.id === job.id && sweep.vary) sweep.draw(at.result, picture.outline, plane.look.palette);
}

function openPanel(panel) {
  if (panel === at.panel) return;
  motions.forget();
  overlays.forget();
  at.following?.abort();
  const { signal } = (at.following = new AbortController());
  at.panel = panel;
  plane.clear();
  sweep.moveTo(panel);
  writeAddress({ job: at.job.id, panel, view: null }, true);
  watch(at.job, panel, signal);
}

// The window.

/** The request for the visible window of the current oscillator. */
function requestHere() {
  const { request } = at.job;
  const { time, velocity } = request.grid;
  const digits = (value) => Number(value.toPrecision(12));
  const { t0, t1, v0, v1 } = plane.view;
  return {
    oscillator: oscillatorHere(),
    grid: {
      time: { start: digits(t0), stop: digits(t1), cells: time.cells },
      velocity: { start: digits(v0), stop: digits(v1), cells: velocity.cells },
    },
    iterations: request.iterations,
  };
}

function oscillatorHere() {
  return { ...at.job?.request.oscillator, ...plane.picture?.outline.parameters };
}

function moved(view) {
  clearTimeout(at.zoom);
  if (!at.job || !hasCells(at.job)) return;
  if (!by("anew").checked) writeAddress({ job: at.job.id, panel: at.panel, view }, true);
  else at.zoom = setTimeout(() => submit(requestHere(), true), ZOOM_REST_MS);
}

function hovered(place) {
  if (place) at.pointed = place;
  read();
}

/** Show what is known of the point last pointed at. */
function read() {
  const place = at.pointed;
  if (!place) return;
  const { t0, t1, v0, v1 } = plane.view;
  const known = plane.at(place.t, place.v);
  const phase = place.t - Math.floor(place.t);
  const where = `t = ${reading(phase, t1 - t0)}   v = ${reading(place.v, v1 - v0)}`;
  const what = known ? `   ${known.solution.name}   step ${known.step}, group ${known.group}, period ${known.period}` : "   not known yet";
  by("reading").textContent = where + (at.job ? what : "");
}

function legend() {
  showLegend(by("legend"), plane.picture, plane.look, (highlight) => {
    plane.restyle({ highlight });
    legend();
  });
}

function showTools() {
  by("empty").hidden = at.job !== null;
  for (const id of ["back", "forward", "in", "out", "whole", "box", "layer"]) by(id).disabled = !at.job || !hasCells(at.job);
}

// Setting up.

function restyle(look) {
  plane.restyle({ ...look, ground: colour("plot") });
  legend();
  if (at.result && plane.picture) sweep.draw(at.result, plane.picture.outline, plane.look.palette);
}

function setUpControls() {
  by("cancel").addEventListener("click", () => attempt(() => post(at.job.links.cancel, {})));
  by("back").addEventListener("click", () => history.back());
  by("forward").addEventListener("click", () => history.forward());
  by("in").addEventListener("click", () => plane.zoom(0.7));
  by("out").addEventListener("click", () => plane.zoom(1 / 0.7));
  by("whole").addEventListener("click", showWhole);
  const toggle = (button) => {
    const on = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", String(on));
    return on;
  };
  by("box").addEventListener("click", () => (plane.boxing = toggle(by("box"))));
  by("layer").addEventListener("change", () => {
    restyle({ layer: by("layer").value });
    if (at.job) showTakeaway(by("takeaway"), at.job, plane.look.layer);
  });
  by("palette").addEventListener("change", () => restyle({ palette: by("palette").value }));
  setUpTheme(by("theme"), () => restyle({}));
  by("recent").addEventListener("toggle", () => by("recent").open && attempt(() => listRecent(by("recent").querySelector("ul"))));
  addEventListener("popstate", () => attempt(openAddress));
}

/** Open what the address names. */
async function openAddress() {
  const { job: id, panel, view } = readAddress();
  if (!id) return;
  const job = await get(`/v1/jobs/${id}`);
  if (job.request.grid) form.fill(job.request);
  by("preset").value = "";
  await open(job, panel, view, sameOscillator(at.job?.request, job.request) && panel === at.panel);
}

async function start() {
  whenKeyIsNeeded(askForKey);
  setUpControls();
  showTools();
  const offered = get("explorer/presets.json").then((presets) => form.offer(presets, readAddress().job ? "" : FIRST_PRESET));
  await Promise.all([offered, openAddress()]);
}

attempt(start);
