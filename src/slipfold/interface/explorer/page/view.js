/** What the page shows as a value: how it changes, its requests, and the address that holds it. */

import { parsed } from "./quantities.js";

/** Where along a diagram the working point is at first, if the model does not say. */
const FIRST = 0.3;

/** What a diagram may show of an output, with the words for it. */
export const STATISTICS = {
  max: "max",
  min: "min",
  max_and_min: "max and min",
  peak_to_peak: "peak to peak",
  modulus: "max |·|",
};

/** What is drawn together: the largest and the smallest value are two lines. */
export function partsOf(statistic) {
  return statistic === "max_and_min" ? ["max", "min"] : [statistic];
}

/**
 * The view of a model that was just picked.
 * @param {object} model as the server describes it
 */
export function initialView(model) {
  const { vary, span, show, statistic = "modulus", parameters = {} } = model.default;
  const values = Object.fromEntries(model.parameters.map((item) => [item.name, item.value]));
  const given = { ...values, ...parameters };
  given[vary] = within(given[vary], span);
  return {
    model: model.name,
    parameters: given,
    vary,
    span,
    show,
    statistic,
    at: null,
    also: [],
    pins: [],
    plane: model.plane ?? null,
    zoom: null,
    ranges: {},
  };
}

/** A view with one parameter changed. */
export function withParameter(view, name, value) {
  return { ...view, parameters: { ...view.parameters, [name]: value } };
}

/** A view with another range of a parameter's slider; what is varied has its span. */
export function withRange(view, name, range) {
  const next = withParameter(view, name, inside(view.parameters[name], range));
  if (name === view.vary) return { ...next, span: range, zoom: null };
  return { ...next, ranges: { ...view.ranges, [name]: range } };
}

/** The range of a parameter's slider. */
export function rangeOf({ ranges }, { name, low, high }) {
  return ranges[name] ?? [low, high];
}

/**
 * A view along another parameter.
 * @param {Start|null} start of the orbit that is looked at, which stays in sight
 * @param {number} [y] what the diagram shows of it
 */
export function withVaried(view, vary, span, start = null, y = 0) {
  return { ...view, vary, span, at: start && { branch: ANY, y }, also: start ? [start] : [], zoom: null };
}

/** Of the working point: the branch whose orbit comes nearest. */
export const ANY = 0;

/** Further starts that a diagram may have. */
const MOST_STARTS = 8;

/**
 * @typedef {object} Start where a branch begins besides those of the response
 * @property {number} value of the parameter that is varied
 * @property {Record<string, number>} state
 * @property {number} [period] of an orbit; without it a solution from the state leads to one
 * @property {number} [duration] of a cycle, in s
 */

/**
 * A view whose diagram has a further branch.
 * @param {Start} start
 * @param {number|null} y what the diagram shows of it, if that is known
 */
export function withStart(view, start, y = null) {
  const parameters = { ...view.parameters, [view.vary]: start.value };
  const also = [...view.also, start].slice(-MOST_STARTS);
  return { ...view, parameters, also, at: y === null ? null : { branch: ANY, y } };
}

/** A view with one more pinned curve. */
export function withPin(view, name) {
  const id = 1 + Math.max(0, ...view.pins.map((pin) => pin.id));
  return { ...view, pins: [...view.pins, { id, name, parameters: view.parameters }] };
}

/** A view without a pinned curve. */
export function withoutPin(view, id) {
  return { ...view, pins: view.pins.filter((pin) => pin.id !== id) };
}

/** A view with a pinned curve renamed. */
export function withPinName(view, id, name) {
  return { ...view, pins: view.pins.map((pin) => (pin.id === id ? { ...pin, name } : pin)) };
}

/**
 * The request for the diagram of a view.
 * @param {Record<string, number>} [parameters] those of a pinned curve
 */
export function diagramRequest(view, parameters = view.parameters) {
  const { model, vary, span, show, statistic, also } = view;
  return { kind: "diagram", model, parameters: without(parameters, vary), vary, span, show, statistic, also };
}

/** What a diagram of a view depends on, but for what it shows: a motion on it belongs to that. */
export function systemOf({ model, vary, parameters }) {
  return JSON.stringify([model, vary, without(parameters, vary)]);
}

/** What a motion of a view depends on. */
export function solutionOf({ model, parameters }) {
  return JSON.stringify([model, parameters]);
}

/**
 * The request for a motion that is swept along the diagram of a view.
 * @param {Start|null} from the motion that is followed both ways; from end to end if null
 */
export function sweepRequest(view, from = null) {
  const { also: _, ...request } = diagramRequest(view);
  return { ...request, kind: "sweep", ...(from && { start: from.state, begin: from.value }) };
}

