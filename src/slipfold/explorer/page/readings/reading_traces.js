/** Readings of a measured response as traces of plotly, marked as in the package's figures. */

/** How readings look by how the parameter came to their values. */
export const WAYS = {
  up: { name: "measured, upward", symbol: "circle", size: 5 },
  down: { name: "measured, downward", symbol: "circle-open", size: 9 },
  "": { name: "measured", symbol: "circle", size: 5 },
};

/**
 * Readings with their errors, a trace a direction; those going down around those going up.
 * @param {import("./readings.js").Measured|null} measured in SI units
 * @param {[number, number]} factors what its numbers are multiplied with to be shown
 * @param {string} colour
 * @returns {object[]}
 */
export function readingTraces(measured, [fx, fy], colour) {
  if (!measured) return [];
  const { values, readings, errors } = measured;
  return Object.entries(WAYS).map(([way, { name, symbol, size }]) => {
    const rows = rowsOf(measured).filter((i) => measured.sweep[i] === way);
    const error = { type: "data", array: rows.map((i) => errors[i] * fy), color: colour, thickness: 1, width: 2 };
    return {
      type: "scatter", mode: "markers", name, hoverinfo: "skip",
      x: rows.map((i) => values[i] * fx), y: rows.map((i) => readings[i] * fy), error_y: error,
      marker: { symbol, size, color: colour, line: { color: colour, width: 1.2 } },
    };
  });
}

/**
 * Ends of all error bars within a span, for the axis.
 * @param {import("./readings.js").Measured|null} measured
 * @param {[number, number]} span
 * @returns {number[]}
 */
export function readingValues(measured, [a, b]) {
  if (!measured) return [];
  const { values, readings, errors } = measured;
  return rowsOf(measured).filter((i) => values[i] >= Math.min(a, b) && values[i] <= Math.max(a, b))
    .flatMap((i) => [readings[i] - errors[i], readings[i] + errors[i]]);
}

function rowsOf({ readings }) {
  return [...readings.keys()].filter((i) => readings[i] !== null);
}
