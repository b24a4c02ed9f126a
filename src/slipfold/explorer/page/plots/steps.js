/** Round steps: what a slider and the keys move a value by. */

const MANTISSAS = [1, 2, 5, 10];

/**
 * The step of one, two or five units of a decimal place that is nearest to a share of a range.
 * @param {number} range
 * @param {number} share
 * @returns {number}
 */
export function roundStep(range, share) {
  const wanted = Math.abs(range) * share;
  if (!(wanted > 0)) return 0;
  const power = 10 ** Math.floor(Math.log10(wanted));
  const gap = (mantissa) => Math.abs(Math.log((mantissa * power) / wanted));
  return cleaned(MANTISSAS.reduce((best, next) => (gap(next) < gap(best) ? next : best)) * power);
}

/** The multiple of a step that is nearest to a value. */
export function snapped(value, step) {
  return step > 0 ? cleaned(Math.round(value / step) * step) : value;
}

/**
 * A value some steps on: first to the next multiple of the step.
 * @param {number} value
 * @param {number} step
 * @param {number} count of steps; below zero downwards
 */
export function stepped(value, step, count) {
  if (!(step > 0)) return value;
  const place = value / step;
  const near = Math.round(place);
  // What is a multiple but for rounding counts as one.
  const isMultiple = Math.abs(place - near) < 1e-6 * Math.max(Math.abs(place), 1);
  const start = isMultiple ? near : count > 0 ? Math.floor(place) : Math.ceil(place);
  return cleaned((start + count) * step);
}

/** Without the last bit's trace. */
function cleaned(value) {
  return Number(value.toPrecision(12));
}
