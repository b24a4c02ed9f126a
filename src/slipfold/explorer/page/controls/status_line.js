/** The connection in a word, and what to do without one. */

import { element } from "./dom.js";

const WORDS = {
  connecting: "connecting", open: "connected", lost: "reconnecting", stopped: "no server",
  refused: "not let in",
};

export class StatusLine {
  /** The element for the header. */
  node = element("span", { class: "connection", "data-state": "connecting", role: "status" }, "connecting");

  /**
   * @param {import("../session/session.js").Session} session
   * @param {import("./notices.js").Notices} notices
   */
  constructor(session, notices) {
    session.connection.changed.subscribe(({ state, sentence }) => {
      this.node.dataset.state = state;
      this.node.textContent = WORDS[state];
      notices.fail("connection", sentence);
    });
    session.failed.subscribe(({ kind, sentence, again }) => notices.fail(kind, sentence, again));
  }
}
