/** A value that others hear of when it is announced. One instance for each thing that can happen. */
export class Signal {
  #listeners = new Set();

  /**
   * Hear of every announcement from now on.
   * @param {(value: any) => void} listener
   * @returns {() => void} stops listening
   */
  subscribe(listener) {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }

  /** @param {any} [value] what the listeners are given */
  announce(value) {
    for (const listener of [...this.#listeners]) listener(value);
  }
}