/** The request for an orbit on the diagram of a view. */
export function orbitRequest(view, { branch, arclength, x, isTurn = false, special }) {
  const { model, vary, span, also } = view;
  const parameters = without(view.parameters, vary);
  const at = isTurn || special ? { branch, arclength } : { branch, arclength, value: x };
  return { kind: "orbit", model, parameters, vary, span, also, at };
}

/** The request for the plane of a view. */
export function planeRequest(view) {
  const { x, y } = view.plane;
  const parameters = without(without(view.parameters, x.name), y.name);
  return { kind: "plane", model: view.model, parameters, x, y };
}

/** The request for a simulation at the working point of a view. */
export function simulationRequest(view, how) {
  return { kind: "simulation", model: view.model, parameters: view.parameters, ...how };
}

/** The request for the exponents of a motion at the working point of a view. */
export function exponentsRequest(view, how) {
  return { kind: "exponents", model: view.model, parameters: view.parameters, ...how };
}

/**
 * The request for the basins of attraction at the working point of a view.
 * @param {Axis} x of a state
 * @param {Axis} y of another
 */
export function basinsRequest({ model, parameters }, x, y) {
  return { kind: "basins", model, parameters, x, y };
}

/** A value, or the nearest one in a span. */
export function inside(value, [a, b]) {
  return Math.min(Math.max(value, Math.min(a, b)), Math.max(a, b));
}

/** A working point that shows something: not at the very end of the diagram. */
function within(value, [a, b]) {
  const isInner = value > Math.min(a, b) && value < Math.max(a, b);
  return isInner ? value : a + (b - a) * FIRST;
}

function without(values, name) {
  const { [name]: _, ...rest } = values;
  return rest;
}

/**
 * Write a view; what has the model's default value is left out.
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
  if (model.text && isShort(model)) put("text", model.text);
  for (const [name, range] of Object.entries(view.ranges)) put(`range.${name}`, range.map(digits).join("~"));
  for (const start of view.also) query.append("also", startText(start));
  for (const pin of view.pins) {
    const inner = new URLSearchParams({ name: pin.name });
    for (const [name, text] of changed(pin.parameters, usual.parameters)) inner.set(name, text);
    query.append("pin", inner.toString());
  }
  return query.toString().replaceAll("%7E", "~");
}

/** Characters of a model's text in a link: programs cut longer ones. */
const LONGEST_TEXT = 6000;

