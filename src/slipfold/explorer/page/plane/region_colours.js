/** Shades of regions: one for each combination of stable responses, as in figures. */

const SHADES = { 1: "region-1", "1-2": "region-1-2", 2: "region-2", "": "region-none" };
const OTHERS = 12;

/** Turn of the hue that never comes back to where it was. */
const GOLDEN = 0.6180339887498949;

/**
 * The colour of regions with these stable responses.
 * @param {number[]} stable their periods
 * @param {(name: string) => string} colour of the style sheet
 */
export function regionColour(stable, colour) {
  const known = SHADES[stable.join("-")];
  if (known) return colour(known);
  const rank = rankOf(stable);
  if (rank < OTHERS) return colour(`region-other-${rank + 1}`);
  return `hsl(${((rank * GOLDEN % 1) * 360).toFixed(1)}, 45%, ${colour("region-lightness")})`;
}

/** Combinations numbered from 0: those of periods 1 and 2 by how many there are, then others. */
function rankOf(stable) {
  const count = stable.length;
  const doubled = stable.filter((period) => period === 2).length;
  if (stable.every((period) => period === 1 || period === 2)) {
    if (count === 2) return doubled / 2;
    return ((count - 2) * (count + 3)) / 2 - 1 + doubled;
  }
  return [...stable].sort((a, b) => a - b).reduce((sum, period, i) => sum + period * 31 ** i, 1000);
}
