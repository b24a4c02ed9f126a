/** A response diagram as data: marked points, places on branches, traces of plotly. */

import { display, withUnit } from "./quantities.js";
import { mixed, typeScale } from "./theme.js";
import { ANY } from "./view.js";

const DIGITS = 6;

/**
 * @param {object} branch of the server's answer
 * @param {object} x what is varied
 * @returns {object[]} as the special points of a branch
 */
function markedPoints(branch, x) {
  return [...branch.special, ...limitOf(branch, x)];
}

function limitOf({ stopped, x: values, y, arclength }, x) {
  if (stopped.kind !== "limit" || values.length === 0) return [];
  const at = `${x.label} = ${withUnit(x, stopped.value, DIGITS)}`;
  return [{
    type: "LIMIT", value: values.at(-1), y: y.at(-1), arclength: arclength.at(-1), criticality: null,
    words: nameOfEnd(stopped.reason), sentence: `${at}: ${stopped.reason}`,
  }];
}

/** Each branch once, also if its largest and its smallest values are two lines. */
export function branchesOf({ branches }) {
  return branches.filter(({ statistic }) => statistic === branches[0].statistic);
}

/** Letters of the longest name that stands in the plot; the sentence is below it. */
const LONGEST = 20;

/** What an end is called beside its marker: what comes before the colon of its reason, if that is short. */
function nameOfEnd(reason) {
  const [name] = reason.split(":");
  return name.length > LONGEST ? "end" : name;
}

/**
 * @typedef {object} Place a point on a drawn branch
 * @property {number} branch
 * @property {number} arclength
 * @property {number} x
 * @property {number} y
 * @property {number} period
 * @property {string} kind `"stable"` or unstable by what
 * @property {string} statistic what y is of the output
 * @property {boolean} isEquilibrium
 * @property {boolean} [isTurn] whether the branch turns here, so that one value belongs to several points
 * @property {object} [special] the special point that it is
 */

/** Share of a branch's range within which a value is that of its fold: drawn values are rounded. */
const TURN = 1e-6;

/** Share of a branch's height within which two of its places at one value are the same. */
const SAME = 1e-3;

/**
 * All places where branches cross a value.
 * @param {object} diagram the server's answer
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
 * The place that is meant: on the chosen branch, or any, and as near as can be, else a stable one,
 * else that on the first branch that moves: those of longer periods come after it.
 */
export function chosenPlace(places, chosen) {
  if (places.length === 0) return null;
  const onBranch = chosen ? places.filter(({ branch }) => [branch, ANY].includes(chosen.branch)) : [];
  if (onBranch.length > 0) return least(onBranch, (place) => Math.abs(place.y - chosen.y));
  return places.find(({ kind }) => kind === "stable") ?? places.find(({ isEquilibrium }) => !isEquilibrium) ?? places[0];
}

/**
 * The place of a branch between its drawn points i and i + 1.
 * @param {number} share from 0 to 1
 */
function placeOn(branch, i, share) {
  const between = (values) => values[i] + share * (values[i + 1] - values[i]);
  const segment = branch.segments.find(({ first, last }) => first <= i && i < last);
  return {
    branch: branch.id,
    arclength: between(branch.arclength),
    x: between(branch.x),
    y: between(branch.y),
    period: branch.period,
    isEquilibrium: branch.kind === "equilibrium",
    kind: segment?.kind ?? "stable",
    statistic: branch.statistic,
  };
}

function isTurn(x, i) {
  return i > 0 && i + 1 < x.length && (x[i] - x[i - 1]) * (x[i + 1] - x[i]) < 0;
}

/** The place of a special point. */
export function placeOfSpecial(branch, special) {
  const { arclength, value, y } = special;
  const { id, period, statistic } = branch;
  const isEquilibrium = branch.kind === "equilibrium";
  return { branch: id, arclength, x: value, y, period, kind: special.type, isEquilibrium, statistic, special };
}

/** A place, or the special point that lies there. */
export function asSpecial(diagram, place) {
  const branch = place && diagram.branches.find(({ id, statistic }) => id === place.branch && statistic === place.statistic);
  if (!branch) return place;
  const [width, height] = [branch.x, branch.y].map((values) => Math.max(...values) - Math.min(...values));
  const special = markedPoints(branch, diagram.x).find(({ value, y }) =>
    Math.abs(value - place.x) <= TURN * width && Math.abs(y - place.y) <= SAME * height);
  return special ? placeOfSpecial(branch, special) : place;
}

/** The special point whose marker a point of the screen is on; as `nearestPlace`. */
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
 * @param {(x: number, y: number) => [number, number]} pixel where data are on the screen
 * @param {[number, number]} point in pixels
 * @param {number} reach in pixels
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

/** Line of each kind of orbit, as in the package's figures. */
const DASHES = { stable: "solid", "period doubling": "6px,3px", "fold or torus": "1.5px,2.5px" };

