/** What the lines and shades of the plane mean: below it, where a laptop has room for the words. */

import { element, svg } from "../controls/dom.js";
import { lineStyle, nameOf } from "./plane_traces.js";
import { regimeKeys } from "./regime_shades.js";
import { regionColour } from "./region_colours.js";
import { colours } from "../style/theme.js";

const HARD = "subcritical";

/** The lines of a plane, each type and period once, and what dashes mean if a line has both kinds. */
function lineKeys({ loci }) {
  const names = [...new Set(loci.map(({ name }) => name))].sort();
  const keys = names.map((name) => {
    const [locus, ...others] = loci.filter((item) => item.name === name);
    const kinds = [locus, ...others].flatMap(({ stretches }) => stretches.map(({ criticality }) => criticality));
    const criticality = kinds.find((kind) => kind === "supercritical") ?? kinds[0];
    const isHard = kinds.every((kind) => kind === HARD);
    return { name: isHard ? nameOf(locus, HARD) : name, locus, criticality, isMixed: !isHard && kinds.includes(HARD) };
  });
  const mixed = keys.find(({ isMixed }) => isMixed);
  return mixed ? [...keys, { name: HARD, locus: { ...mixed.locus, type: "" }, criticality: HARD }] : keys;
}

/**
 * Names and colours of the shades that are seen: those of motions where there are such.
 * @param {object|null} plane the server's answer, or as far as it has come
 * @param {object|null} picture of what motions do
 * @param {(name: string) => string} colour
 * @returns {{name: string, tint: string}[]}
 */
export function shadesOf(plane, picture, colour) {
  if (picture) return regimeKeys(picture).map(({ name, tint }) => ({ name, tint: colour(tint) }));
  return shadeKeys(plane ?? { regions: null }).map(({ name, stable }) => ({ name, tint: regionColour(stable, colour) }));
}

/** The shades of regions, each once; what is unknown has none. */
function shadeKeys({ regions }) {
  if (!regions) return [];
  const keys = Object.entries(regions.stable).map(([id, stable]) =>
    ({ name: words(regions.names[id], stable), stable }));
  const rank = ({ stable }) => stable.length || Infinity;
  return distinct(keys).sort((a, b) => rank(a) - rank(b) || (a.name < b.name ? -1 : 1));
}

export class PlaneLegend {
  /** The element to put on the page. */
  node = element("ul", { class: "plane-legend", "aria-label": "Lines and areas of the plane" });

  /**
   * @param {object|null} plane the server's answer, or as far as it has come
   * @param {object|null} picture of what motions do
   */
  show(plane, picture) {
    const colour = colours();
    const lines = plane ? lineKeys(plane) : [];
    const shades = shadesOf(plane, picture, colour);
    this.node.replaceChildren(
      ...lines.map(({ name, locus, criticality }) =>
        element("li", {}, sample(lineStyle(locus, criticality, colour)), name)),
      ...shades.map(({ name, tint }) =>
        element("li", {}, element("span", { class: "shade", style: `background: ${tint}` }), name)));
  }
}

function words(name, stable) {
  if (stable.length === 0) return "none stable";
  return stable.length > 1 ? `${name}, ${stable.length === 2 ? "both" : "all"} stable` : `${name} stable`;
}

function sample({ color, width, dash }) {
  const dashes = dash === "solid" ? null : dash.replaceAll("px", "");
  return svg("svg", { viewBox: "0 0 28 8", width: 28, height: 8, "aria-hidden": "true" },
    svg("path", { d: "M0 4H28", stroke: color, "stroke-width": width, "stroke-dasharray": dashes }));
}

function distinct(keys) {
  return [...new Map(keys.map((key) => [key.name, key])).values()];
}
