/** The page: connects its parts. What is seen is one state: the request, the window, the look, the motions. */

import { get, kindInWords, knowKinds, Refusal, Unreachable, whenKeyIsNeeded } from "./net/api.js";
import { frame } from "./net/frame.js";
import { Jobs } from "./jobs/jobs.js";
import { ended, hasStore } from "./jobs/life.js";
import { showCaption } from "./look/caption.js";
import { firstOf, sameOscillator, Screen } from "./look/screen.js";
import { by } from "./page/by.js";
import { enableSteps, enableTools, setUpControls } from "./page/controls.js";
import { askForKey } from "./page/login.js";
import { attempt, inWords, say } from "./page/say.js";
import { showState } from "./page/state.js";
import { hasCells, Still } from "./page/still.js";
import { listen, noteCompute, tell } from "./page/notebook.js";
import { showTakeaway } from "./page/takeaway.js";
import { Annotations } from "./panels/annotations.js";
import { Comparison } from "./panels/comparison.js";
import { Diagrams } from "./panels/diagrams.js";
import { Examples } from "./panels/examples.js";
import { Form } from "./panels/form.js";
import { Hover } from "./panels/hover.js";
import { legendTitle, showLegend } from "./panels/legend.js";
import { machineForm } from "./panels/machine.js";
import { Motions } from "./panels/motions.js";
import { Orbits } from "./panels/orbits.js";
import { OverlayList } from "./panels/overlay_list.js";
import { ParameterChart } from "./panels/parameter_chart.js";
import { Sweep } from "./panels/sweep.js";
import { Turn } from "./panels/turn.js";
import { Uncertainty } from "./panels/uncertainty.js";
import { Marks } from "./plane/marks.js";
import { Plane } from "./plane/plane.js";
import { additions, knowAdditions, maskNames } from "./state/additions.js";
import { decode, doubts, encode } from "./state/address.js";
import { entries } from "./state/entries.js";
import { stepsOf } from "./state/steps.js";
import { axesOf, limitOf, same, viewOf } from "./state/window.js";
import { setUpTheme } from "./page/theme.js";

const FIRST_EXAMPLE = "fig7bottom";
const REST_MS = 350;

/**
 * `request`: what is asked for, or would be. `edited`: it has not been asked for. `whole`: the window before zooming.
 * `opening`: what the address says, while it is opened; at first nothing is known of it. `refused`: the service has no
 * picture of what the form says. `offered`: what a link asks for, until something else is looked at. `doubts`: about the
 * address, in words. `asked`: addresses of all that was asked for. `walking`: a pointer moves over the chart of two
 * parameters, and the plane shows what is there. `reopened`: settles when what was seen before the pointer came is there again.
 */
const at = { request: null, edited: true, panel: 0, whole: { t0: 0, t1: 1, v0: 0, v1: 7 }, opening: {}, embed: false, axes: "model", rest: 0, sliding: false, refused: false, offered: null, doubts: "", asked: new Set(), walking: false, reopened: null };

