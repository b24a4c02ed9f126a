/** What the diagram shows: along which parameter, from where to where, and what of which output. */

import { spanOf } from "../session/address.js";
import { Choice } from "../controls/choice.js";
import { element } from "../controls/dom.js";
import { axisTitle, display } from "../parameters/quantities.js";
import { QuantityBox } from "../parameters/quantity_box.js";
import { STATISTICS, inside, withVaried } from "../session/view.js";

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

  /** @param {import("../session/session.js").Session} session */
  constructor(session) {
    this.#session = session;
    this.#vary = new Choice("Vary", (name) => this.#varied(name));
    this.#statistic = new Choice("Draw", (statistic) => this.#commit({ statistic, at: null, zoom: null }));
    this.#show = new Choice("of", (show) => this.#commit({ show, at: null, zoom: null }));
    this.node = element("div", { class: "sentence" },
      this.#vary.node, element("span", {}, "from"), this.#from.node, element("span", {}, "to"), this.#to.node,
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
    const varied = this.#session.quantity(view.vary);
    const range = view.span[1] - view.span[0];
    this.#from.show(varied, view.span[0], range);
    this.#to.show(varied, view.span[1], range);
    this.#unit.textContent = display(varied).unit;
    this.#whole.classList.toggle("absent", view.zoom === null);
  }

  #bound(index, word) {
    return new QuantityBox({ class: "bound", "aria-label": `Vary ${word}` }, {
      accept: (value) => this.#bounded(index, value),
      refuse: (sentence) => this.#session.failed.announce({ kind: "input", sentence }),
    });
  }

  #bounded(index, end) {
    const { view } = this.#session;
    const span = [...view.span];
    span[index] = end;
    if (span[0] === span[1]) return `the span of ${view.vary} would be empty; give two different values`;
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

function option(quantity) {
  return { value: quantity.name, text: axisTitle(quantity), title: quantity.doc };
}
