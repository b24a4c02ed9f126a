/** All parameters of the model, one row each. */

import { element } from "./dom.js";
import { ParameterControl } from "./parameter_control.js";
import { withParameter } from "./view.js";

export class ParameterPanel {
  /** The element to put on the page. */
  node = element("div", { class: "parameters", role: "group", "aria-label": "Parameters" });
  #session;
  #controls = new Map();
  #model = null;

  /** @param {import("./session.js").Session} session */
  constructor(session) {
    this.#session = session;
    session.store.changed.subscribe(() => this.#show());
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
    const { store } = this.#session;
    this.#model = model;
    this.#controls = new Map(model.parameters.map((parameter) => {
      const changed = (value) => withParameter(this.#session.view, parameter.name, value);
      const control = new ParameterControl(parameter, {
        preview: (value) => store.preview(changed(value)),
        commit: (value) => store.commit(changed(value)),
      });
      return [parameter.name, control];
    }));
    this.node.replaceChildren(...[...this.#controls.values()].map(({ node }) => node));
  }
}
