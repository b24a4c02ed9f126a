/** A box for a quantity: shows it in the unit beside it, and takes whatever the command line takes. */

import { element } from "../controls/dom.js";
import { display, plain } from "./quantities.js";
import { parsed } from "./quantity_text.js";
import { roundStep, stepped } from "../plots/steps.js";

const DIGITS = 6;

/** Steps from one end of the range to the other. */
const STEPS = 0.001;

const COUNTS = { ArrowUp: 1, ArrowDown: -1, PageUp: 10, PageDown: -10 };

export class QuantityBox {
  /** The element to put on the page. */
  node;
  #accept;
  #refuse;
  #quantity = null;
  #value = 0;
  #range = 0;
  #isEdited = false;

  /**
   * @param {Record<string, string>} attributes of the element
   * @param {{accept: (value: number) => string|void, refuse: (sentence: string|null) => void}} wishes
   *   accept: takes a value in SI units, and may return why it cannot be used; refuse: shows why, or
   *   null where all is well
   */
  constructor(attributes, { accept, refuse }) {
    this.#accept = accept;
    this.#refuse = refuse;
    this.node = element("input", {
      ...attributes, type: "text", class: `number ${attributes.class ?? ""}`, autocomplete: "off",
      spellcheck: "false",
      on: {
        input: () => { this.#isEdited = true; },
        change: () => this.#take(),
        blur: () => this.#restore(),
        keydown: (event) => this.#key(event),
      },
    });
  }

  /**
   * Show a value; what is just being typed stays.
   * @param {object} quantity a parameter as the server describes it
   * @param {number} value SI
   * @param {number} range what is a long way for it, SI
   */
  show(quantity, value, range) {
    if (quantity !== this.#quantity) this.#isEdited = false;
    this.#quantity = quantity;
    this.#value = value;
    this.#range = range;
    if (!this.#isEdited) this.#restore();
  }

  #restore() {
    this.#isEdited = false;
    const text = plain(this.#value * display(this.#quantity).factor, DIGITS);
    if (this.node.value !== text) this.node.value = text;
  }

  #take() {
    const text = this.node.value;
    this.#isEdited = false;
    if (text.trim() !== "") {
      const { value, sentence } = parsed(text, this.#quantity, display(this.#quantity).si);
      const refused = sentence ?? this.#accept(value);
      this.#refuse(refused ?? null);
    }
    this.#restore();
  }

  #key(event) {
    const count = COUNTS[event.key];
    if (event.key === "Escape" && this.#isEdited) {
      this.#restore();
      event.stopPropagation();
    } else if (count !== undefined && !event.ctrlKey && !event.altKey && !event.metaKey) {
      event.preventDefault();
      if (this.#isEdited) this.#take();
      const { factor, si } = display(this.#quantity);
      const step = roundStep(this.#range * factor, STEPS);
      const refused = this.#accept(stepped(this.#value * factor, step, count) * si);
      this.#refuse(refused ?? null);
    }
  }
}
