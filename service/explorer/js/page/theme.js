/** Light or dark theme: the system's, unless the reader selects one. */

const known = new Map();
const system = matchMedia("(prefers-color-scheme: dark)");

/** Set up the switch. `changed` is called when the colours of the page have changed. */
export function setUpTheme(select, changed) {
  const kept = localStorage.getItem("theme");
  if (kept) select.value = kept;
  const apply = () => {
    const dark = select.value === "dark" || (select.value === "auto" && system.matches);
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    known.clear();
    changed();
  };
  select.addEventListener("change", () => {
    localStorage.setItem("theme", select.value);
    apply();
  });
  system.addEventListener("change", apply);
  apply();
}

/** A colour of the style sheet. Asking for one anew at every stroke would cost a layout each. */
export function colour(name) {
  if (!known.has(name)) known.set(name, getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
  return known.get(name);
}
