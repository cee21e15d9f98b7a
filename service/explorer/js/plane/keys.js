/** Keys of the plane: what each does, for its handler and for the overview. */

/**
 * `shown` is how a reader sees the keys. With `shift` they count only with Shift, else without.
 * @type {{does: string, keys: string[], shift?: boolean, shown: string, words: string}[]}
 */
export const KEYS = [
  { does: "shift", keys: ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"], shift: true, shown: "Shift + arrows", words: "move the window" },
  { does: "point", keys: ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"], shift: false, shown: "arrows", words: "move the cross-hair" },
  { does: "nearer", keys: ["+", "="], shown: "+", words: "zoom in, about the cross-hair if there is one" },
  { does: "farther", keys: ["-"], shown: "−", words: "zoom out" },
  { does: "whole", keys: ["0"], shown: "0", words: "show the whole window" },
  { does: "pick", keys: ["Enter"], shown: "Enter", words: "follow the motion from the cross-hair" },
  { does: "second", keys: ["b"], shown: "b", words: "follow a second motion from there" },
  { does: "pin", keys: ["n"], shown: "n", words: "pin a point with a label at the cross-hair" },
  { does: "end", keys: ["d"], shown: "d, twice", words: "draw the distance between two places of the cross-hair" },
  { does: "unpin", keys: ["Delete", "Backspace"], shown: "Delete", words: "remove the annotation nearest to the cross-hair" },
  { does: "drop", keys: ["Escape"], shown: "Esc", words: "remove the cross-hair" },
];

/** What a key does on the plane; null if nothing. @param {{key: string, shiftKey: boolean, ctrlKey?: boolean, metaKey?: boolean, altKey?: boolean}} event */
export function doneBy({ key, shiftKey, ctrlKey, metaKey, altKey }) {
  if (ctrlKey || metaKey || altKey) return null;
  return KEYS.find(({ keys, shift }) => keys.includes(key) && (shift === undefined || shift === shiftKey))?.does ?? null;
}
