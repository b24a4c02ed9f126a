/** What the page says: announcements, notices, the status line, a dialog with a text. */

import { branchesOf } from "./diagram_data.js";
import { button, closeButton, element } from "./dom.js";
import { withUnit } from "./quantities.js";
import { copy } from "./toolbar.js";

const QUIET = 700;

export class Announcer {
  /** The element to put on the page. */
  node = element("p", { class: "unseen", "aria-live": "polite", id: "announcement" });
  #timer = 0;

  constructor(session) {
    session.diagramArrived.subscribe(({ answer }) => {
      if (!session.store.isLive && !answer.moved) this.say(summary(answer));
    });
  }

  /** Say a sentence once nothing newer has come for a moment. */
  say(sentence) {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => { this.node.textContent = sentence; }, QUIET);
  }
}

/**
 * A diagram in words.
 * @param {object} diagram the server's answer
 */
export function summary(diagram) {
  const drawn = branchesOf(diagram);
  const count = drawn.length;
  const branches = `${count} ${count === 1 ? "branch" : "branches"} of ${diagram.y.label} over ${diagram.x.label}`;
  const points = drawn.flatMap(({ special }) => special);
  if (points.length === 0) return `${branches}; no bifurcation.`;
  const named = points.map(({ type, value, criticality }) =>
    [type, "at", withUnit(diagram.x, value), criticality].filter(Boolean).join(" "));
  return `${branches}; ${named.join(", ")}.`;
}

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

  /**
   * Show a sentence for a while.
   * @param {boolean} [isLasting] whether it stays until the next one; an empty one shows nothing
   */
  say(sentence, isLasting = false) {
    clearTimeout(this.#timer);
    this.#passing.textContent = sentence;
    this.#passing.hidden = !sentence;
    if (!isLasting) this.#timer = setTimeout(() => { this.#passing.hidden = true; }, SHOWN);
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
    const again = button("Ask again", () => this.#askAgain(sentence), { class: "small-button again" });
    return element("div", { class: "notice failure", "data-sentence": sentence },
      element("p", { role: "alert" }, sentence), this.#canAsk(sentence) ? again : null,
      closeButton("Close this notice", () => this.#close(sentence)));
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

const WORDS = {
  connecting: "connecting", open: "connected", lost: "reconnecting", stopped: "no server",
  refused: "not let in",
};

export class StatusLine {
  /** The element for the header. */
  node = element("span", { class: "connection", "data-state": "connecting", role: "status" }, "connecting");

  constructor(session, notices) {
    session.connection.changed.subscribe(({ state, sentence }) => {
      this.node.dataset.state = state;
      this.node.textContent = WORDS[state];
      notices.fail("connection", sentence);
    });
    session.failed.subscribe(({ kind, sentence, again }) => notices.fail(kind, sentence, again));
  }
}

export class TextDialog {
  /** The element to put on the page. */
  node;
  #heading = element("h2", { id: "text-dialog-title" });
  #text = element("pre", { tabindex: "0" });
  #state = element("span", { role: "status" });

  constructor() {
    const copyAgain = async () => this.#showState(await copy(this.#text.textContent));
    const actions = element("div", { class: "actions" }, this.#state,
      button("Copy", copyAgain), button("Close", () => this.node.close()));
    this.node = element("dialog", { class: "text-dialog", "aria-labelledby": "text-dialog-title" },
      this.#heading, this.#text, actions);
  }

  /** @param {boolean} isCopied whether it is on the clipboard already */
  show(title, text, isCopied) {
    this.#heading.textContent = title;
    this.#text.textContent = text;
    this.#showState(isCopied);
    this.node.showModal();
  }

  #showState(isCopied) {
    this.#state.textContent = isCopied ? "Copied." : "Select the text to copy it.";
  }
}
