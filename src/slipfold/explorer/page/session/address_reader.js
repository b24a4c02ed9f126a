/** Reads a view out of the page's address, and says what in it could not be read. */

import { spanOf } from "./address.js";
import { parsed } from "../parameters/quantity_text.js";
import { STATISTICS, initialView } from "./view.js";

const KEYS = ["model", "vary", "span", "show", "of", "at", "zoom", "plane", "pin"];
const MOST_PINS = 12;
const MOST_TOLD = 4;

/**
 * Read a view; what cannot be read is left at the default.
 * @param {string} text without the #
 * @param {object[]} models
 * @returns {{view: import("./view.js").View|null, sentence: string|null}} no view if no known model
 *   is named, and what could not be read
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
  const more = faults.length > MOST_TOLD ? "; and more" : "";
  return `Not all of this link could be read: ${faults.slice(0, MOST_TOLD).join("; ")}${more}. In its place stands what is usual.`;
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
      at: at && { branch: at[0], y: at[1] },
      zoom: zoom && { x: zoom.slice(0, 2), y: zoom.slice(2) },
      plane: this.#plane(usual.plane),
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
      const name = key.startsWith("p.") ? key.slice(2) : null;
      if (name !== null && !(name in parameters)) this.#unknown(name);
      else if (name === null && !KEYS.includes(key)) this.#fault(key, "says nothing here");
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
