/** Taking a file of readings, what it holds, and letting go of it. */

import { spanOf } from "../session/address.js";
import { element, icon, svg } from "../controls/dom.js";
import { valueTitle } from "../diagram/diagram_plot.js";
import { inside, withVaried } from "../session/view.js";
import { WAYS } from "./reading_traces.js";

const CROSS = "M4 4l8 8M12 4l-8 8";

export class ReadingsControl {
  /** The element to put on the page. */
  node;
  #session;
  #readings;
  #held = element("span", { class: "readings" });

  /**
   * @param {import("../session/session.js").Session} session
   * @param {import("./readings.js").Readings} readings
   */
  constructor(session, readings) {
    this.#session = session;
    this.#readings = readings;
    const input = element("input", {
      type: "file", accept: ".csv,.txt,text/csv", hidden: true, "aria-label": "File of readings",
      on: { change: () => this.#take(input) },
    });
    const button = element("button", {
      type: "button", class: "small-button", title: "Draw a measured response: a CSV file with units in its head",
      on: { click: () => input.click() },
    }, "Readings…");
    this.node = element("span", { class: "readings" }, button, input, this.#held);
    readings.changed.subscribe(() => this.#show());
    session.store.changed.subscribe(({ live }) => live || this.#show());
  }

  #take(input) {
    const [file] = input.files;
    if (file) this.#readings.read(file);
    input.value = ""; // the same file, changed, may be taken again
  }

  #show() {
    const { file } = this.#readings;
    const { view } = this.#session;
    if (file?.model !== view.model) {
      this.#held.replaceChildren();
      return;
    }
    const isDrawn = this.#readings.of(view) !== null;
    this.#held.replaceChildren(
      element("span", { class: "file-name", title: this.#told(file) }, file.name),
      ...(isDrawn ? this.#legend(file) : [this.#offer(file)]),
      element("button", {
        type: "button", class: "quiet close", "aria-label": `Remove ${file.name}`,
        on: { click: () => this.#readings.remove() },
      }, icon(CROSS)));
  }

  #told({ quantities, vary, values }) {
    return `${values.length} readings of ${quantities.map((item) => this.#titled(item)).join(", ")} over ${vary}`;
  }

  #titled({ show, statistic }) {
    return valueTitle({ ...this.#session.quantity(show), statistic });
  }

  #legend({ sweep }) {
    return Object.entries(WAYS).filter(([way]) => way && sweep.includes(way)).map(([way, { size }]) =>
      element("span", { class: "way" },
        svg("svg", { viewBox: "-6 -6 12 12", class: `glyph${way === "down" ? " hollow" : ""}`, "aria-hidden": "true" },
          svg("circle", { r: size / 2 })), way));
  }

  /** What shows a reading where the diagram shows something else. */
  #offer({ vary, quantities: [first], values }) {
    const go = () => {
      const { model, view, store } = this.#session;
      const ends = vary === view.vary ? view.span : spanOf(model, vary);
      const span = [Math.min(...ends, ...values), Math.max(...ends, ...values)];
      const parameters = { ...view.parameters, [vary]: inside(view.parameters[vary], span) };
      const { show, statistic } = first;
      store.commit({ ...withVaried(view, vary, span), show, statistic, parameters });
    };
    return element("button", { type: "button", class: "small-button", on: { click: go } },
      `Show ${this.#titled(first)} over ${this.#session.quantity(vary).label}`);
  }
}
