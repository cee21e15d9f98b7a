/** Text in lines. */

/**
 * Lines of a text that are no wider than there is room, if its words allow it.
 * @param {string} text
 * @param {number} room
 * @param {(text: string) => number} widthOf
 * @returns {string[]}
 */
export function wrapped(text, room, widthOf) {
  const lines = [];
  // A symbol, its sign of equality and its value stay together.
  for (const word of text.split(/(?<=[,:]) /)) {
    const longer = lines.length ? `${lines.at(-1)} ${word}` : word;
    if (lines.length && widthOf(longer) <= room) lines[lines.length - 1] = longer;
    else lines.push(word);
  }
  return lines;
}
