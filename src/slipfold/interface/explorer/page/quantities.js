/** Quantities in words and back: symbols, units, numbers. */

import { element } from "./dom.js";

/**
 * A symbol as an element.
 * @param {{symbol: [string, string]|null, label?: string, name: string}} quantity a parameter, state
 * or output; its symbol is a letter and what stands below it
 */
export function symbol({ symbol: parts, label, name }) {
  if (!parts) return element("span", { class: "symbol" }, label || name);
  const [letter, below] = parts;
  return element("span", { class: "symbol" }, element("i", {}, letter),
    below ? element("sub", {}, below) : null);
}

const CONVERSIONS = {
  deg: { unit: "°", factor: 180 / Math.PI, si: Math.PI / 180 },
};

/**
 * How a quantity is shown.
 * @returns {{unit: string, factor: number, si: number}} the unit, what the SI value is multiplied
 * with, and what the unit is in SI units
 */
export function display(quantity) {
  const shown = quantity.display_unit ?? (quantity.unit === "rad" ? "deg" : quantity.unit);
  return CONVERSIONS[shown] ?? { unit: raised(shown ?? ""), factor: 1, si: 1 };
}

const ABOVE = { "-": "⁻", ...Object.fromEntries([..."⁰¹²³⁴⁵⁶⁷⁸⁹"].map((letter, digit) => [digit, letter])) };

/** A unit with its powers raised. */
function raised(unit) {
  return unit.replace(/\^(-?[0-9]+)/g, (_, power) => [...power].map((letter) => ABOVE[letter]).join(""));
}

/**
 * A number with so many significant digits and no trailing zeros.
 * @returns {string} with a true minus sign
 */
export function formatted(value, digits = 4) {
  return plain(value, digits).replace("-", "−");
}

/** As `formatted`, in a form that number boxes and addresses read. */
export function plain(value, digits = 4) {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-4 || size >= 1e6) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
    return `${Number(mantissa)}e${Number(exponent)}`;
  }
  return String(Number(value.toPrecision(digits)));
}

/**
 * A quantity with its unit.
 * @param {number} value SI
 * @returns {string} e.g. `"0.0436 N"`, `"60°"`
 */
export function withUnit(quantity, value, digits = 4) {
  const { unit, factor } = display(quantity);
  const number = formatted(value * factor, digits);
  if (!unit) return number;
  return unit === "°" ? `${number}°` : `${number}\u202f${unit}`;
}

/** Damping that is rounding of an eigenvalue, over its modulus. */
const ROUNDING = 1e-13;

/** Of an eigenvalue the frequency in Hz and the damping ratio in per cent, as figures have them. */
export function modeOf([re, im]) {
  const size = Math.hypot(re, im);
  const damping = Math.abs(re) <= ROUNDING * size ? 0 : (-100 * re) / size;
  return { damping, frequency: Math.abs(im) / (2 * Math.PI) };
}

/** An eigenvalue in words; one that does not oscillate is a rate. */
export function modeText([re, im]) {
  if (im === 0) return `${formatted(re, 4)}\u202f1/s`;
  const { damping, frequency } = modeOf([re, im]);
  return `${formatted(frequency, 4)}\u202fHz, damping ratio ${formatted(damping, 4)}\u202f%`;
}

/**
 * The mode of the smallest damping ratio, in words.
 * @param {[number, number][]} eigenvalues real and imaginary parts in 1/s; the upper one of a pair counts
 */
export function leastDamped(eigenvalues) {
  const damping = (value) => modeOf(value).damping;
  const upper = eigenvalues.filter(([, im]) => im >= 0);
  const least = upper.reduce((best, value) => (damping(value) < damping(best) ? value : best));
  return `${upper.length > 1 ? "least damped: " : ""}${modeText(least)}`;
}

/** Words as a sentence: with a capital, and a full stop where none stands. */
export function asSentence(words) {
  return words && `${words[0].toUpperCase()}${words.slice(1)}${/[.…]$/.test(words) ? "" : "."}`;
}

/** The title of an axis of one quantity, or of several in one unit. */
export function axisTitle(...quantities) {
  const { unit } = display(quantities[0]);
  return `${quantities.map(({ label, name }) => label ?? name).join(", ")}${unit && ` (${unit})`}`;
}

/** A quantity as an option of a choice. */
export function optionOf(quantity) {
  return { value: quantity.name, text: axisTitle(quantity), title: quantity.doc };
}

const QUANTITY =
  /^\s*([-+−]?(?:[0-9]+\.?[0-9]*(?:e[-+−]?[0-9]+)?|\.[0-9]+(?:e[-+−]?[0-9]+)?|inf|nan))(\s*[^0-9.,\s].*?|\s+1\/.*?|)\s*$/i;

/** What is meant as a decimal comma: one that digits and no point surround. */
const COMMA = /^\s*[-+−]?[0-9]+,[0-9]+(?![0-9.,])/;

/**
 * Read two quantities, e.g. "1 .. 2.5 mm"; a unit of the second alone is that of both.
 * @returns {{range: [number, number]}|{sentence: string}|null} null where the text is no range
 */
export function parsedRange(text, quantity, usual = 1) {
  const ends = text.split(/\s*(?:\.\.+|…)\s*/);
  if (ends.length !== 2) return null;
  const unit = /[0-9.]\s*$/.test(ends[0]) ? ends[1].match(/[^0-9.,\s][^0-9]*$/)?.[0] ?? "" : "";
  const [low, high] = [`${ends[0]} ${unit}`, ends[1]].map((end) => parsed(end, quantity, usual));
  if (low.sentence || high.sentence) return { sentence: low.sentence ?? high.sentence };
  if (!(low.value < high.value)) return { sentence: `${quantity.name} = '${text}' is no range; give the smaller end first` };
  return { range: [low.value, high.value] };
}

/**
 * Read a quantity.
 * a parameter as the server describes it
 * @param {number} [usual] what the unit is that a number without one is in, in SI units
 * @returns {{value: number}|{sentence: string}} the value in SI units, or why there is none
 */
export function parsed(text, { name, units, wanted, bounds }, usual = 1) {
  const match = QUANTITY.exec(text);
  if (!match) {
    const wrong = COMMA.test(text) ? `has a decimal comma, write ${text.trim().replace(",", ".")}` : "is not a number";
    return { sentence: `${name} = '${text}' ${wrong}; give ${wanted}` };
  }
  const digits = match[1];
  const unit = match[2].trimStart();
  if (unit && !Object.hasOwn(units, unit)) {
    return { sentence: `${name} = '${text}' has the unit '${unit}'; give ${wanted}` };
  }
  const value = Number(digits.replaceAll("−", "-")) * (unit ? units[unit] : usual);
  if (!Number.isFinite(value)) {
    return { sentence: `${name} = ${text.trim()} is not a finite number; give ${bounds}` };
  }
  return { value };
}
