/** Shows the plane and puts it away; it takes seconds to compute, so not every model begins with it. */

import { spanOf } from "../session/address.js";
import { element } from "../controls/dom.js";

export class PlaneSwitch {
  /** The element to put on the page. */
  node = element("button", {
    type: "button", class: "small-button", on: { click: () => this.#toggle() },
  }, "Plane");
  #session;

  /** @param {import("../session/session.js").Session} session */
  constructor(session) {
    this.#session = session;
    session.store.changed.subscribe(() => this.#show());
    this.#show();
  }

  #show() {
    const { view: { plane }, model } = this.#session;
    // A plane takes two parameters.
    this.node.hidden = model.parameters.length < 2;
    this.node.setAttribute("aria-pressed", String(plane !== null));
    this.node.title = plane ? "Put the plane of two parameters away" : "Show the plane of two parameters";
  }

  #toggle() {
    const { view, model, store } = this.#session;
    store.commit({ ...view, plane: view.plane ? null : model.plane ?? this.#usual() });
  }

  /** What is varied upwards, and the first other parameter across. */
  #usual() {
    const { view, model } = this.#session;
    const other = model.parameters.find(({ name }) => name !== view.vary);
    return {
      x: { name: other.name, span: spanOf(model, other.name) },
      y: { name: view.vary, span: view.span },
    };
  }
}
