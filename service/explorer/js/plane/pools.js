/** Colours of motions that have none by name: those of pictures elsewhere, in `worker/pictures/colours.py`. */

export const POOLS = {
  "paper": ["#009900", "#ff80cc", "#33ffe6", "#8066b3", "#664d33", "#99cc00", "#ff0066", "#331a00", "#b3ffb3", "#ff8080", "#006680", "#cc4dff", "#999933", "#b39980", "#33b380", "#66334d"],
  "colour_blind": ["#bfffbf", "#2a00bf", "#802a00", "#2a0000", "#554040"],
};

/** Colours of motions that have one by name. */
export const OWN = {
  "paper": { "chaotic": "#800000", "permanent contact": "#000080", "P(1,1,0)": "#8cd9ff", "P(1,2,0)": "#1a73ff", "P(1,3,0)": "#00bfbf", "P(2,2,1)": "#ffe61a", "P(3,3,2)": "#ff991a" },
  "colour_blind": { "chaotic": "#d55e00", "permanent contact": "#141f40", "P(1,1,0)": "#56b4e9", "P(1,2,0)": "#0072b2", "P(2,2,1)": "#f0e442" },
};

/** Each colour without a texture, then with one after the other. */
export const TEXTURES = [0, 1, 2, 3];
