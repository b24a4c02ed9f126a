/** A bifurcation set as traces of plotly: shades for regions, lines for loci, dots for codimension two. */

import { escaped } from "../diagram/diagram_traces.js";
import { regionColour } from "./region_colours.js";
import { regionPlaces } from "./region_places.js";

const DASHES = { supercritical: "solid", subcritical: "6px,3px" };
const WIDTHS = { 1: 2.4, 2: 1.5 };
const FAINT = 0.55;

/** Points of a locus that are nothing but its own extrema. */
const UNMARKED = ["MIN", "MAX", "EVENT"];

/**
 * How a stretch of a locus is drawn: its colour tells the type, its dashes the criticality, its
 * width the period.
 */
export function lineStyle({ type, period }, criticality, colour) {
  return {
    color: colour(`locus-${type}`) || colour("ink"), width: WIDTHS[period] ?? 1.1,
    dash: type === "LP" ? "7px,2px,1.5px,2px" : DASHES[criticality] ?? "1.5px,2.5px",
  };
}

/** The name of a stretch of a locus. */
export function nameOf({ name }, criticality) {
  return criticality ? `${name}, ${criticality}` : name;
}

/**
 * A plane as far as it is computed, of the lines that are being followed.
 * @param {object[]} lines the server's
 */
export function draftOf(lines) {
  const loci = lines.map(({ type, period, x, y }) => (
    { type, period, name: `${type} of period ${period}`, stretches: [{ criticality: null, x, y }], special: [] }));
  return { loci, regions: null, isDraft: true };
}

/**
 * All traces of a plane.
 * @param {object} plane the server's answer
 * @param {(name: string) => string} colour
 * @param {[number, number]} factors of the two axes
 * @param {string[]} positions where the names of the points stand
 * @param {object[]} motions what is drawn between areas and lines
 * @returns {object[]}
 */
export function planeTraces(plane, colour, [fx, fy], positions, motions) {
  return [
    ...regionTraces(plane.regions, colour, fx, fy),
    ...motions,
    ...plane.loci.flatMap((locus) => locusTraces(locus, colour, fx, fy, plane.isDraft)),
    specialTrace(markedPoints(plane), positions, colour, fx, fy),
  ];
}

/**
 * The points of codimension two, each once, whatever number of loci meets there.
 * @param {object} plane the server's answer
 */
export function markedPoints({ loci }) {
  const points = new Map();
  for (const point of loci.flatMap((locus) => locus.special)) {
    const { type, x, y } = point;
    if (UNMARKED.includes(type)) continue;
    points.set(`${type} ${x.toPrecision(4)} ${y.toPrecision(4)}`, point);
  }
  return [...points.values()];
}

function regionTraces(regions, colour, fx, fy) {
  if (!regions) return [];
  const ids = Object.keys(regions.names).map(Number);
  const largest = Math.max(1, ...ids);
  const tint = (id) => (id in regions.stable ? regionColour(regions.stable[id], colour) : "rgba(0,0,0,0)");
  const scale = Array.from({ length: largest + 1 }, (_, id) => [
    [id / (largest + 1), tint(id)], [(id + 1) / (largest + 1), tint(id)],
  ]).flat();
  return [{
    type: "heatmap", x: regions.x.map((v) => v * fx), y: regions.y.map((v) => v * fy),
    z: regions.labels, zmin: -0.5, zmax: largest + 0.5, colorscale: scale, showscale: false,
    hoverinfo: "skip", zsmooth: false,
  }];
}

function locusTraces(locus, colour, fx, fy, isDraft) {
  return locus.stretches.map(({ criticality, x, y }) => ({
    type: "scatter", mode: "lines", hoverinfo: "skip", opacity: isDraft ? FAINT : 1,
    name: nameOf(locus, criticality),
    x: x.map((v) => v * fx), y: y.map((v) => v * fy),
    line: lineStyle(locus, criticality, colour),
  }));
}

function specialTrace(special, positions, colour, fx, fy) {
  return {
    type: "scatter", mode: "markers+text", hoverinfo: "skip",
    x: special.map(({ x }) => x * fx), y: special.map(({ y }) => y * fy),
    text: special.map(({ type }) => escaped(type)), textposition: positions,
    textfont: { size: 11, color: colour("ink") },
    marker: { size: 6, color: colour("ink") },
  };
}

/**
 * The names of the regions where they fit.
 * @param {object|null} regions
 * @param {(name: string) => string} colour
 * @param {[number, number]} factors
 * @param {{width: number, height: number}} frame of the plot in pixels
 */
export function regionNames(regions, colour, [fx, fy], frame) {
  if (!regions) return [];
  return regionPlaces(regions, frame).map(({ text, x, y }) => ({
    x: x * fx, y: y * fy, text: escaped(text), showarrow: false,
    font: { size: 12, color: colour("muted") },
  }));
}
