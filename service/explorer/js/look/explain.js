/** Motions in a sentence, for readers who do not know the symbols. */

function times(count, what) {
  return `${count === 0 ? "no" : count} ${what}${count === 1 ? "" : "s"}`;
}

const KINDS = {
  permanent_contact: "The teeth stay in contact: ever lower bounces, then no rattle at all.",
  chaotic: "Chaos: it rattles for ever and never repeats.",
  chaotic_transient: "A chaotic transient: it rattles without a pattern for long, and settles in the end.",
  undecided: "Where this ends could not be decided.",
};

/** Name of what has not settled in a first picture. */
export const UNSETTLED = "not settled yet";

/** What a solution is, in a sentence. */
export function solutionInWords({ kind, name }) {
  if (name === UNSETTLED) return "It has not settled within some hundred impacts. A finer picture says where it ends.";
  const parts = /^P\((\d+),(\d+),(\d+)\)/.exec(name);
  if (!parts) return KINDS[kind] ?? "";
  const [periods, upper, lower] = parts.slice(1).map(Number);
  const every = periods === 1 ? "every forcing period" : `every ${periods} forcing periods`;
  return `${name} repeats ${every}, with ${times(upper, "contact")} at +β and ${times(lower, "contact")} at −β.`;
}

/** What the marks on the plane are. */
export const MARKS = {
  plane: "Each point is a departure: a tooth leaves +β at phase t with speed v. Its colour is the motion it ends in.",
  attractors: "A cross is a departure of a motion that repeats; dots are departures of chaos.",
  grazing: "On this curve a departure just touches −β. Faster ones strike it.",
  preimages: "Departures that meet the grazing curve after one impact or more.",
  manifolds: "Stable manifolds of saddles: the borders between basins.",
  saddles: "Saddles: motions that repeat, but that no motion ends in.",
  group: "A group is a cycle of cells that the map runs through.",
};
