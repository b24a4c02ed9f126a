/** Where an axis begins and ends, and its ticks. */

/** Range over size below which numbers are the same. */
const NOISE = 1e-9;

/** Size below which a number is zero. */
const NOTHING = 1e-13;

/**
 * Least and largest of some numbers with a margin on each side.
 * @param {Iterable<number>} values
 * @param {number} [margin] as a share of the range
 * @returns {[number, number]}
 */
export function padded(values, margin = 0.06) {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  if (!Number.isFinite(low)) return [0, 1];
  // What does not move but for rounding is shown as a straight line, not as noise.
  const largest = Math.max(Math.abs(low), Math.abs(high));
  if (largest < NOTHING) return [-1, 1];
  const size = high - low > NOISE * largest ? high - low : largest;
  return [low - margin * size, high + margin * size];
}

/**
 * Whether a range shows all of another and is not much too large for it.
 * @param {[number, number]} range
 * @param {[number, number]} wanted
 */
export function fits(range, wanted) {
  const size = range[1] - range[0];
  return covers(range, wanted) && wanted[1] - wanted[0] > 0.55 * size;
}

/** Whether a range shows all of another but its margins. */
export function covers([low, high], [a, b]) {
  const slack = 0.05 * (b - a);
  return low <= a + slack && high >= b - slack;
}

/**
 * Round numbers that divide a range.
 * @param {[number, number]} range
 * @param {number} count about how many
 * @returns {number[]}
 */
export function ticks([low, high], count) {
  const step = roundStep((high - low) / count);
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: Math.max(last - first + 1, 0) }, (_, i) =>
    Number(((first + i) * step).toPrecision(12)),
  );
}

function roundStep(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return power * ([1, 2, 2.5, 5, 10].find((step) => step * power >= least * (1 - 1e-9)) ?? 10);
}
