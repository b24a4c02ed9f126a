/** A labelled list to choose from. */

import { element } from "./dom.js";

export class Choice {
  /** The element to put on the page. */
  node;
  #select;
  #options = "";

  /**
   * @param {string} label
   * @param {(value: string) => void} chosen
   * @param {boolean} [isLabelSeen]
   */
  constructor(label, chosen, isLabelSeen = true) {
    this.#select = element("select", {
      "aria-label": label,
      on: { change: () => chosen(this.#select.value) },
    });
    this.node = element("label", { class: "choice" },
      isLabelSeen ? element("span", {}, label) : null, this.#select);
  }

  /**
   * Show what there is and what is chosen.
   * @param {{value: string, text: string, title?: string}[]} options
   * @param {string} value
   */
  show(options, value) {
    const key = JSON.stringify(options);
    if (key !== this.#options) {
      this.#options = key;
      this.#select.replaceChildren(...options.map((option) =>
        element("option", { value: option.value, title: option.title ?? null }, option.text)));
    }
    this.#select.value = value;
  }
}