const WIDTHS = { stable: 2.2, "period doubling": 1.5, "fold or torus": 1.7 };

/** Markers as in the package's figures. */
export const MARKERS = {
  PD: "circle", NS: "square", LP: "triangle-up", BP: "diamond", HB: "pentagon", LIMIT: "x-thin",
  GRAZE: "triangle-down", STICK: "triangle-left", LIFT: "triangle-right", MEET: "cross",
};

const SHORT = { supercritical: "super", subcritical: "sub" };

/** How a marker is filled, as in the package's figures: open where a point is subcritical, pale where it is not known whether. */
export function fillOf({ type, criticality, undecided }) {
  if (type === "LIMIT" || criticality === "subcritical") return "open";
  return undecided ? "pale" : "full";
}

/** Share of the paper in a pale marker. */
const PALE = 0.6;

/**
 * @typedef {object} Mark
 * @property {string} type
 * @property {string} text what stands beside it
 * @property {string} short the same where there is little room
 * @property {number} x
 * @property {number} y
 * @property {"full"|"pale"|"open"} fill
 * @property {string} of the point that it marks: on the line of the largest and that of the smallest values
 */

/**
 * The marked points of a diagram.
 * @param {object} diagram the server's answer
 * @returns {Mark[]} in SI units
 */
export function marksOf(diagram) {
  const points = diagram.branches.flatMap((branch) =>
    markedPoints(branch, diagram.x).map((point) => ({ ...point, of: `${branch.id} ${point.arclength}` })));
  return distinct(points.map(({ of, type, criticality, undecided, words, value, y }) => ({
    of,
    type,
    text: type === "LIMIT" ? words : [type, SHORT[criticality]].filter(Boolean).join(" "),
    short: type === "LIMIT" ? words.split(" ").at(-1) : type,
    x: value,
    y,
    fill: fillOf({ type, criticality, undecided }),
  })));
}

/** Marks without those that lie on another of the same text: branches that mirror each other. */
export function distinct(marks) {
  const places = marks.map(({ text, x, y }) => `${text} ${x.toPrecision(5)} ${y.toPrecision(5)}`);
  return marks.filter((_, i) => places.indexOf(places[i]) === i);
}

/** Lines of a diagram, one trace a kind of stability, so that their number never changes. */
export function lineTraces(diagram, color, name) {
  const [fx, fy] = factors(diagram);
  return Object.keys(DASHES).map((kind) => {
    const x = [];
    const y = [];
    for (const branch of diagram.branches) {
      for (const { kind: own, first, last } of branch.segments) {
        if (own !== kind) continue;
        for (let i = first; i <= last; i++) {
          x.push(branch.x[i] * fx);
          y.push(branch.y[i] * fy);
        }
        x.push(null);
        y.push(null);
      }
    }
    // With points left out a line would have corners.
    const line = { color: color, dash: DASHES[kind], width: WIDTHS[kind], simplify: false };
    return { type: "scatter", mode: "lines", x, y, line, name: `${name}, ${kind}`, hoverinfo: "skip" };
  });
}

/**
 * Markers of a diagram with their names.
 * @param {string} paper color within open markers
 * @param {{text: string, position: string}[]} labels what stands beside each and where; none if it is empty
 */
export function markTrace(diagram, color, paper, labels) {
  const [fx, fy] = factors(diagram);
  const marks = marksOf(diagram);
  const fills = { full: color, pale: mixed(color, paper, PALE), open: paper };
  return {
    type: "scatter",
    mode: labels.length ? "markers+text" : "markers",
    x: marks.map((mark) => mark.x * fx),
    y: marks.map((mark) => mark.y * fy),
    text: labels.length ? labels.map(besideMarker) : undefined,
    textposition: labels.map(({ position }) => position),
    textfont: { color: color, size: 12 * typeScale() },
    marker: {
      symbol: marks.map((mark) => MARKERS[mark.type] ?? "circle"),
      size: marks.map((mark) => (mark.type === "LIMIT" ? 9 : 8)),
      color: marks.map(({ fill }) => fills[fill]),
      line: { color: color, width: 1.6 },
      opacity: 1, // of markers of several sizes plotly shows through
    },
    cliponaxis: false,
    hoverinfo: "skip",
  };
}

/**
 * A name with a gap between it and its marker, which plotly would let touch at a side. A name without a place is a
 * space: what was empty once, plotly never draws again.
 */
export function besideMarker({ text, position }) {
  const gap = !text || position.startsWith("middle") ? THIN : "";
  return `${gap}${escaped(text)}${gap}`;
}

const THIN = "\u2009";

/** What the diagram's numbers are multiplied with to be shown. */
export function factors(diagram) {
  return [display(diagram.x).factor, display(diagram.y).factor];
}

/** plotly reads a little markup in texts; a name is none. */
export function escaped(text) {
  return text.replaceAll("&", "&amp;").replaceAll("<", "&lt;");
}
