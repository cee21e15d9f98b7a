/** Light or dark theme: the system's, unless the reader selects one. */

const system = matchMedia("(prefers-color-scheme: dark)");

/** Set up the switch. `changed` is called when the colours of the page have changed. */
export function setUpTheme(select, changed) {
  const apply = () => {
    const dark = select.value === "dark" || (select.value === "auto" && system.matches);
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    changed();
  };
  select.addEventListener("change", apply);
  system.addEventListener("change", apply);
  apply();
}

/** A colour of the style sheet. */
export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}
