/** What a mask marks of a picture: paler, and hatched by lines that are as far apart at any zoom. */

// A pale cell is known for one where nothing else is seen of it; lines tell it from a motion of a pale colour.
const VEIL = "rgb(255 255 255 / 62%)";
const LINES = "rgb(40 40 40 / 85%)";
const APART = 9;

const stage = document.createElement("canvas");

/** A canvas with a pixel for each cell, as opaque as the part of the cell that is veiled. */
export class Veil {
  /** @param {import("./masked.js").Masked} masked */
  constructor(masked, width, height) {
    this.masked = masked;
    this.canvas = Object.assign(document.createElement("canvas"), { width, height });
    this.context = this.canvas.getContext("2d");
  }

  /** Paint a rectangle of pixels anew. */
  paint(left, top, width, height) {
    const image = this.context.createImageData(width, height);
    for (let y = 0; y < height; y++) {
      for (let x = 0; x < width; x++) {
        image.data[4 * (y * width + x) + 3] = 255 * this.masked.veiled((top + y) * this.canvas.width + left + x);
      }
    }
    this.context.putImageData(image, left, top);
  }
}

/** The veil with its lines, as crisp as the screen. */
function hatchOf(context, ratio) {
  const size = Math.round(APART * ratio);
  const tile = Object.assign(document.createElement("canvas"), { width: size, height: size });
  const pen = tile.getContext("2d");
  pen.fillStyle = VEIL;
  pen.fillRect(0, 0, size, size);
  pen.strokeStyle = LINES;
  pen.lineWidth = ratio;
  pen.beginPath();
  for (const shift of [-size, 0, size]) {
    pen.moveTo(shift - 1, -1);
    pen.lineTo(shift + size + 1, size + 1);
  }
  pen.stroke();
  return context.createPattern(tile, "repeat");
}

/**
 * Lay the veil over what a mask marks of a picture; over all of it where nothing was tried.
 * @param {import("./plot.js").Plot} plot
 * @param {import("./picture.js").Picture} picture
 */
export function layVeil(plot, picture) {
  const { width, height } = plot.context.canvas;
  const ratio = width / plot.size.width;
  const pen = stage.getContext("2d");
  // Another size empties the canvas, and takes a while.
  if (stage.width !== width || stage.height !== height) [stage.width, stage.height] = [width, height];
  else pen.clearRect(0, 0, width, height);
  pen.globalCompositeOperation = "source-over";
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.imageSmoothingEnabled = false;
  picture.lay(plot, picture.veil?.canvas ?? picture.canvas, pen);
  pen.resetTransform();
  pen.globalCompositeOperation = "source-in";
  pen.fillStyle = hatchOf(pen, ratio);
  pen.fillRect(0, 0, width, height);
  plot.context.drawImage(stage, 0, 0, plot.size.width, plot.size.height);
}
