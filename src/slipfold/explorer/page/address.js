/** The view in the page's address: what follows the # gives the same page to whoever opens it. */

import { STATISTICS, initialView } from "./view.js";

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

/**
 * Read a view; what cannot be read is left at the default.
 * @param {string} text without the #
 * @param {object[]} models
 * @returns {import("./view.js").View|null} null if no known model is named
 */
export function viewOf(text, models) {
  const query = new URLSearchParams(text);
  const model = models.find((item) => item.name === query.get("model"));
  if (!model) return null;
  const usual = initialView(model);
  const known = (name) => model.parameters.some((item) => item.name === name);
  const shown = [...model.states, ...model.outputs].some((item) => item.name === query.get("show"));
  const vary = known(query.get("vary")) ? query.get("vary") : usual.vary;
  const zoom = numbers(query.get("zoom"), 4);
  const at = numbers(query.get("at"), 2);
  return {
    ...usual,
    vary,
    span: numbers(query.get("span"), 2) ?? spanOf(model, vary, usual),
    show: shown ? query.get("show") : usual.show,
    statistic: query.get("of") in STATISTICS ? query.get("of") : usual.statistic,
    parameters: valuesIn(query, "p.", usual.parameters),
    at: at && { branch: at[0], y: at[1] },
    zoom: zoom && { x: zoom.slice(0, 2), y: zoom.slice(2) },
    plane: planeIn(query.get("plane"), known) ?? (query.get("plane") === "none" ? null : usual.plane),
    pins: query.getAll("pin").slice(0, 12).map((inner, i) => pinIn(inner, i + 1, usual)),
  };
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

function valuesIn(query, prefix, usual) {
  const given = Object.keys(usual).map((name) => [name, Number(query.get(prefix + name) ?? NaN)]);
  return { ...usual, ...Object.fromEntries(given.filter(([, value]) => Number.isFinite(value))) };
}

function pinIn(text, id, usual) {
  const query = new URLSearchParams(text);
  const name = (query.get("name") ?? "").slice(0, 60);
  query.delete("name");
  return { id, name, parameters: valuesIn(query, "", usual.parameters) };
}

function planeText({ x, y }) {
  return [x.name, ...x.span.map(digits), y.name, ...y.span.map(digits)].join("~");
}

function planeIn(text, known) {
  const parts = (text ?? "").split("~");
  const spans = [parts.slice(1, 3), parts.slice(4, 6)].map((pair) => numbers(pair.join("~"), 2));
  if (parts.length !== 6 || !known(parts[0]) || !known(parts[3]) || spans.includes(null)) return null;
  return { x: { name: parts[0], span: spans[0] }, y: { name: parts[3], span: spans[1] } };
}

function numbers(text, count) {
  const values = (text ?? "").split("~").map((part) => (part === "" ? NaN : Number(part)));
  return values.length === count && values.every(Number.isFinite) ? values : null;
}

function same(a, b) {
  return JSON.stringify(a) === JSON.stringify(b);
}
