/** The view in the page's address: what follows the # gives the same page to whoever opens it. */

import { initialView } from "./view.js";

/**
 * Write a view; what has the model's default value is left out.
 * @param {import("./view.js").View} view
 * @param {object} model as the server describes it
 * @returns {string} without the #
 */
export function addressOf(view, model) {
  const usual = initialView(model);
  const query = new URLSearchParams({ model: view.model });
  const put = (key, value) => query.set(key, value);
  if (view.vary !== usual.vary) put("vary", view.vary);
  if (view.vary !== usual.vary || !same(view.span, usual.span)) put("span", view.span.join("~"));
  if (view.show !== usual.show) put("show", view.show);
  if (view.statistic !== usual.statistic) put("of", view.statistic);
  for (const [name, text] of changed(view.parameters, usual.parameters)) put(`p.${name}`, text);
  if (view.at) put("at", `${view.at.branch}~${digits(view.at.y)}`);
  if (view.zoom) put("zoom", [...view.zoom.x, ...view.zoom.y].map(digits).join("~"));
  if (!same(view.plane, usual.plane)) put("plane", view.plane ? planeText(view.plane) : "none");
  for (const pin of view.pins) {
    const inner = new URLSearchParams({ name: pin.name });
    for (const [name, text] of changed(pin.parameters, usual.parameters)) inner.set(name, text);
    query.append("pin", inner.toString());
  }
  return query.toString().replaceAll("%7E", "~");
}

/** The span of a parameter that was not given one: that of its slider. */
export function spanOf(model, vary, usual = initialView(model)) {
  if (vary === usual.vary) return usual.span;
  const { low, high } = model.parameters.find((item) => item.name === vary);
  return [low, high];
}

function changed(values, usual) {
  return Object.entries(values)
    .filter(([name, value]) => value !== usual[name])
    .map(([name, value]) => [name, digits(value)]);
}

/** Twelve digits: more than anyone sets, and no trace of the last bit. */
function digits(value) {
  return String(Number(value.toPrecision(12)));
}

function planeText({ x, y }) {
  return [x.name, ...x.span.map(digits), y.name, ...y.span.map(digits)].join("~");
}

function same(a, b) {
  return JSON.stringify(a) === JSON.stringify(b);
}
