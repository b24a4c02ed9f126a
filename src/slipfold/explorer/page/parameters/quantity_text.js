/**
 * Numbers with units as people write them, read as the command line reads them
 * (slipfold/models/quantity.py): `60deg`, `100 mN`, `12.5`. Which units there are the server tells.
 */

const QUANTITY =
  /^\s*([-+−]?(?:[0-9]+\.?[0-9]*(?:e[-+−]?[0-9]+)?|\.[0-9]+(?:e[-+−]?[0-9]+)?|inf|nan))(\s*[^0-9.,\s].*?|\s+1\/.*?|)\s*$/i;

/**
 * Read a quantity.
 * @param {string} text
 * @param {{name: string, units: Record<string, number>, wanted: string, bounds: string}} quantity
 *   a parameter as the server describes it
 * @param {number} [usual] what the unit is that a number without one is in, in SI units
 * @returns {{value: number}|{sentence: string}} the value in SI units, or why there is none
 */
export function parsed(text, { name, units, wanted, bounds }, usual = 1) {
  const match = QUANTITY.exec(text);
  if (!match) return { sentence: `${name} = '${text}' is not a number; give ${wanted}` };
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
