/** Which values the model cannot have, and why: asked of the server whenever one was set. */

import { Signal } from "./signal.js";

export class Refusals {
  /** Announces sentences by the parameter whose value is refused. */
  changed = new Signal();
  #session;
  #asked = "";
  #sentences = {};

  /** @param {import("./session.js").Session} session */
  constructor(session) {
    this.#session = session;
    session.store.changed.subscribe(({ live }) => live || this.ask());
  }

  /** Ask about the values of the view. */
  async ask() {
    const { model, parameters } = this.#session.view;
    const body = JSON.stringify({ model, parameters });
    if (body === this.#asked) return;
    this.#asked = body;
    try {
      const headers = { "Content-Type": "application/json" };
      const response = await fetch("/api/values", { method: "POST", headers, body });
      if (response.ok && body === this.#asked) this.#take(await response.json());
    } catch {
      this.#asked = ""; // there is no server, which is said elsewhere
    }
  }

  #take(sentences) {
    for (const name of Object.keys({ ...this.#sentences, ...sentences })) {
      this.#session.failed.announce({ kind: `value of ${name}`, sentence: sentences[name] ?? null });
    }
    this.#sentences = sentences;
    this.changed.announce(sentences);
  }
}
