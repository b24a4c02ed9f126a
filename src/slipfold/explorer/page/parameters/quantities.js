/** Numbers and units as people read them: degrees for radians, a true minus sign. */

const CONVERSIONS = {
  deg: { unit: "°", factor: 180 / Math.PI, si: Math.PI / 180 },
};

/**
 * How a quantity is shown.
 * @param {{unit?: string, display_unit?: string}} quantity
 * @returns {{unit: string, factor: number, si: number}} the unit, what the SI value is multiplied
 *   with, and what the unit is in SI units
 */
export function display(quantity) {
  const shown = quantity.display_unit ?? (quantity.unit === "rad" ? "deg" : quantity.unit);
  return CONVERSIONS[shown] ?? { unit: shown ?? "", factor: 1, si: 1 };
}

/**
 * A number with so many significant digits and no trailing zeros.
 * @param {number} value
 * @param {number} [digits]
 * @returns {string} with a true minus sign
 */
export function formatted(value, digits = 4) {
  return plain(value, digits).replace("-", "−");
}

/**
 * As `formatted`, in a form that number boxes and addresses read.
 * @param {number} value
 * @param {number} [digits]
 * @returns {string}
 */
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
 * @param {{unit?: string, display_unit?: string}} quantity
 * @param {number} value SI
 * @param {number} [digits]
 * @returns {string} e.g. `"0.0436 N"`, `"60°"`
 */
export function withUnit(quantity, value, digits = 4) {
  const { unit, factor } = display(quantity);
  const number = formatted(value * factor, digits);
  if (!unit) return number;
  return unit === "°" ? `${number}°` : `${number}\u202f${unit}`;
}

/**
 * The title of an axis.
 * @param {{label?: string, name: string, unit?: string, display_unit?: string}} quantity
 * @returns {string}
 */
export function axisTitle(quantity) {
  const { unit } = display(quantity);
  return `${quantity.label ?? quantity.name}${unit ? ` (${unit})` : ""}`;
}
