/** Light and dark: the system's choice until the reader makes one. */

import { Signal } from "./store.js";

const KEY = "slipfold-theme";
const CHOICES = ["auto", "light", "dark"];
const preference = window.matchMedia("(prefers-color-scheme: dark)");

/** Announces when colors have changed. */
export const themeChanged = new Signal();

preference.addEventListener("change", () => apply(choice()));

/** The reader's choice: `"auto"`, `"light"` or `"dark"`. */
export function choice() {
  const kept = localStorage.getItem(KEY);
  return CHOICES.includes(kept) ? kept : "auto";
}

/** Take a choice, or the kept one, and recolor. */
export function apply(chosen = choice()) {
  localStorage.setItem(KEY, chosen);
  const dark = chosen === "dark" || (chosen === "auto" && preference.matches);
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  themeChanged.announce();
}

/** The choice after the present one. */
export function nextChoice() {
  return CHOICES[(CHOICES.indexOf(choice()) + 1) % CHOICES.length];
}

/** How much larger type is where the page is presented to an audience. */
const PRESENTED = 1.5;

/** Whether the page is presented: large type, and nothing but plots, mechanism and sliders. */
export function isPresented() {
  return "presented" in document.documentElement.dataset;
}

/** Present the page, or work on it again. */
export function present(isOn) {
  document.documentElement.toggleAttribute("data-presented", isOn);
  themeChanged.announce();
}

/** Size of type in plots over the usual one. */
export function typeScale() {
  return isPresented() ? PRESENTED : 1;
}

/**
 * Colors of the style sheet by name.
 * @returns {(name: string) => string} e.g. `colors()("ink")`
 */
export function colors() {
  const style = getComputedStyle(document.documentElement);
  return (name) => style.getPropertyValue(`--${name}`).trim();
}

/** The color `#rrggbb` that has a share of another one; any other notation stays as it is. */
export function mixed(color, other, share) {
  const channels = [color, other].map((text) => text.match(/^#(..)(..)(..)$/)?.slice(1).map((part) => parseInt(part, 16)));
  if (!channels.every(Boolean)) return color;
  const [from, to] = channels;
  return `#${from.map((value, i) => Math.round(value + share * (to[i] - value)).toString(16).padStart(2, "0")).join("")}`;
}

/**
 * A color of the light theme, for a file on white.
 * @param {string} name in the style sheet
 */
export function light(name) {
  const { dataset } = document.documentElement;
  const { theme } = dataset;
  dataset.theme = "light";
  const found = colors()(name);
  dataset.theme = theme;
  return found;
}
