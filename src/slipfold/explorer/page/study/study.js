/** A study as the server tells it: values of parameters and what was found, case by case. */

import { initialView, inside } from "../session/view.js";

export class Study {
  /** @param {object} told the server's answer */
  constructor(told) {
    Object.assign(this, told);
    this.count = told.reasons.length;
  }

  /** All cases as the rows of a spreadsheet, in SI units: as `to_csv` has them. */
  table() {
    const columns = [...this.parameters, ...this.quantities];
    const heads = columns.map(({ name, unit }) => (unit ? `${name} (${unit})` : name));
    const rows = this.reasons.map((reason, i) => [i, ...columns.map(({ values }) => values[i] ?? ""), reason]);
    return [["case", ...heads, "failed"], ...rows].map((row) => `${row.map(cell).join(",")}\n`).join("");
  }

  /** A parameter by name. */
  parameter(name) {
    return this.parameters.find((item) => item.name === name);
  }

  /** All values of a parameter, each once. */
  axis(name) {
    return [...new Set(this.parameter(name).values)].sort((a, b) => a - b);
  }

  /**
   * The cases that a picture shows: of a grid those at some values of the parameters that it does not.
   * @param {string} x
   * @param {string|null} y
   * @param {Record<string, number>} at
   * @returns {number[]}
   */
  seen(x, y, at) {
    const fixed = this.isGrid ? this.parameters.filter(({ name }) => name !== x && name !== y) : [];
    return [...Array(this.count).keys()].filter((i) => fixed.every(({ name, values }) => values[i] === at[name]));
  }

  /** The case that a view shows, or -1. */
  shownBy({ model, parameters }) {
    if (model !== this.model) return -1;
    // An address has twelve digits of a value.
    const isSame = (a, b) => Math.abs(a - b) <= 1e-10 * Math.max(Math.abs(a), Math.abs(b));
    return this.reasons.findIndex((_, i) =>
      this.parameters.every(({ name, values }) => isSame(values[i], parameters[name])));
  }

  /**
   * The view of a case: what was computed of it, as far as the page shows that.
   * @param {number} number
   * @param {import("../session/view.js").View} view
   * @param {object[]} models
   */
  viewOf(number, view, models) {
    const usual = initialView(models.find(({ name }) => name === this.model));
    const base = view.model === this.model ? view : usual;
    const own = Object.fromEntries(this.parameters.map(({ name, values }) => [name, values[number]]));
    const vary = this.vary ?? base.vary;
    const ends = this.span ?? base.span;
    const span = vary in own ? [Math.min(...ends, own[vary]), Math.max(...ends, own[vary])] : ends;
    const value = inside(own[vary] ?? base.parameters[vary], span);
    const parameters = { ...usual.parameters, ...own, [vary]: value };
    return { ...base, vary, span, parameters, at: null, zoom: null };
  }
}

/** What a cell of a spreadsheet holds. */
function cell(value) {
  const text = String(value);
  return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
