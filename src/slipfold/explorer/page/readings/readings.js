/** A measured response from a file, as the server reads it with the model's units. */

import { posted } from "../controls/files.js";
import { Signal } from "../session/signal.js";

/** Most bytes that the server takes at once. */
const MOST = 64 * 1024;

/**
 * @typedef {object} Measured readings of one quantity
 * @property {number[]} values of what was varied
 * @property {(number|null)[]} readings null where nothing was read
 * @property {(number|null)[]} errors standard deviations; null where they are not known
 * @property {("up"|"down"|"")[]} sweep how the parameter came to each value
 */

export class Readings {
  /** Announces nothing: readings have come or gone. */
  changed = new Signal();
  /** `{name, model, vary, values, sweep, quantities}`, or null. */
  file = null;
  #session;
  #asked = 0;

  /** @param {import("../session/session.js").Session} session */
  constructor(session) {
    this.#session = session;
  }

  /** Read a file in place of the one before. */
  async read(file) {
    const number = ++this.#asked;
    const { model } = this.#session.view;
    try {
      const found = await this.#sent(model, file);
      if (number !== this.#asked) return;
      this.#take({ ...found, name: file.name, model });
    } catch (error) {
      if (number === this.#asked) this.#tell(error.message);
    }
  }

  /** Forget the file. */
  remove() {
    this.#asked += 1;
    this.#take(null);
  }

  /**
   * What was measured of an output, over a parameter.
   * @param {{vary: string, show: string, statistic: string}} what
   * @returns {Measured|null} null if that was not measured, or of another model
   */
  of({ vary, show, statistic }) {
    const { file } = this;
    if (file?.model !== this.#session.view.model || file.vary !== vary) return null;
    const found = file.quantities.find((item) => item.show === show && item.statistic === statistic);
    return found ? { ...found, values: file.values, sweep: file.sweep } : null;
  }

  async #sent(model, file) {
    const body = JSON.stringify({ model, name: file.name, text: await file.text() });
    if (new Blob([body]).size > MOST) {
      throw new Error(`${file.name} is larger than ${MOST / 1024} kB; leave out lines, or draw it with slipfold plot --measured`);
    }
    return (await posted("/api/readings", body)).json();
  }

  #take(file) {
    this.file = file;
    this.#tell(null);
    this.changed.announce();
  }

  #tell(sentence) {
    this.#session.failed.announce({ kind: "readings", sentence });
  }
}
