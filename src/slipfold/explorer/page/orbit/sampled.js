/** Values between the samples of an orbit. */

/**
 * The value of a periodic signal at a phase.
 * @param {number[]} samples evenly spaced, the last at the end of the orbit
 * @param {number} phase from 0 to 1
 * @returns {number}
 */
export function sampled(samples, phase) {
  const place = phase * (samples.length - 1);
  const i = Math.min(Math.floor(place), samples.length - 2);
  if (i < 0) return samples[0];
  return samples[i] + (place - i) * (samples[i + 1] - samples[i]);
}
