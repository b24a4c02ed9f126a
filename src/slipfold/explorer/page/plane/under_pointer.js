/** What there is at the place of the plane under the pointer, in words. */

import { element } from "../controls/dom.js";
import { withUnit } from "../parameters/quantities.js";

export class UnderPointer {
  /** The element to put on the page. */
  node = element("p", { class: "under-pointer" });

  /**
   * Tell of a place; null tells nothing.
   * @param {{x: object, y: object, at: [number, number], shown: object|null, picture: object|null}|null} place
   *   quantities of both axes, their values in SI units, the plane's answer and the picture of regimes
   */
  show(place) {
    this.node.textContent = place ? sentence(place) : "";
  }
}

function sentence({ x, y, at, shown, picture }) {
  const values = [x, y].map((axis, i) => `${axis.label ?? axis.name} = ${withUnit(axis, Number(at[i].toPrecision(4)))}`);
  const known = [...regimeAt(picture, at), ...regionAt(shown?.regions, at)];
  return `${values.join(", ")}${known.length ? ": " : ""}${known.join("; ")}`;
}

function regionAt(regions, at) {
  const id = regions && cellOf(regions.labels, regions.x, regions.y, at);
  if (!id) return [];
  if (!regions.known[id]) return ["not known what is stable"];
  return [regions.stable[id].length ? `stable: ${regions.names[id]}` : "neither period 1 nor 2 stable"];
}

function regimeAt(picture, at) {
  const number = picture && cellOf(picture.labels, picture.x.values, picture.y.values, at);
  return number ? [`motion from the start: ${picture.names[number - 1]}`] : [];
}

/** The label of the cell in which a place lies. */
function cellOf(labels, first, second, [x, y]) {
  return labels[nearest(second, y)][nearest(first, x)];
}

/** The number of the nearest of evenly spaced values. */
function nearest(values, value) {
  const step = (values.at(-1) - values[0]) / (values.length - 1);
  return Math.min(Math.max(Math.round((value - values[0]) / step), 0), values.length - 1);
}
