/** Colours of what was found: a scale for numbers, one colour each for words. */

import { display, formatted } from "../parameters/quantities.js";

/** Plasma, as in the package's figures. */
const PLASMA = [
  "#0d0887", "#46039f", "#7201a8", "#9c179e", "#bd3786", "#d8576b", "#ed7953", "#fb9f3a", "#fdca26", "#f0f921",
];

/** Names in the style sheet of the colours of words. */
const WORDS = ["live", "pin-3", "pin-5", "pin-1", "pin-6", "pin-2", "pin-4", "simulation"];

/** The scale of numbers as a style sheet writes it. */
export const GRADIENT = `linear-gradient(to right, ${PLASMA.join(", ")})`;

/**
 * Numbers, as they are shown, colours and keys of a quantity.
 * @param {object} quantity
 * @param {number[]} cases that are seen
 * @param {(name: string) => string} colour
 * @returns {{numbers: (number|null)[], range: [number, number], scale: [number, string][],
 *   words: {text: string, colour: string}[]|null, ends: [string, string]|null}}
 */
export function colouring(quantity, cases, colour) {
  const { isText, values: found } = quantity;
  if (!isText) {
    const { factor } = display(quantity);
    const values = found.map((value) => (value === null ? null : value * factor));
    const known = cases.map((i) => values[i]).filter((value) => value !== null);
    const [low, high] = known.length ? [Math.min(...known), Math.max(...known)] : [0, 1];
    return {
      numbers: values, range: low < high ? [low, high] : [low - 0.5, high + 0.5], words: null,
      scale: PLASMA.map((tint, i) => [i / (PLASMA.length - 1), tint]),
      ends: known.length ? [formatted(low), formatted(high)] : null,
    };
  }
  // A word has one colour whatever part of the study is seen.
  const texts = [...new Set(found.filter((value) => value !== null))].sort();
  const words = texts.map((text, i) => ({ text, colour: colour(WORDS[i % WORDS.length]) }));
  const scale = words.flatMap(({ colour: tint }, i) => [[i / words.length, tint], [(i + 1) / words.length, tint]]);
  return {
    numbers: found.map((value) => (value === null ? null : texts.indexOf(value))), words, ends: null,
    range: [-0.5, Math.max(texts.length, 1) - 0.5], scale: words.length ? scale : [[0, PLASMA[0]], [1, PLASMA[0]]],
  };
}