const plane = new Plane([{ canvas: by("plane"), marks: by("marks") }, { canvas: by("plane-kept"), marks: by("marks-kept") }], { moved, hovered: (place) => hover.at(place), picked: (place, second) => oscillatorAt(place) && motions.pick(place, second), whole: () => plane.go(at.whole), annotated });
const marks = new Marks(plane);
const screen = new Screen(plane, { changed: pictureChanged, turned, left, failed: previewFailed, alone: () => ["idle", "refused"].includes(jobs.life.phase) });
const form = new Form(by("ask"), { submitted: compute, edited, bounds: (bounds) => turn.bound(bounds), part: (request) => screen.partOf(request), busy: () => screen.busy, sound });
const machine = machineForm({ converted, changed: () => (scaleAxes(), legend(), hover.read(), remember(false)) });
const turn = new Turn(by("turn"), (name, value) => slid(name, value), () => compute(form.request()));
const jobs = new Jobs({ changed: lifeChanged, begun, drawn });
const motions = new Motions(by("history"), plane, marks, () => screen.wanted, () => remember(false));
const hover = new Hover(plane, marks, oscillatorAt, (oscillator) => machine.scalesOf(oscillator), by("reading"));
const overlays = new OverlayList(by("overlays"), plane, () => remember(false));
const sweep = new Sweep(by("sweep"), openPanel, () => remember(true));
const still = new Still(by("still"));
const comparison = new Comparison({ button: by("keep"), range: by("swipe"), side: by("side"), frame: by("frame") }, plane, { seen: keptHere, changed: keptChanged, ended: () => motions.forgetKept(), failed: previewFailed });
const annotations = new Annotations({ button: by("annotate"), box: by("label") }, plane, () => remember(false));
const charts = {
  orbits: new Orbits({ oscillator: () => screen.oscillator, changed: remember, colour: (name) => plane.paintOf(name).colour, pick: (departure) => motions.pick(departure, false, true) }).panel,
  bifurcation: new Diagrams({ oscillator: () => screen.oscillator, changed: remember, paint: (name) => plane.paintOf(name), turn: turnTo }).panel,
  chart: new ParameterChart({ oscillator: () => screen.oscillator, changed: remember, paint: (name) => plane.paintOf(name), walk, back: walkedBack, turn: turnTo }).panel,
};
const uncertainty = new Uncertainty(() => plane.picture);
const examples = new Examples(by("preset"), by("examples"), by("preset-note"), showExample);

// What is asked for.

/** Something in the form has changed, by hand or by a slider that moves: a preview follows. */
function edited() {
  const oscillator = form.oscillator();
  const request = form.request(), { time, velocity } = request.grid;
  if (!oscillator || !(time.start < time.stop && velocity.start < velocity.stop)) return;
  [at.request, at.edited, at.offered, at.doubts] = [request, true, null, ""];
  // A zoom that has just ended would ask for what was in the form before, and put it back there.
  clearTimeout(at.rest);
  if (jobs.life.phase === "asking") jobs.leave();
  by("preset-note").textContent = "";
  if (!same(viewOf(request.grid), plane.view)) plane.lookAt((at.whole = viewOf(request.grid)));
  caption();
  if (at.sliding) return screen.look(oscillator, plane.view, true);
  screen.propose(oscillator);
  turn.show(oscillator);
  remember(false);
}

/** The service would take the oscillator and the window of the form, or would not. */
function sound(taken) {
  refuse(!taken);
  if (taken && screen.confirm()) lifeChanged(jobs.life);
}

/** There is no picture of what the form says, or there is again: the one that is seen is of other values. */
function refuse(refused) {
  at.refused = refused;
  by("frame").classList.toggle("old", refused);
  caption();
}

/** The form of a machine says what it is in the model: the oscillator, the window and k follow. */
function converted({ oscillator, velocity_stop: stop, iterations }) {
  const { time, velocity } = form.request().grid;
  const cells = (axis) => (typeof axis.cells === "number" ? axis.cells : 500);
  form.fill({ oscillator, grid: { time: { start: 0, stop: 1, cells: cells(time) }, velocity: { start: 0, stop, cells: cells(velocity) } }, iterations });
  form.take();
}

function slid(name, value) {
  at.sliding = true;
  form.set({ [name]: value });
  at.sliding = false;
}

/** Look at other values, and compute them. What is being opened anew comes first. @param {Object<string, number>} values */
async function turnTo(values) {
  at.walking = false;
  await at.reopened;
  form.set(values);
  compute(form.request());
}

/** Show the basin of other values while a pointer is there. @param {Object<string, number>} values */
function walk(values) {
  if (at.opening) return;
  [at.walking, at.sliding] = [true, true];
  form.set(values);
  at.sliding = false;
  const oscillator = form.oscillator();
  if (oscillator) turn.show(oscillator);
}

/** Show again what was seen before: the address has not changed meanwhile. */
function walkedBack() {
  if (!at.walking) return;
  at.walking = false;
  at.reopened = attempt(openAddress);
}

