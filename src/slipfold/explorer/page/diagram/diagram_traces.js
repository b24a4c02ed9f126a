/** A response diagram as traces of plotly: colour tells the curve, dashes the stability. */

import { markedPoints } from "./marked_points.js";
import { display } from "../parameters/quantities.js";

/** Line of each kind of orbit, as in the package's figures. */
export const DASHES = { stable: "solid", "period doubling": "6px,3px", "fold or torus": "1.5px,2.5px" };

const WIDTHS = { stable: 2.2, "period doubling": 1.5, "fold or torus": 1.7 };

/** Markers as in the package's figures; a subcritical point is open. */
export const MARKERS = {
  PD: "circle", NS: "square", LP: "triangle-up", BP: "diamond", HB: "pentagon", LIMIT: "x-thin",
};

const SHORT = { supercritical: "super", subcritical: "sub" };

/**
 * @typedef {object} Mark
 * @property {string} type
 * @property {string} text what stands beside it
 * @property {number} x
 * @property {number} y
 * @property {boolean} hollow
 */

/**
 * The marked points of a diagram.
 * @param {object} diagram the server's answer
 * @returns {Mark[]} in SI units
 */
export function marksOf(diagram) {
  const points = diagram.branches.flatMap((branch) => markedPoints(branch, diagram.x));
  return distinct(points.map(({ type, criticality, words, value, y }) => ({
    type,
    text: type === "LIMIT" ? words : [type, SHORT[criticality]].filter(Boolean).join(" "),
    x: value,
    y,
    hollow: type === "LIMIT" || criticality === "subcritical",
  })));
}

/** Marks without those that lie on another of the same name: branches that mirror each other. */
function distinct(marks) {
  const places = marks.map(({ text, x, y }) => `${text} ${x.toPrecision(5)} ${y.toPrecision(5)}`);
  return marks.filter((_, i) => places.indexOf(places[i]) === i);
}

/**
 * Lines of a diagram, one trace a kind of stability, so that their number never changes.
 * @param {object} diagram
 * @param {string} colour
 * @param {string} name
 * @returns {object[]}
 */
export function lineTraces(diagram, colour, name) {
  const [fx, fy] = factors(diagram);
  return Object.keys(DASHES).map((kind) => {
    const x = [];
    const y = [];
    for (const branch of diagram.branches) {
      for (const { kind: own, first, last } of branch.stretches) {
        if (own !== kind) continue;
        for (let i = first; i <= last; i++) {
          x.push(branch.x[i] * fx);
          y.push(branch.y[i] * fy);
        }
        x.push(null);
        y.push(null);
      }
    }
    const line = { color: colour, dash: DASHES[kind], width: WIDTHS[kind] };
    return { type: "scatter", mode: "lines", x, y, line, name: `${name}, ${kind}`, hoverinfo: "skip" };
  });
}

/**
 * Markers of a diagram with their names.
 * @param {object} diagram
 * @param {string} colour
 * @param {string} paper colour within open markers
 * @param {string[]} positions where each name stands; none are written if it is empty
 * @returns {object}
 */
export function markTrace(diagram, colour, paper, positions) {
  const [fx, fy] = factors(diagram);
  const marks = marksOf(diagram);
  return {
    type: "scatter",
    mode: positions.length ? "markers+text" : "markers",
    x: marks.map((mark) => mark.x * fx),
    y: marks.map((mark) => mark.y * fy),
    text: positions.length ? marks.map((mark) => escaped(mark.text)) : undefined,
    textposition: positions,
    textfont: { color: colour, size: 12 },
    marker: {
      symbol: marks.map((mark) => MARKERS[mark.type] ?? "circle"),
      size: marks.map((mark) => (mark.type === "LIMIT" ? 9 : 8)),
      color: marks.map((mark) => (mark.hollow ? paper : colour)),
      line: { color: colour, width: 1.6 },
    },
    cliponaxis: false,
    hoverinfo: "skip",
  };
}

/** What the diagram's numbers are multiplied with to be shown. */
export function factors(diagram) {
  return [display(diagram.x).factor, display(diagram.y).factor];
}

/** plotly reads a little markup in texts; a name is none. */
export function escaped(text) {
  return text.replaceAll("&", "&amp;").replaceAll("<", "&lt;");
}
