/** Text to read and to copy. */

import { element } from "./dom.js";
import { copy } from "./files.js";

export class TextDialog {
  /** The element to put on the page. */
  node;
  #heading = element("h2", { id: "text-dialog-title" });
  #text = element("pre", { tabindex: "0" });
  #state = element("span", { role: "status" });

  constructor() {
    const copyAgain = async () => this.#told(await copy(this.#text.textContent));
    const actions = element("div", { class: "actions" }, this.#state,
      element("button", { type: "button", on: { click: copyAgain } }, "Copy"),
      element("button", { type: "button", on: { click: () => this.node.close() } }, "Close"));
    this.node = element("dialog", { class: "text-dialog", "aria-labelledby": "text-dialog-title" },
      this.#heading, this.#text, actions);
  }

  /**
   * @param {string} title
   * @param {string} text
   * @param {boolean} isCopied whether it is on the clipboard already
   */
  show(title, text, isCopied) {
    this.#heading.textContent = title;
    this.#text.textContent = text;
    this.#told(isCopied);
    this.node.showModal();
  }

  #told(isCopied) {
    this.#state.textContent = isCopied ? "Copied." : "Select the text to copy it.";
  }
}