/** Ask for what the form describes, and first for a preview of it; or for what a link does, which may be more. */
function compute(request) {
  clearTimeout(at.rest);
  if (at.offered) return ask(at.offered);
  if (!same(viewOf(request.grid), plane.view)) plane.lookAt((at.whole = viewOf(request.grid)));
  screen.look(firstOf(request), plane.view);
  ask(request);
}

function ask(request) {
  [at.request, at.edited, at.panel, at.offered, at.doubts] = [request, false, 0, null, ""];
  at.asked.add(encode({ request }));
  remember(true);
  noteCompute();
  jobs.ask(machine.named(request));
}

function showExample(request) {
  jobs.leave();
  show(request);
  [at.edited, at.offered, at.doubts] = [false, null, ""];
  remember(true);
}

/** Show the window of a request, or a part of it, before its cells are there. */
function show(request, { view = null, whole = null } = {}) {
  form.fill(request);
  at.request = request;
  at.whole = whole ?? viewOf(request.grid);
  plane.lookAt(view ?? at.whole);
  turn.show(request.oscillator);
  screen.look(firstOf(request), plane.view);
}

/** The request for the window that is seen, with the oscillator that is seen. */
function requestHere() {
  const { grid, iterations } = form.request();
  const cells = { time: grid.time.cells, velocity: grid.velocity.cells };
  return { oscillator: screen.oscillator, grid: axesOf(plane.view, cells), iterations };
}

/** Something is pinned, measured or removed on the plane. */
function annotated(done, place, from) {
  if (done === "pin") annotations.pin(place);
  else if (done === "measure") annotations.measure(from, place);
  else if (done === "end") annotations.end(place);
  else annotations.drop(place);
}

/** The oscillator of the basin in which a place is. @param {Place} place */
function oscillatorAt(place) {
  return (plane.keptAt(place) ?? screen).oscillator;
}

/** What is seen, to be kept. */
function keptHere() {
  const { oscillator } = screen;
  if (!oscillator) return null;
  const job = at.edited || !jobs.job || !hasCells(jobs.job) ? null : jobs.job.id;
  return { oscillator, request: requestHere(), job, panel: at.panel };
}

function keptChanged() {
  scaleAxes();
  legend();
  motions.told();
  hover.read();
  remember(false);
}

/** The window has moved: cells of the store or a preview at once, and after a rest an entry of the history and a job that refines it. */
function moved(view) {
  clearTimeout(at.rest);
  [at.offered, at.doubts] = [null, ""];
  if (limitOf(view)) say(limitOf(view));
  if (!screen.oscillator) return;
  form.showWindow(requestHere().grid);
  plane.beside?.look(view);
  // A large basin is looked at more closely before it is computed anew.
  const refine = !screen.closer(view) && by("anew").checked;
  if (refine) screen.look(screen.oscillator, view);
  at.rest = setTimeout(() => {
    if (!refine) return remember(true);
    const request = requestHere();
    form.fill(request);
    ask(request);
  }, REST_MS);
}

// Jobs.

function lifeChanged(life) {
  showState(life, { progress: by("progress"), cancel: by("cancel") });
  caption();
}

/** Another job is shown. */
function begun(job) {
  still.hide();
  [at.edited, at.offered] = [false, null];
  const cells = hasCells(job);
  if (cells) {
    if (at.opening && !at.opening.request) show(job.request, at.opening);
    at.request = job.request;
    turn.show(screen.begin(job, at.panel));
  } else if (charts[job.kind]) {
    show(form.requestFor(job.request.oscillator));
    // What an address says of its chart comes with the other charts.
    if (!at.opening?.charts?.[charts[job.kind].chart.name]) charts[job.kind].show(job);
  } else {
    screen.clear();
  }
  const steps = cells ? stepsOf(job.request) : [];
  if (steps.length) sweep.show(steps, at.panel);
  else sweep.hide();
  enableTools(cells || job.kind in charts);
  if (job.request.machine && !job.request.design) machine.read(job.request.machine);
  remember(false);
}

