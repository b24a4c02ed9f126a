/** Which orbit of a diagram is shown: where the branches cross the value of the varied parameter. */

import { markedPoints } from "./marked_points.js";

/**
 * @typedef {object} Place a point on a drawn branch
 * @property {number} branch
 * @property {number} arclength
 * @property {number} x
 * @property {number} y
 * @property {number} period
 * @property {string} kind `"stable"` or unstable by what
 * @property {boolean} isEquilibrium
 * @property {boolean} [isTurn] whether the branch turns here, so that the value does not tell where
 * @property {object} [special] the special point that it is
 */

/** Share of a branch's range within which a value is that of its fold: drawn values are rounded. */
const TURN = 1e-6;

/** Share of a branch's height within which two of its places at one value are the same. */
const SAME = 1e-3;

/**
 * All places where branches cross a value.
 * @param {object} diagram the server's answer
 * @param {number} value
 * @returns {Place[]}
 */
export function crossings(diagram, value) {
  const found = [];
  for (const branch of diagram.branches) {
    const { x } = branch;
    const slack = TURN * (Math.max(...x) - Math.min(...x));
    for (let i = 0; i + 1 < x.length; i++) {
      if (isTurn(x, i) && Math.abs(x[i] - value) <= slack) {
        found.push({ ...placeOn(branch, i, 0), isTurn: true });
      }
      if ((x[i] - value) * (x[i + 1] - value) > 0 || x[i] === x[i + 1]) continue;
      const place = placeOn(branch, i, (value - x[i]) / (x[i + 1] - x[i]));
      const last = found.at(-1);
      // A drawn point at the very value belongs to two pieces.
      if (last?.branch !== branch.id || last.arclength !== place.arclength) found.push(place);
    }
  }
  return found;
}

/**
 * The place that is meant: on the chosen branch and as near as can be, else a stable one,
 * else that on the branch found last.
 * @param {Place[]} places
 * @param {{branch: number, y: number}|null} chosen
 * @returns {Place|null}
 */
export function chosenPlace(places, chosen) {
  if (places.length === 0) return null;
  const onBranch = chosen ? places.filter((place) => place.branch === chosen.branch) : [];
  if (onBranch.length > 0) return least(onBranch, (place) => Math.abs(place.y - chosen.y));
  return places.find((place) => place.kind === "stable") ?? places.at(-1);
}

/**
 * The place of a branch between its drawn points i and i + 1.
 * @param {object} branch
 * @param {number} i
 * @param {number} share from 0 to 1
 * @returns {Place}
 */
export function placeOn(branch, i, share) {
  const between = (values) => values[i] + share * (values[i + 1] - values[i]);
  const stretch = branch.stretches.find(({ first, last }) => first <= i && i < last);
  return {
    branch: branch.id,
    arclength: between(branch.arclength),
    x: between(branch.x),
    y: between(branch.y),
    period: branch.period,
    isEquilibrium: branch.kind === "equilibrium",
    kind: stretch?.kind ?? "stable",
  };
}

function isTurn(x, i) {
  return i > 0 && i + 1 < x.length && (x[i] - x[i - 1]) * (x[i + 1] - x[i]) < 0;
}

/**
 * The place of a special point.
 * @param {object} branch
 * @param {object} special
 * @returns {Place}
 */
export function placeOfSpecial(branch, special) {
  const { arclength, value, y } = special;
  const isEquilibrium = branch.kind === "equilibrium";
  return { branch: branch.id, arclength, x: value, y, period: branch.period, kind: special.type, isEquilibrium, special };
}

/**
 * A place, or the special point that lies there.
 * @param {object} diagram
 * @param {Place|null} place
 * @returns {Place|null}
 */
export function asSpecial(diagram, place) {
  const branch = place && diagram.branches.find(({ id }) => id === place.branch);
  if (!branch) return place;
  const [width, height] = [branch.x, branch.y].map((values) => Math.max(...values) - Math.min(...values));
  const special = markedPoints(branch, diagram.x).find(({ value, y }) =>
    Math.abs(value - place.x) <= TURN * width && Math.abs(y - place.y) <= SAME * height);
  return special ? placeOfSpecial(branch, special) : place;
}

/**
 * The special point whose marker a point of the screen is on; as `nearestPlace`.
 */
export function nearestSpecial(diagram, pixel, point, reach) {
  const known = diagram.branches.flatMap((branch) => markedPoints(branch, diagram.x).map((special) => {
    const [x, y] = pixel(special.value, special.y);
    return { gap: Math.hypot(x - point[0], y - point[1]), branch, special };
  })).filter(({ gap }) => gap < reach);
  if (known.length === 0) return null;
  const { branch, special } = least(known, ({ gap }) => gap);
  return placeOfSpecial(branch, special);
}

/**
 * The drawn place nearest to a point of the screen.
 * @param {object} diagram
 * @param {(x: number, y: number) => [number, number]} pixel where data are on the screen
 * @param {[number, number]} point in pixels
 * @param {number} reach in pixels
 * @returns {Place|null}
 */
export function nearestPlace(diagram, pixel, point, reach) {
  let best = null;
  let distance = reach;
  for (const branch of diagram.branches) {
    let before = null;
    for (let i = 0; i < branch.x.length; i++) {
      const here = pixel(branch.x[i], branch.y[i]);
      if (before) {
        const share = nearestShare(before, here, point);
        const gap = Math.hypot(
          before[0] + share * (here[0] - before[0]) - point[0],
          before[1] + share * (here[1] - before[1]) - point[1],
        );
        if (gap < distance) {
          distance = gap;
          best = placeOn(branch, i - 1, share);
        }
      }
      before = here;
    }
  }
  return best;
}

function nearestShare(a, b, point) {
  const along = [b[0] - a[0], b[1] - a[1]];
  const length = along[0] ** 2 + along[1] ** 2;
  if (length === 0) return 0;
  const share = ((point[0] - a[0]) * along[0] + (point[1] - a[1]) * along[1]) / length;
  return Math.min(Math.max(share, 0), 1);
}

function least(items, size) {
  return items.reduce((best, item) => (size(item) < size(best) ? item : best));
}
