/** Measured responses: their values, traces and controls. */

import { withText } from "./connection.js";
import { valueTitle } from "./diagram_plot.js";
import { button, closeButton, element, svg } from "./dom.js";
import { Signal } from "./store.js";
import { posted } from "./toolbar.js";
import { inside, partsOf, spanOf, withVaried } from "./view.js";

/** Most bytes that the server takes at once. */
const MOST = 64 * 1024;

/**
 * @typedef {object} Measured measurements of one quantity
 * @property {number[]} values of what was varied
 * @property {(number|null)[]} measurements null where nothing was read
 * @property {(number|null)[]} errors standard deviations; null where they are not known
 * @property {("up"|"down"|"")[]} sweep how the parameter came to each value
 */

export class Measurements {
  /** Announces nothing: measurements have come or gone. */
  changed = new Signal();
  /** `{name, text, model, vary, values, sweep, quantities}`, or null. */
  file = null;
  #session;
  #asked = 0;

  constructor(session) {
    this.#session = session;
  }

  /** Read a file in place of the one before. */
  async read(file) {
    const number = ++this.#asked;
    const { model } = this.#session.view;
    try {
      const text = await file.text();
      const found = await this.#sent(model, file.name, text);
      if (number !== this.#asked) return;
      this.#take({ ...found, name: file.name, text, model });
    } catch (error) {
      if (number === this.#asked) this.#report(error.message);
    }
  }

  /** Forget the file. */
  remove() {
    this.#asked += 1;
    this.#take(null);
  }

  /**
   * What was measured of an output, over a parameter.
   * @returns {Measured|null} null if that was not measured, or of another model
   */
  of({ vary, show, statistic }) {
    const { file } = this;
    if (file?.model !== this.#session.view.model || file.vary !== vary) return null;
    const found = file.quantities.filter((item) => item.show === show && partsOf(statistic).includes(item.statistic));
    if (found.length === 0) return null;
    const [values, sweep] = [file.values, file.sweep].map((column) => found.flatMap(() => column));
    const [measurements, errors] = ["measurements", "errors"].map((name) => found.flatMap((item) => item[name]));
    return { values, sweep, measurements, errors };
  }

  async #sent(model, name, measurements) {
    const body = JSON.stringify(withText({ model, name, measurements }));
    if (new Blob([body]).size > MOST) {
      throw new Error(`${name} is larger than ${MOST / 1024} kB; leave out lines, or draw it with slipfold plot --measured`);
    }
    return (await posted("/api/measurements", body)).json();
  }

  #take(file) {
    this.file = file;
    this.#report(null);
    this.changed.announce();
  }

  #report(sentence) {
    this.#session.failed.announce({ kind: "measurements", sentence });
  }
}

/** How measurements look by how the parameter came to their values. */
const WAYS = {
  up: { name: "measured, upward", symbol: "circle", size: 5 },
  down: { name: "measured, downward", symbol: "circle-open", size: 9 },
  "": { name: "measured", symbol: "circle", size: 5 },
};

/**
 * Measurements with their errors, a trace a direction; those going down around those going up.
 * @param {Measured|null} measured in SI units
 * @param {[number, number]} factors what its numbers are multiplied with to be shown
 */
export function measurementTraces(measured, [fx, fy], color) {
  if (!measured) return [];
  const { values, measurements, errors } = measured;
  return Object.entries(WAYS).map(([way, { name, symbol, size }]) => {
    const rows = rowsOf(measured).filter((i) => measured.sweep[i] === way);
    const error = { type: "data", array: rows.map((i) => errors[i] * fy), color: color, thickness: 1, width: 2 };
    return {
      type: "scatter", mode: "markers", name, hoverinfo: "skip",
      x: rows.map((i) => values[i] * fx), y: rows.map((i) => measurements[i] * fy), error_y: error,
      marker: { symbol, size, color: color, line: { color: color, width: 1.2 } },
    };
  });
}

/** Ends of all error bars within a span, for the axis. */
export function measurementValues(measured, [a, b]) {
  if (!measured) return [];
  const { values, measurements, errors } = measured;
  return rowsOf(measured).filter((i) => values[i] >= Math.min(a, b) && values[i] <= Math.max(a, b))
    .flatMap((i) => [measurements[i] - errors[i], measurements[i] + errors[i]]);
}

function rowsOf({ measurements }) {
  return [...measurements.keys()].filter((i) => measurements[i] !== null);
}

export class MeasurementsControl {
  /** The button that opens a file. */
  node;
  /** The legend of what is drawn of the file, or a button that shows it. */
  legend = element("span", { class: "measurements" });
  #session;
  #measurements;

  constructor(session, measurements) {
    this.#session = session;
    this.#measurements = measurements;
    const input = element("input", {
      type: "file", accept: ".csv,.txt,text/csv", hidden: true, "aria-label": "File of measurements",
      on: { change: () => this.#take(input) },
    });
    const opener = button("Measurements…", () => input.click(), {
      class: "small-button", title: "Draw a measured response: a CSV file with units in its head",
    });
    this.node = element("span", { class: "take" }, opener, input);
    measurements.changed.subscribe(() => this.#show());
    session.store.changed.subscribe(({ live }) => live || this.#show());
  }

  #take(input) {
    const [file] = input.files;
    if (file) this.#measurements.read(file);
    input.value = ""; // the same file, changed, may be taken again
  }

  #show() {
    const { file } = this.#measurements;
    const { view } = this.#session;
    if (file?.model !== view.model) {
      this.legend.replaceChildren();
      return;
    }
    const isDrawn = this.#measurements.of(view) !== null;
    this.legend.replaceChildren(
      element("span", { class: "file-name", title: this.#description(file) }, file.name),
      ...(isDrawn ? this.#legend(file) : [this.#offer(file)]),
      closeButton(`Remove ${file.name}`, () => this.#measurements.remove()));
  }

  #description({ quantities, vary, values }) {
    return `${values.length} measurements of ${quantities.map((item) => this.#titled(item)).join(", ")} over ${vary}`;
  }

  #titled({ show, statistic }) {
    return valueTitle({ ...this.#session.quantity(show), statistic });
  }

  #legend({ sweep }) {
    return Object.entries(WAYS).filter(([way]) => way && sweep.includes(way)).map(([way, { size }]) =>
      element("span", { class: "way" },
        svg("svg", { viewBox: "-6 -6 12 12", class: `glyph ${way === "down" ? "open" : "full"}`, "aria-hidden": "true" },
          svg("circle", { r: size / 2 })), way));
  }

  /** What shows a measurement where the diagram shows something else. */
  #offer({ vary, quantities: [first], values }) {
    const go = () => {
      const { model, view, store } = this.#session;
      const ends = vary === view.vary ? view.span : spanOf(model, vary);
      const span = [Math.min(...ends, ...values), Math.max(...ends, ...values)];
      const parameters = { ...view.parameters, [vary]: inside(view.parameters[vary], span) };
      const { show, statistic } = first;
      store.commit({ ...withVaried(view, vary, span), show, statistic, parameters });
    };
    return button(`Show ${this.#titled(first)} over ${this.#session.quantity(vary).label}`, go, { class: "small-button" });
  }
}