/** Draw a job as far as it is computed. */
async function drawn(job, signal) {
  if (!hasCells(job)) {
    if (ended(job) && hasStore(job) && !charts[job.kind]) await still.show(job, signal);
    return;
  }
  const picture = await screen.draw(job, signal);
  if (!picture) return;
  overlays.of(picture.job, picture.panel, picture.outline.complete);
  if (stepsOf(job.request).length && !signal.aborted) await sweep.refresh(job, picture, plane.look.palette);
}

function openPanel(panel) {
  if (panel === at.panel) return;
  at.panel = panel;
  sweep.moveTo(panel);
  const oscillator = screen.begin(jobs.job, panel);
  turn.show(oscillator);
  screen.look(oscillator, plane.view);
  remember(true);
  jobs.again();
}

// What is seen.

function pictureChanged() {
  if (at.refused && sameOscillator(screen.oscillator, form.oscillator())) refuse(false);
  const mask = plane.picture?.masked?.mask;
  for (const name of maskNames()) overlays.offer(name, name === mask?.name);
  for (const chart of Object.values(charts)) chart.follow();
  uncertainty.follow();
  form.price();
  scaleAxes();
  legend();
  motions.told();
  hover.read();
  caption();
}

/** Another oscillator is seen: the motions that are followed start where they did. */
function turned() {
  overlays.forget();
  motions.renew();
}

/** What is seen is not what the job computes. A request that is on its way will say by itself what it replaces. */
function left() {
  if (jobs.life.phase === "asking") sweep.hide();
  else leave();
}

/** No job computes what is seen. */
function leave() {
  jobs.leave();
  sweep.hide();
}

function previewFailed(error) {
  if (error.name === "AbortError") return;
  // The form says why; but not that a preview takes too long.
  if (error instanceof Refusal && error.status === 422 && error.kind !== "limit-exceeded") return refuse(true);
  say(inWords(error), true);
  if (error instanceof Unreachable) form.doubt();
}

/** Axes count units of the machine that is seen; of two machines none. */
function scaleAxes(axes = at.axes) {
  at.axes = axes;
  plane.scales = axes === "machine" && !plane.beside ? machine.scalesOf(screen.oscillator) : null;
  plane.draw();
}

function legend() {
  const highlighted = (highlight) => {
    plane.restyle({ highlight });
    legend();
    remember(true);
  };
  by("legend-title").textContent = legendTitle(plane.picture, plane.look);
  const k = plane.picture?.job === jobs.job?.id ? jobs.job?.request.iterations : null;
  showLegend(by("legend"), plane.picture, plane.look, highlighted, machine.scalesOf(screen.oscillator), k);
  comparison.showLegend({ label: by("kept-label"), place: by("kept-legend") }, highlighted);
}

function caption() {
  const { job } = jobs;
  const kind = job && !hasCells(job) ? kindInWords(job) : null;
  showCaption({ shown: by("shown"), standing: by("standing") }, { kind, job, oscillator: screen.oscillator, picture: plane.picture, edited: at.edited, refused: at.refused, doubts: at.doubts });
}

function takeaway() {
  const request = jobs.job?.request ?? (at.request && machine.named(at.request));
  const seen = { plane, motions, title: by("shown").textContent, oscillator: screen.oscillator, overlays: overlays.drawn, panel: at.panel };
  if (request) attempt(() => showTakeaway(by("takeaway"), { job: at.edited ? null : jobs.job, request, ...seen }));
}

function restyle(look) {
  plane.restyle({ ...look, ground: getComputedStyle(document.documentElement).getPropertyValue("--plot").trim() });
  legend();
  sweep.repaint(plane.picture, plane.look.palette);
  for (const chart of Object.values(charts)) chart.repaint();
  hover.read();
  remember(false);
}

// The address.

