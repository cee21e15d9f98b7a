/** Where a box lies beside what it is about: on the side with the most room, and within the window. */

const GAP = 10;

/**
 * Left and top of a box beside a target.
 * @param {{left: number, top: number, right: number, bottom: number}} target
 * @param {{width: number, height: number}} box
 * @param {{width: number, height: number}} view
 */
export function placeBeside(target, box, view) {
  const clamp = (value, most) => Math.max(GAP, Math.min(value, most - GAP));
  const [middle, centre] = [(target.left + target.right - box.width) / 2, (target.top + target.bottom - box.height) / 2];
  const sides = [
    { room: view.height - target.bottom - box.height, left: middle, top: target.bottom + GAP },
    { room: target.top - box.height, left: middle, top: target.top - box.height - GAP },
    { room: view.width - target.right - box.width, left: target.right + GAP, top: centre },
    { room: target.left - box.width, left: target.left - box.width - GAP, top: centre },
  ];
  const { left, top } = sides.find(({ room }) => room >= 2 * GAP) ?? sides.reduce((best, side) => (side.room > best.room ? side : best));
  return { left: clamp(left, view.width - box.width), top: clamp(top, view.height - box.height) };
}

/** Move a box that is shown there. @param {HTMLElement} box @param {DOMRect} target */
export function besides(box, target) {
  const { left, top } = placeBeside(target, { width: box.offsetWidth, height: box.offsetHeight }, { width: innerWidth, height: innerHeight });
  [box.style.left, box.style.top] = [`${left}px`, `${top}px`];
}
