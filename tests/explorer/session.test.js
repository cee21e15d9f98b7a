import assert from "node:assert/strict";
import { test } from "node:test";

import { isMarked, paintTextures, texturesOf } from "../../service/explorer/js/plane/palette.js";
import { POOLS, TEXTURES } from "../../service/explorer/js/plane/pools.js";
import { inKeptColours, paintOfName, paintsText } from "../../service/explorer/js/plane/session.js";

const POOL = POOLS.colour_blind;
const OWN = { "permanent contact": "#141f40", "P(1,1,0)": "#56b4e9" };

/** A basin as the service sends it: motions without a colour of their own take those of the pool in order. */
function basin(shares) {
  let next = 0;
  const solutions = Object.entries(shares).map(([name, share], number) => {
    const place = OWN[name] ? 0 : next++;
    const colour = OWN[name] ?? POOL[place % POOL.length];
    const texture = Math.floor(place / POOL.length);
    return { number, name, kind: "periodic", share, colours: { paper: "#000080", colour_blind: colour }, textures: { paper: 0, colour_blind: texture } };
  });
  return /** @type {any} */ ({ solutions, speckle: [1] });
}

function paintsOf(outline) {
  return Object.fromEntries(outline.solutions.map(({ name, colours, textures }) => [name, `${colours.colour_blind} ${textures.colour_blind}`]));
}

test("a motion keeps its colour by name while others come and go", () => {
  const session = new Map();
  const first = paintsOf(inKeptColours(basin({ "permanent contact": 0.4, "P(2,2,2)": 0.4, "P(3,3,0)": 0.2 }), session));
  const second = paintsOf(inKeptColours(basin({ "P(1,1,0)": 0.3, "P(1,1,1)": 0.2, "P(3,3,0)": 0.5 }), session));
  assert.equal(second["P(3,3,0)"], first["P(3,3,0)"]);
  assert.notEqual(second["P(1,1,1)"], first["P(2,2,2)"], "a colour that no name has had comes first");
  assert.equal(second["P(1,1,0)"], "#56b4e9 0");
});

test("of two motions that had one colour the larger share keeps it", () => {
  for (const [small, large] of [["P(2,2,2)", "P(3,3,0)"], ["P(3,3,0)", "P(2,2,2)"]]) {
    const had = { colour: POOL[2], texture: 0 };
    const session = new Map([["colour_blind", new Map([["P(2,2,2)", had], ["P(3,3,0)", had]])]]);
    const paints = paintsOf(inKeptColours(basin({ "P(2,2,2)": small === "P(2,2,2)" ? 0.2 : 0.6, "P(3,3,0)": small === "P(3,3,0)" ? 0.2 : 0.6 }), session));
    assert.equal(paints[large], `${POOL[2]} 0`);
    assert.notEqual(paints[small], paints[large]);
  }
});

test("a motion that is new has the colour that the service offers, if that is free", () => {
  const outline = basin({ "P(2,2,2)": 1 });
  outline.solutions[0].colours.colour_blind = POOL[3];
  assert.equal(paintsOf(inKeptColours(outline, new Map()))["P(2,2,2)"], `${POOL[3]} 0`);
});

test("there are as many paints as colours and textures", () => {
  assert.deepEqual(TEXTURES, [0, 1, 2, 3]);
  const names = Array.from({ length: POOL.length * 4 }, (_, i) => `P(${i + 1},1,0)`).filter((name) => !OWN[name]);
  const paints = paintsOf(inKeptColours(basin(Object.fromEntries(names.map((name) => [name, 0.1]))), new Map()));
  assert.equal(new Set(Object.values(paints)).size, names.length);
});

test("a diagram and a basin have one colour for a name", () => {
  const session = new Map();
  const early = paintOfName("P(5,5,3)", "colour_blind", session).colour;
  const basinHas = paintsOf(inKeptColours(basin({ "P(2,2,2)": 0.6, "P(5,5,3)": 0.4 }), session));
  assert.equal(basinHas["P(5,5,3)"], `${early} 0`);
  assert.equal(paintOfName("P(2,2,2)", "colour_blind", session).colour, basinHas["P(2,2,2)"].split(" ")[0]);
  assert.equal(paintOfName("chaotic", "colour_blind", session).colour, "#d55e00");
});

test("whatever was seen before, no two motions of a basin are painted alike", () => {
  const session = new Map();
  let seed = 1;
  const random = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
  for (let round = 0; round < 200; round++) {
    const names = [...Object.keys(OWN), ...Array.from({ length: 12 }, () => `P(${Math.ceil(9 * random())},${Math.ceil(9 * random())},0)`)];
    const shares = Object.fromEntries([...new Set(names)].map((name) => [name, random()]));
    const outline = inKeptColours(basin(shares), session);
    const paints = paintsOf(outline);
    assert.equal(new Set(Object.values(paints)).size, Object.keys(shares).length);
    const largest = outline.solutions.filter(({ name }) => !OWN[name]).sort((a, b) => b.share - a.share);
    assert.equal(new Set(largest.slice(0, 5).map(({ name }) => paints[name])).size, Math.min(5, largest.length));
  }
});

test("cells of a colour that is used again are marked", () => {
  const solutions = [0, 1, 2, 3].map((texture, number) => ({ number, name: `${number}`, kind: "periodic", colours: { paper: "#ffffff" }, textures: { paper: texture } }));
  const look = { palette: "paper", highlight: null, ground: "#ffffff", layer: "solution" };
  const textures = texturesOf(/** @type {any} */ ({ solutions }), look);
  for (const texture of [0, 1, 2, 3]) {
    const solution = new Int16Array(400).fill(texture), pixels = new Int32Array(400).fill(-1);
    for (let row = 0; row < 20; row++) paintTextures(pixels, solution, textures, 20, 20 * row, 20 * row + 20);
    const marked = pixels.reduce((sum, pixel) => sum + Number(pixel !== -1), 0);
    assert.equal(marked, [0, 80, 80, 25][texture]);
  }
  assert.ok(isMarked(1, 7, 7) && isMarked(2, 7, 3) && !isMarked(1, 7, 3));
  assert.equal(texturesOf(/** @type {any} */ ({ solutions: solutions.slice(0, 1) }), look), null);
});

test("a picture of the service is asked for in the colours that motions have here", () => {
  const session = new Map([["colour_blind", new Map([["P(2,2,2)", { colour: POOL[3], texture: 2 }]])]]);
  const outline = inKeptColours(basin({ "permanent contact": 0.4, "P(2,2,2)": 0.3, "P(3,3,0)": 0.3 }), session);
  outline.solutions[0].kind = "permanent_contact";
  const other = paintOfName("P(3,3,0)", "colour_blind", session);
  assert.equal(paintsText(outline.solutions, "colour_blind"), `P(2,2,2):${POOL[3].slice(1)}/2;P(3,3,0):${other.colour.slice(1)}`);
});
