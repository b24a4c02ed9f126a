/** Symbols as the field prints them: a letter in italics, what follows it below the line. */

import { element } from "../controls/dom.js";

/**
 * A symbol as an element.
 * @param {{symbol: [string, string]|null, label?: string, name: string}} quantity a parameter, state
 *   or output; its symbol is a letter and what stands below it
 * @returns {HTMLElement}
 */
export function symbol({ symbol: parts, label, name }) {
  if (!parts) return element("span", { class: "symbol" }, label || name);
  const [letter, below] = parts;
  return element("span", { class: "symbol" }, element("i", {}, letter),
    below ? element("sub", {}, below) : null);
}
