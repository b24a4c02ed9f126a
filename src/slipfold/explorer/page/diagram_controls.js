/** What the diagram shows: along which parameter, from where to where, and what of which output. */

import { spanOf } from "./address.js";
import { Choice } from "./choice.js";
import { element } from "./dom.js";
import { display, plain } from "./quantities.js";
import { STATISTICS, inside, withVaried } from "./view.js";

export class DiagramControls {
  /** The element to put on the page. */
  node;
  #session;
  #vary;
  #statistic;
  #show;
  #from = this.#bound(0, "from");
  #to = this.#bound(1, "to");
  #unit = element("span", { class: "unit" });
  #whole = element("button", {
    type: "button", class: "quiet absent", on: { click: () => this.#commit({ zoom: null }) },
  }, "Whole diagram");

  /** @param {import("./session.js").Session} session */
  constructor(session) {
    this.#session = session;
    this.#vary = new Choice("Vary", (name) => this.#varied(name));
    this.#statistic = new Choice("Draw", (statistic) => this.#commit({ statistic, at: null, zoom: null }));
    this.#show = new Choice("of", (show) => this.#commit({ show, at: null, zoom: null }));
    this.node = element("div", { class: "sentence" },
      this.#vary.node, element("span", {}, "from"), this.#from, element("span", {}, "to"), this.#to,
      this.#unit, this.#statistic.node, this.#show.node, this.#whole);
    session.store.changed.subscribe(() => this.#refresh());
    this.#refresh();
  }

  #refresh() {
    const { model, view } = this.#session;
    this.#vary.show(model.parameters.map(option), view.vary);
    this.#show.show([...model.states, ...model.outputs].map(option), view.show);
    this.#statistic.show(
      Object.entries(STATISTICS).map(([value, text]) => ({ value, text })), view.statistic);
    const { unit, factor } = display(this.#session.quantity(view.vary));
    this.#from.value = plain(view.span[0] * factor, 6);
    this.#to.value = plain(view.span[1] * factor, 6);
    this.#unit.textContent = unit;
    this.#whole.classList.toggle("absent", view.zoom === null);
  }

  #bound(index, word) {
    return element("input", {
      type: "number", step: "any", class: "bound", "aria-label": `Vary ${word}`,
      on: { change: (event) => this.#bounded(index, event.target) },
    });
  }

  #bounded(index, input) {
    const { view } = this.#session;
    const { factor } = display(this.#session.quantity(view.vary));
    const span = [...view.span];
    span[index] = Number(input.value) / factor;
    if (input.value === "" || span[0] === span[1]) {
      this.#refresh();
      return;
    }
    const value = inside(view.parameters[view.vary], span);
    this.#commit({ span, zoom: null, parameters: { ...view.parameters, [view.vary]: value } });
  }

  #varied(name) {
    const { model, view, store } = this.#session;
    const span = spanOf(model, name);
    const next = withVaried(view, name, span);
    const value = inside(view.parameters[name], span);
    store.commit({ ...next, parameters: { ...view.parameters, [name]: value } });
  }

  #commit(changes) {
    this.#session.store.commit({ ...this.#session.view, ...changes });
  }
}

function option({ name, label, doc, unit }) {
  const text = label && label !== name ? label : name;
  return { value: name, text: unit ? `${text} (${unit})` : text, title: doc };
}
