// Dark and light: as the system says until the toggle is used, which is remembered.
import { byId, remember, remembered } from "./dom.js";

const dark = matchMedia("(prefers-color-scheme: dark)");

/** Set up the toggle; `changed(name)` is called at once and at each change. */
export function startTheme(changed) {
  const apply = () => {
    const name = chosen() ?? system();
    document.documentElement.dataset.theme = name;
    changed(name);
  };
  byId("theme").addEventListener("click", () => {
    const next = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
    remember("theme", next === system() ? null : next); // the system's again: follow it again
    apply();
  });
  dark.addEventListener("change", apply);
  apply();
}

function chosen() {
  const name = remembered("theme");
  return name === "dark" || name === "light" ? name : null;
}

function system() {
  return dark.matches ? "dark" : "light";
}

/** A colour of app.css by its name, as `cssColour("--muted")`. */
export function cssColour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
