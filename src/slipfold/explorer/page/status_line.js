/** The connection, in a word; and sentences that need to be read, until they no longer hold. */

import { element } from "./dom.js";

const WORDS = { connecting: "connecting", open: "connected", lost: "reconnecting", refused: "not let in" };
const SHOWN = 4000;

export class StatusLine {
  /** The element for the header. */
  node = element("span", { class: "connection", "data-state": "connecting", role: "status" }, "connecting");
  /** The element for sentences. */
  notices = element("div", { class: "notices" });
  #failures = new Map();
  #timer = 0;
  #passing = element("p", { class: "notice", role: "status", hidden: true });

  /** @param {import("./session.js").Session} session */
  constructor(session) {
    this.notices.append(this.#passing);
    session.connection.changed.subscribe(({ state, sentence }) => {
      this.node.dataset.state = state;
      this.node.textContent = WORDS[state];
      this.#fail("connection", state === "open" || state === "connecting" ? null : `${sentence}.`);
    });
    session.failed.subscribe(({ kind, sentence }) => this.#fail(kind, sentence));
  }

  /** Show a sentence for a while. */
  say(sentence) {
    clearTimeout(this.#timer);
    this.#passing.textContent = sentence;
    this.#passing.hidden = false;
    this.#timer = setTimeout(() => { this.#passing.hidden = true; }, SHOWN);
  }

  #fail(kind, sentence) {
    this.#failures.get(kind)?.remove();
    this.#failures.delete(kind);
    if (!sentence) return;
    const node = element("p", { class: "notice failure", role: "alert", "data-kind": kind }, sentence);
    this.#failures.set(kind, node);
    this.notices.append(node);
  }
}
