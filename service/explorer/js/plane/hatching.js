/** Hatching of tiles without labels: crossed if nothing is known, single if the cells are mapped. */

const LABELLED = 3;
const PENDING = 1;
const SIZE = 12;

function pattern(context, crossed) {
  const tile = document.createElement("canvas");
  tile.width = tile.height = SIZE;
  const pen = tile.getContext("2d");
  pen.strokeStyle = "rgb(120 126 136 / 60%)";
  pen.lineWidth = 1;
  pen.beginPath();
  pen.moveTo(-1, SIZE + 1);
  pen.lineTo(SIZE + 1, -1);
  if (crossed) {
    pen.moveTo(-1, -1);
    pen.lineTo(SIZE + 1, SIZE + 1);
  }
  pen.stroke();
  return context.createPattern(tile, "repeat");
}

/** Hatch a picture's missing tiles. */
export function hatchMissing(plot, picture) {
  const { context } = plot;
  const patterns = new Map();
  picture.states.forEach((state, tile) => {
    if (state === LABELLED && picture.there.has(tile)) return;
    const crossed = state === PENDING;
    if (!patterns.has(crossed)) patterns.set(crossed, pattern(context, crossed));
    const { left, top, right, bottom } = picture.rectangle(tile);
    const { t0, v0 } = picture.view;
    const x = plot.x(t0 + left * picture.cellTime), y = plot.y(v0 + bottom * picture.cellVelocity);
    context.fillStyle = patterns.get(crossed);
    context.fillRect(x, y, plot.x(t0 + right * picture.cellTime) - x, plot.y(v0 + top * picture.cellVelocity) - y);
  });
}
