/** Symbols as the field prints them: a letter in italics, what follows it below the line. */

import { element } from "./dom.js";

const SYMBOL = /^(\p{L}\p{M}*)([A-Za-z0-9₀-₉]{0,3})$/u;

/**
 * A symbol as an element.
 * @param {{label?: string, name: string}} quantity a parameter, state or output
 * @returns {HTMLElement}
 */
export function symbol(quantity) {
  const label = quantity.label || quantity.name;
  const parts = SYMBOL.exec(label);
  if (!parts) return element("span", { class: "symbol" }, label);
  const below = parts[2] ? element("sub", {}, parts[2].normalize("NFKC")) : null;
  return element("span", { class: "symbol" }, element("i", {}, parts[1]), below);
}
