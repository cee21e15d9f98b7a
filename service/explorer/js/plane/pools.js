/** Colours of motions that have none by name: those of pictures elsewhere, in `worker/pictures/colours.py`. */

export const POOLS = {
  "paper": ["#009900", "#ff80cc", "#33ffe6", "#8066b3", "#664d33", "#99cc00", "#ff0066", "#331a00", "#b3ffb3", "#ff8080", "#006680", "#cc4dff", "#999933", "#b39980", "#33b380", "#66334d"],
  "colour_blind": ["#bfffbf", "#2a00bf", "#802a00", "#2a0000", "#554040"],
};

/** Each colour without a texture, then with one after the other. */
export const TEXTURES = [0, 1, 2, 3];
