/** All parameters of the model, one row each, and what the one is that is pointed at. */

import { element } from "../controls/dom.js";
import { ParameterControl } from "./parameter_control.js";
import { withParameter } from "../session/view.js";

export class ParameterPanel {
  /** The element to put on the page. */
  node;
  #rows = element("div", { class: "parameters", role: "group", "aria-label": "Parameters" });
  // It has a place of its own: were it in the rows, they would move under the pointer.
  #meaning = element("span");
  #session;
  #controls = new Map();
  #model = null;

  /**
   * @param {import("../session/session.js").Session} session
   * @param {import("../session/refusals.js").Refusals} refusals
   */
  constructor(session, refusals) {
    this.#session = session;
    this.node = element("div", { class: "parameter-panel" }, this.#rows,
      element("p", { class: "meaning", "aria-hidden": "true" }, this.#meaning));
    const explain = () => this.#explain();
    for (const event of ["pointerover", "pointerleave", "focusin", "focusout"]) {
      this.#rows.addEventListener(event, explain);
    }
    session.store.changed.subscribe(() => this.#show());
    refusals.changed.subscribe((sentences) => {
      for (const [name, control] of this.#controls) control.refuse(sentences[name] ?? null);
    });
    this.#show();
  }

  #show() {
    const { model, view } = this.#session;
    if (model !== this.#model) this.#build(model);
    for (const parameter of model.parameters) {
      const isVaried = parameter.name === view.vary;
      const bounds = isVaried ? view.span : [parameter.low, parameter.high];
      const value = view.parameters[parameter.name];
      this.#controls.get(parameter.name).show(value, bounds, isVaried);
    }
  }

  #build(model) {
    const { store, failed } = this.#session;
    this.#model = model;
    this.#controls = new Map(model.parameters.map((parameter) => {
      const changed = (value) => withParameter(this.#session.view, parameter.name, value);
      const control = new ParameterControl(parameter, {
        preview: (value) => store.preview(changed(value)),
        commit: (value) => store.commit(changed(value)),
        refuse: (sentence) => failed.announce({ kind: "input", sentence }),
      });
      return [parameter.name, control];
    }));
    this.#rows.replaceChildren(...[...this.#controls.values()].map(({ node }) => node));
    this.#explain();
  }

  /** Say what the parameter under the pointer is, else that which has the focus. */
  #explain() {
    const row = this.#rows.querySelector(".parameter:hover") ?? this.#rows.querySelector(".parameter:focus-within");
    const parameter = this.#model.parameters.find(({ name }) => name === row?.dataset.name);
    this.#meaning.textContent = parameter ? `${parameter.label ?? parameter.name}: ${parameter.doc}` : "";
  }
}
