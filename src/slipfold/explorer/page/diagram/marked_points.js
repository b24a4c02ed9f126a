/** The points of a branch that have a marker: bifurcations, and the limit of the model it ends at. */

import { withUnit } from "../parameters/quantities.js";

const DIGITS = 6;

/**
 * @param {object} branch of the server's answer
 * @param {object} x what is varied
 * @returns {object[]} as the special points of a branch
 */
export function markedPoints(branch, x) {
  return [...branch.special, ...limitOf(branch, x)];
}

function limitOf({ stopped, x: values, y, arclength }, x) {
  if (stopped.kind !== "limit" || values.length === 0) return [];
  const at = `${x.label} = ${withUnit(x, stopped.value, DIGITS)}`;
  return [{
    type: "LIMIT", value: values.at(-1), y: y.at(-1), arclength: arclength.at(-1), criticality: null,
    words: stopped.reason.split(":")[0], sentence: `${at}: ${stopped.reason}`,
  }];
}