/** Whether a link can hold the model, as the server describes it. */
export function isShort({ text = "" }) {
  return text.length <= LONGEST_TEXT;
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

/** A start in full: what Newton's method or a solution makes of it depends on it. */
function startText({ value, state, period, duration }) {
  const inner = new URLSearchParams({ at: value });
  if (period) inner.set("period", period);
  if (duration) inner.set("duration", duration);
  for (const [name, number] of Object.entries(state)) inner.set(`s.${name}`, number);
  return inner.toString();
}

function planeText({ x, y }) {
  return [x.name, ...x.span.map(digits), y.name, ...y.span.map(digits)].join("~");
}

function same(a, b) {
  return JSON.stringify(a) === JSON.stringify(b);
}

const KEYS = ["model", "vary", "span", "show", "of", "at", "also", "zoom", "plane", "pin", "text"];
const MOST_PINS = 12;
const MOST_FAULTS = 4;

/**
 * Read a view; what cannot be read is left at the default.
 * @param {string} text without the #
 * @returns {{view: View|null, sentence: string|null}} no view if no known model
 * is named, and what could not be read
 */
export function readAddress(text, models) {
  const query = new URLSearchParams(text);
  const model = models.find((item) => item.name === query.get("model"));
  if (model) {
    const reader = new AddressReader(query, model);
    return { view: reader.view(), sentence: sentenceOf(reader.faults) };
  }
  const named = query.get("model");
  const fault = named === null ? "it names no model" : `there is no model '${named}'`;
  return { view: null, sentence: text === "" ? null : sentenceOf([fault]) };
}

function sentenceOf(faults) {
  if (faults.length === 0) return null;
  const more = faults.length > MOST_FAULTS ? "; and more" : "";
  return `Not all of this link could be read: ${faults.slice(0, MOST_FAULTS).join("; ")}${more}. The model's own values are used instead.`;
}

class AddressReader {
  /** What could not be read, in words. */
  faults = [];
  #query;
  #model;

  constructor(query, model) {
    this.#query = query;
    this.#model = model;
  }

  view() {
    const model = this.#model;
    const usual = initialView(model);
    const shown = [...model.states, ...model.outputs].map(({ name }) => name);
    const vary = this.#oneOf("vary", model.parameters.map(({ name }) => name)) ?? usual.vary;
    const zoom = this.#numbers("zoom", 4);
    const at = this.#numbers("at", 2);
    this.#refuseUnknown(usual.parameters);
    return {
      ...usual,
      vary,
      span: this.#span() ?? spanOf(model, vary, usual),
      show: this.#oneOf("show", shown) ?? usual.show,
      statistic: this.#oneOf("of", Object.keys(STATISTICS)) ?? usual.statistic,
      parameters: this.#values(this.#query, "p.", usual.parameters),
      also: this.#starts(),
      at: at && { branch: at[0], y: at[1] },
      zoom: zoom && { x: zoom.slice(0, 2), y: zoom.slice(2) },
      plane: this.#plane(usual.plane),
      ranges: this.#ranges(),
      pins: this.#query.getAll("pin").slice(0, MOST_PINS).map((inner, i) => this.#pin(inner, i + 1, usual)),
    };
  }

  #fault(key, why) {
    this.faults.push(`${key} = '${this.#query.get(key)}' ${why}`);
    return null;
  }

  #oneOf(key, names) {
    const value = this.#query.get(key);
    if (value === null || names.includes(value)) return value;
    return this.#fault(key, `is none of ${names.join(", ")}`);
  }

  #numbers(key, count) {
    const text = this.#query.get(key);
    if (text === null) return null;
    return numbersIn(text, count) ?? this.#fault(key, `is not ${count} numbers with ~ between them`);
  }

  #span() {
    const span = this.#numbers("span", 2);
    return span && span[0] === span[1] ? this.#fault("span", "is empty") : span;
  }

  #ranges() {
    const names = this.#model.parameters.map(({ name }) => name).filter((name) => this.#query.has(`range.${name}`));
    const read = (name) => {
      const range = this.#numbers(`range.${name}`, 2);
      return range && range[0] >= range[1] ? this.#fault(`range.${name}`, "does not grow") : range;
    };
    return Object.fromEntries(names.map((name) => [name, read(name)]).filter(([, range]) => range));
  }

  #plane(usual) {
    const text = this.#query.get("plane");
    if (text === null || text === "none") return text === null ? usual : null;
    const [x, a, b, y, c, d, ...rest] = text.split("~");
    const spans = [numbersIn(`${a}~${b}`, 2), numbersIn(`${c}~${d}`, 2)];
    const isKnown = (name) => this.#model.parameters.some((item) => item.name === name);
    if (rest.length === 0 && isKnown(x) && isKnown(y) && x !== y && spans.every((span) => span && span[0] < span[1])) {
      return { x: { name: x, span: spans[0] }, y: { name: y, span: spans[1] } };
    }
    this.#fault("plane", "is not two parameters with two growing numbers each");
    return usual;
  }

  #starts() {
    const read = this.#query.getAll("also").slice(0, MOST_STARTS).map((text) => this.#start(new URLSearchParams(text)));
    if (read.includes(null)) this.#fault("also", "is no value with states of the model");
    return read.filter(Boolean);
  }

  #start(query) {
    const numbers = Object.fromEntries([...query].map(([key, text]) => [key, text.trim() === "" ? NaN : Number(text)]));
    const { at, period, duration, ...rest } = numbers;
    const state = Object.fromEntries(Object.entries(rest).map(([key, value]) => [key.replace(/^s\./, ""), value]));
    const isKnown = Object.keys(state).every((name) => this.#model.states.some((item) => item.name === name));
    const isRound = period === undefined || (Number.isInteger(period) && period > 0);
    if (at === undefined || !isKnown || !isRound || !Object.values(numbers).every(Number.isFinite)) return null;
    return { value: at, state, ...(period && { period }), ...(duration > 0 && { duration }) };
  }

  #pin(text, id, usual) {
    const query = new URLSearchParams(text);
    const name = (query.get("name") ?? "").slice(0, 60);
    query.delete("name");
    for (const key of query.keys()) if (!(key in usual.parameters)) this.#unknown(key);
    return { id, name, parameters: this.#values(query, "", usual.parameters) };
  }

  #values(query, prefix, usual) {
    const values = { ...usual };
    for (const parameter of this.#model.parameters) {
      const text = query.get(prefix + parameter.name);
      if (text === null) continue;
      const { value, sentence } = parsed(text, parameter);
      if (sentence) this.faults.push(sentence);
      else values[parameter.name] = value;
    }
    return values;
  }

  #refuseUnknown(parameters) {
    for (const key of new Set(this.#query.keys())) {
      const [, name = null] = /^(?:p|range)\.(.*)$/.exec(key) ?? [];
      if (name !== null && !(name in parameters)) this.#unknown(name);
      else if (name === null && !KEYS.includes(key)) this.#fault(key, "is no part of a link");
    }
  }

  #unknown(name) {
    this.faults.push(`${this.#model.name} has no parameter '${name}'`);
  }
}

function numbersIn(text, count) {
  const values = text.split("~").map((part) => (part.trim() === "" ? NaN : Number(part)));
  return values.length === count && values.every(Number.isFinite) ? values : null;
}
