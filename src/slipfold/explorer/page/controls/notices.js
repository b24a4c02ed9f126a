/** Sentences that need to be read: until they no longer hold, or are put away. */

import { element, icon } from "./dom.js";

const CROSS = "M4 4l8 8M12 4l-8 8";
const SHOWN = 4000;

export class Notices {
  /** The element to put on the page. */
  node = element("div", { class: "notices" });
  #failures = new Map();
  #timer = 0;
  #passing = element("p", { class: "notice", role: "status", hidden: true });

  constructor() {
    this.node.append(this.#passing);
  }

  /** Show a sentence for a while. */
  say(sentence) {
    clearTimeout(this.#timer);
    this.#passing.textContent = sentence;
    this.#passing.hidden = false;
    this.#timer = setTimeout(() => { this.#passing.hidden = true; }, SHOWN);
  }

  /**
   * Show why something failed; what fails for the same reason is one sentence.
   * @param {string} kind of what failed
   * @param {string|null} sentence null when all is well again
   * @param {(() => void)|null} [again] asks once more
   */
  fail(kind, sentence, again = null) {
    const before = this.#failures.get(kind);
    if (before?.sentence === sentence && !again === !before.again) return;
    this.#failures.delete(kind);
    if (sentence) this.#failures.set(kind, { sentence, again });
    this.#show();
  }

  #show() {
    const sentences = new Set([...this.#failures.values()].map(({ sentence }) => sentence));
    const shown = new Map([...this.node.querySelectorAll(".failure")].map((node) => [node.dataset.sentence, node]));
    for (const [sentence, node] of shown) {
      if (!sentences.has(sentence) || this.#canAsk(sentence) !== Boolean(node.querySelector(".again"))) node.remove();
    }
    for (const sentence of sentences) {
      if (!shown.get(sentence)?.isConnected) this.node.append(this.#notice(sentence));
    }
  }

  #canAsk(sentence) {
    return this.#of(sentence).some(([, { again }]) => again);
  }

  #of(sentence) {
    return [...this.#failures].filter(([, failure]) => failure.sentence === sentence);
  }

  #notice(sentence) {
    const again = element("button", {
      type: "button", class: "small-button again", on: { click: () => this.#askAgain(sentence) },
    }, "Ask again");
    return element("div", { class: "notice failure", "data-sentence": sentence },
      element("p", { role: "alert" }, sentence), this.#canAsk(sentence) ? again : null,
      element("button", {
        type: "button", class: "quiet close", "aria-label": "Close this notice",
        on: { click: () => this.#close(sentence) },
      }, icon(CROSS)));
  }

  #askAgain(sentence) {
    const asked = this.#of(sentence);
    this.#close(sentence);
    for (const [, { again }] of asked) again?.();
  }

  #close(sentence) {
    for (const [kind] of this.#of(sentence)) this.#failures.delete(kind);
    this.#show();
  }
}
