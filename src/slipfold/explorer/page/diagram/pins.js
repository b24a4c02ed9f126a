/** Pinned curves: their colours and names, and how to let go of them. */

import { element, icon } from "../controls/dom.js";
import { withUnit } from "../parameters/quantities.js";
import { initialView, withPin, withPinName, withoutPin } from "../session/view.js";

const CROSS = "M4 4l8 8M12 4l-8 8";
const MOST = 12;

export class Pins {
  /** The element to put on the page. */
  node = element("div", { class: "pins" });
  #list = element("ul", { "aria-label": "Curves" });
  #session;

  /** @param {import("../session/session.js").Session} session */
  constructor(session) {
    this.#session = session;
    const pin = element("button", { type: "button", class: "small-button", on: { click: () => this.pin() } },
      "Pin this curve");
    this.node.append(this.#list, pin);
    session.store.changed.subscribe(({ view, before }) => {
      pin.disabled = view.pins.length >= MOST;
      if (view.pins !== before.pins) this.#show(view.pins);
    });
    this.#show(session.view.pins);
  }

  /** Keep the live curve for comparison. */
  pin() {
    const { store, view } = this.#session;
    store.commit(withPin(view, this.#nameOf(view)));
  }

  /** A curve's name: how it differs from the model's own values. */
  #nameOf(view) {
    const usual = initialView(this.#session.model).parameters;
    const differing = this.#session.model.parameters.filter(({ name }) =>
      name !== view.vary && view.parameters[name] !== usual[name]);
    if (differing.length === 0) return "base case";
    return differing.map((parameter) =>
      `${parameter.label ?? parameter.name} = ${withUnit(parameter, view.parameters[parameter.name])}`).join(", ");
  }

  #show(pins) {
    const items = pins.map((pin, i) => element("li", { class: `pin pin-${(i % 6) + 1}` },
      element("span", { class: "swatch", "aria-hidden": "true" }), this.#name(pin),
      element("button", {
        type: "button", class: "quiet close", "aria-label": `Remove ${pin.name}`,
        on: { click: () => this.#session.store.commit(withoutPin(this.#session.view, pin.id)) },
      }, icon(CROSS))));
    const live = element("li", { class: "pin live" },
      element("span", { class: "swatch", "aria-hidden": "true" }), "live");
    this.#list.replaceChildren(...(pins.length ? [live, ...items] : []));
  }

  #name(pin) {
    const input = element("input", {
      type: "text", value: pin.name, maxlength: "60", "aria-label": "Name of the pinned curve",
      on: {
        change: () => this.#session.store.commit(withPinName(this.#session.view, pin.id, input.value)),
      },
    });
    input.size = Math.max(pin.name.length, 6);
    return input;
  }
}
