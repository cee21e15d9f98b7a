import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { placeBeside } from "../../service/explorer/js/help/beside.js";
import { TERMS } from "../../service/explorer/js/help/glossary.js";
import { STEPS } from "../../service/explorer/js/help/tour.js";
import { Gestures } from "../../service/explorer/js/plane/gestures.js";
import { doneBy, KEYS } from "../../service/explorer/js/plane/keys.js";

const page = readFileSync(new URL("../../service/explorer/index.html", import.meta.url), "utf8");
const guide = readFileSync(new URL("../../docs/guide/words.md", import.meta.url), "utf8");

/** As the guide writes it, which keeps to plain letters. */
function plain(text) {
  return text.replaceAll("β", "beta").replaceAll("−", "-").replaceAll("²", "^2").replaceAll("v*", "v*");
}

test("each word means on the page what it means in the guide", () => {
  for (const { word, means } of Object.values(TERMS)) {
    const row = guide.split("\n").find((line) => line.startsWith("|") && line.includes(plain(means)));
    assert.ok(row, `${word}: ${plain(means)}`);
    assert.ok(plain(word).split(" ").every((part) => row.includes(part)), `${word} is not in ${row}`);
  }
});

test("each word has its mark on the page, and each mark a word", () => {
  const marked = [...page.matchAll(/class="what" data-term="(\w+)"/g)].map(([, term]) => term);
  assert.deepEqual(marked.toSorted(), Object.keys(TERMS).toSorted());
});

test("the tour has five steps, each at something that is on the page", () => {
  assert.equal(STEPS.length, 5);
  for (const { at } of STEPS) assert.ok(page.includes(`id="${at.slice(1)}"`), at);
});

test("each key of the overview does something on the plane, and no other does", () => {
  const done = [];
  const plane = /** @type {any} */ ({
    view: { t0: 0, t1: 1, v0: 0, v1: 7 }, crossHair: { t: 0.5, v: 3 }, draw: () => {},
    go: () => done.push("window"), zoom: (factor) => done.push(factor < 1 ? "in" : "out"),
    tell: { annotated: (name) => done.push(name), whole: () => done.push("whole"), picked: (_, second) => done.push(second ? "second" : "first"), hovered: () => done.push("cross-hair") },
  });
  const canvas = /** @type {any} */ (new EventTarget());
  new Gestures(plane, /** @type {any} */ ({ place: (at) => at }), canvas);
  const press = (key, shiftKey) => {
    done.length = 0;
    const event = Object.assign(new Event("keydown", { cancelable: true }), { key, shiftKey });
    canvas.dispatchEvent(event);
    return event.defaultPrevented ? [...done] : null;
  };
  const results = KEYS.map(({ keys, shift }) => keys.map((key) => String(press(key, shift ?? false))));
  assert.deepEqual(results.map((each) => new Set(each).size), KEYS.map(() => 1));
  assert.deepEqual(results.map(([first]) => first), ["window", "cross-hair", "in", "out", "whole", "first", "second", "pin", "end", "unpin", ""]);
  assert.equal(plane.crossHair, null);
  assert.equal(press("Enter", false), null, "without a cross-hair there is nothing to follow");
  assert.equal(press("x", false), null);
  assert.equal(doneBy({ key: "0", shiftKey: false, ctrlKey: true }), null, "the browser's own");
});

test("a box lies beside its target and within the window", () => {
  const box = { width: 300, height: 120 };
  for (const view of [{ width: 1440, height: 900 }, { width: 360, height: 640 }]) {
    for (const target of [{ left: 0, top: 0, right: 40, bottom: 30 }, { left: 10, top: 50, right: view.width - 10, bottom: view.height - 10 }, { left: view.width - 60, top: view.height - 40, right: view.width, bottom: view.height }]) {
      const { left, top } = placeBeside(target, box, view);
      assert.ok(left >= 0 && top >= 0 && left + box.width <= view.width && top + box.height <= view.height);
    }
  }
  const { top } = placeBeside({ left: 500, top: 100, right: 600, bottom: 140 }, box, { width: 1440, height: 900 });
  assert.ok(top >= 140, "it does not cover what it is about");
});

test("a label lies within the frame, beside its point", async () => {
  globalThis.matchMedia = () => /** @type {any} */ ({ matches: false });
  const { drawAnnotations } = await import("../../service/explorer/js/plane/annotations.js");
  const written = [];
  const context = new Proxy({}, { get: (_, name) => (name === "measureText" ? () => ({ width: 90 }) : (...what) => name === "fillText" && written.push(what)), set: () => true });
  const plot = /** @type {any} */ ({ context, left: 40, width: 300, view: { t0: 0, t1: 1, v0: 0, v1: 7 }, x: (t) => 40 + 300 * t, y: (v) => 300 - 40 * v });
  drawAnnotations(plot, { notes: [{ t: 0.1, v: 3, label: "left" }, { t: 0.95, v: 3, label: "right" }], measures: [] });
  assert.deepEqual(written.map(([text, x]) => [text, Math.round(x)]), [["left", 79], ["right", 226]]);
});
