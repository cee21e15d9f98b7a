import assert from "node:assert/strict";
import { test } from "node:test";

import { inkOn, isMarked, loudnessPixels, paintNumbers, paintSolutions, paintTextures, placeOf, scaleColour, solutionPixels, specialPixel, texturesOf } from "../../service/explorer/js/plane/palette.js";

const bytesOf = (pixel) => [pixel & 255, (pixel >> 8) & 255, (pixel >> 16) & 255, (pixel >> 24) & 255];
const solution = (number, kind, paper, textures) => ({ number, kind, name: `${kind} ${number}`, colours: { paper }, textures: { paper: textures } });
const OUTLINE = {
  solutions: [solution(0, "permanent_contact", "#102030", 0), solution(1, "chaotic", "#814121", 2), solution(2, "periodic", "#f0e0d0", 1)],
  speckle: [0.5, 1, 1.5],
};
const LOOK = { palette: "paper", highlight: null, ground: "#ffffff" };

test("a pixel is red, green, blue and opaque, in this order", () => {
  assert.deepEqual(bytesOf(specialPixel("#010203")), [1, 2, 3, 255]);
});

test("cells have the colour of their solution, chaotic ones the brightness of their group, missing ones none", () => {
  const table = solutionPixels(OUTLINE, LOOK, 1), pixels = new Int32Array(8).fill(9);
  paintSolutions(pixels, [1, 0, 2, -1, 1, 1, 1, 1], [0, 4, 5, 1, 3, 4, 5, 3], table, 3, 1, 7);
  assert.deepEqual([pixels[0], pixels[7]], [9, 9], "before the first, after the last");
  assert.equal(pixels[3], 0);
  const seen = [...pixels].map((pixel) => bytesOf(pixel).slice(0, 3));
  assert.deepEqual([seen[1], seen[2]], [[0x10, 0x20, 0x30], [0xf0, 0xe0, 0xd0]]);
  assert.deepEqual(seen.slice(4, 7), [[65, 33, 17], [129, 65, 33], [194, 98, 50]]);
  paintSolutions(pixels, [1], [0], table, 3, 0, 1);
  assert.deepEqual(bytesOf(pixels[0]).slice(0, 3), [129, 65, 33], "the sink is plain");
});

test("all but the highlighted solution fade towards the ground", () => {
  const table = solutionPixels(OUTLINE, { ...LOOK, highlight: "permanent_contact 0" }, 1);
  assert.deepEqual(bytesOf(table[0]).slice(0, 3), [0x10, 0x20, 0x30]);
  // 0.86 of the way from 0xf0, 0xe0, 0xd0 to 0xff.
  assert.deepEqual(bytesOf(table[8]).slice(0, 3), [253, 251, 248]);
});

test("Hsu's numbers climb a scale from 0 to the highest; codes and missing cells stand apart", () => {
  const pixels = new Int32Array(6).fill(9), special = specialPixel("#ff0000");
  paintNumbers(pixels, [0, 2, 99, -1, 5, 5], [0, 0, 0, 0, -1, 0], "group", 99, special, 0, 5);
  const at = (place) => bytesOf(pixels[place]);
  assert.deepEqual(at(0), [0x44, 0x01, 0x54, 255]);
  assert.deepEqual(at(2), [0xfd, 0xe7, 0x25, 255]);
  // ln(1 + 2) / ln(1 + 99) of 255 steps is 60.8.
  const step = 61;
  assert.deepEqual(at(1).slice(0, 3), scaleColour(step / 255));
  assert.deepEqual([pixels[3], pixels[4], pixels[5]], [special, 0, 9]);
});

test("the scale passes its anchors, and ends where it ends", () => {
  assert.deepEqual([-1, 0, 0.25, 0.5, 0.75, 1, 2].map(scaleColour), [
    [0x44, 0x01, 0x54], [0x44, 0x01, 0x54], [0x3b, 0x52, 0x8b], [0x21, 0x91, 0x8c], [0x5e, 0xc9, 0x62], [0xfd, 0xe7, 0x25], [0xfd, 0xe7, 0x25],
  ]);
  assert.deepEqual(scaleColour(0.125), [0x40, 0x2a, 0x70]);
});

test("textures are lines up, lines down and dots", () => {
  const marked = (texture) => [0, 1, 2, 3, 4].map((row) => [0, 1, 2, 3, 4].filter((column) => isMarked(texture, column, row)));
  assert.deepEqual(marked(1), [[0], [1], [2], [3], [4]]);
  assert.deepEqual(marked(2), [[0], [4], [3], [2], [1]]);
  assert.deepEqual(marked(3), [[0, 4], [], [], [], [0, 4]]);
  assert.deepEqual(marked(0), [[], [], [], [], []]);
});

test("marks are counted from the lowest row, in ink that is seen on the colour", () => {
  const { texture, ink } = texturesOf(OUTLINE, LOOK);
  assert.deepEqual(texture, [0, 2, 1]);
  assert.deepEqual([inkOn("#814121"), inkOn("#f0e0d0"), inkOn("#ff0000"), inkOn("#00ff00"), inkOn("#ff8000")], ["#ffffff", "#000000", "#ffffff", "#000000", "#000000"]);
  // Two rows of three cells; the lowest is painted last.
  const pixels = new Int32Array(6).fill(9), cells = [1, 2, 2, 2, 1, 0];
  for (const from of [0, 3]) paintTextures(pixels, cells, { texture, ink }, 3, from, from + 3);
  assert.deepEqual([...pixels], [9, specialPixel("#000000"), 9, specialPixel("#000000"), 9, 9]);
  assert.equal(texturesOf({ ...OUTLINE, solutions: OUTLINE.solutions.slice(0, 1) }, LOOK), null);
});

test("steps have a logarithmic scale of their own, on which one and ten are far apart", () => {
  assert.deepEqual([placeOf("step", 0, 100), placeOf("step", 1, 100), placeOf("step", 100, 100)], [0, 0, 1]);
  assert.ok(Math.abs(placeOf("step", 10, 100) - 0.5) < 1e-9);
  assert.equal(placeOf("step", 1, 1), 0);
});

test("loudness has the colour of silence, of the loudest, and grey where it is not known", () => {
  const solutions = [0, 8, null, 4].map((impact_power) => ({ impact_power }));
  const [silent, loudest, unknown, half] = loudnessPixels({ solutions }, specialPixel("#8a8f98"));
  const scale = [0, 1, 128 / 255].map((place) => scaleColour(place));
  assert.deepEqual([silent, loudest, half].map((each) => [each & 255, (each >> 8) & 255, (each >> 16) & 255]), scale);
  assert.equal(unknown, specialPixel("#8a8f98"));
  assert.deepEqual([...loudnessPixels({ solutions: [{ impact_power: 0 }] }, 0)], [silent]);
});

test("a cell has its loudness whatever its group", () => {
  const pixels = new Int32Array(3);
  paintSolutions(pixels, [0, 0, -1], [0, 7, 3], Int32Array.of(42), 0, 0, 3);
  assert.deepEqual([...pixels], [42, 42, 0]);
});