/** Write what is seen to the address. */
function remember(isNew) {
  if (at.opening) return;
  // A basin that a pointer only passes over is not remembered; but what is seen of the charts is.
  if (at.walking) return void entries.write(encode({ ...decode(entries.address), charts: chartsSeen() }), isNew);
  const { layer, palette, highlight } = plane.look;
  const job = at.edited || jobs.life.phase === "asking" ? null : jobs.job;
  const pictured = job && !hasCells(job) ? {} : { request: at.request, view: plane.view, whole: at.whole };
  const seen = { embed: at.embed, axes: at.axes, job: job?.id, panel: at.panel, layer, palette, highlight, overlays: overlays.names, motions: motions.startsOf(false), annotated: plane.annotated, ...comparison.seen(motions.startsOf(true)), machine: machine.scalesOf(at.request?.oscillator ?? null) ? machine.written : null, charts: chartsSeen(), ...pictured };
  entries.write(encode(seen), isNew);
  tell(seen, isNew);
  enableSteps();
}

function chartsSeen() {
  return { diagram: charts.bifurcation.seen, orbits: charts.orbits.seen, parameters: charts.chart.seen, ...sweep.seen };
}

/** Show the charts below the plane that an address has. */
async function openCharts(seen) {
  sweep.look(seen);
  for (const [kind, panel] of Object.entries(charts)) {
    const { name } = panel.chart;
    if (seen[name] || jobs.job?.kind !== kind) await panel.open(seen[name]);
  }
}

/** Show what the address says; whether it says anything. */
async function openAddress() {
  const seen = (at.opening = decode(entries.address));
  at.doubts = doubts(entries.address).join(" ");
  const { job, request, panel, layer, palette, highlight } = seen;
  [at.panel, at.embed, at.axes] = [panel, seen.embed, seen.axes];
  document.documentElement.classList.toggle("embedded", at.embed);
  restyle({ layer, palette, highlight });
  [by("layer").value, by("palette").value, by("axes").value] = [layer, palette, seen.axes];
  overlays.choose(seen.overlays);
  annotations.show(seen.annotated);
  try {
    if (request) show(request, seen);
    if (seen.machine) await machine.open(seen.machine);
    // What this page has asked for may be asked for again. Of a link a preview is shown, which Compute refines.
    at.offered = request;
    const again = at.asked.has(encode({ request })) ? machine.named(request) : null;
    at.edited = false;
    if (job) await jobs.open(job, again).catch((error) => unopened(error, request));
    else if (again) jobs.ask(again);
    else if (request) leave();
    motions.forget();
    for (const [i, [t, v]] of seen.motions.entries()) await motions.pick({ t, v }, i > 0, true);
    await comparison.open(seen, motions);
    await openCharts(seen.charts);
  } finally {
    if (at.opening === seen) at.opening = null;
    enableSteps();
  }
  // A part of a request has been completed.
  if (request) remember(false);
  return Boolean(job || request);
}

/** The job of an address cannot be had: its request is looked at. */
function unopened(error, request) {
  if (!request || !(error instanceof Refusal)) throw error;
  leave();
  say(`${inWords(error)}: this is a preview of what its address asks for.`);
}

/** Open the address, or the first example where it says nothing, once the kinds of jobs are known. */
async function open(known, offered) {
  await known;
  if (await openAddress()) return;
  await offered;
  at.opening = {};
  const { doubts: unread } = at;
  examples.choose(FIRST_EXAMPLE);
  [at.opening, at.doubts] = [null, unread];
  if (unread) remember(false);
}

function start() {
  whenKeyIsNeeded(askForKey);
  setUpControls({ plane, jobs, restyle, axes: (axes) => (scaleAxes(axes), remember(false)), whole: () => plane.go(at.whole), takeaway });
  setUpTheme(by("theme"), () => restyle({}));
  const known = Promise.all([get("explorer/kinds.json"), get("explorer/additions.json")]).then(([kinds, found]) => {
    knowKinds(kinds);
    knowAdditions(found);
    form.offer();
    machine.offer();
    overlays.list(additions.map(({ mask }) => mask));
  });
  const offered = Promise.all([get("explorer/presets.json"), known]).then(([presets]) => examples.offer(presets));
  const show = async () => {
    await open(known, offered);
    if (frame) remember(false);
  };
  entries.whenTurned(() => attempt(show));
  listen({ show: () => attempt(show), compute: () => compute(form.request()) });
  return show();
}

attempt(start);
