/** The view and its history; signals that announce changes. */

export class Signal {
  #listeners = new Set();

  /**
   * Hear of every announcement from now on.
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

const LONGEST = 200;

export class Store {
  /** Announces `{view, before, live}`; live while a slider moves. */
  changed = new Signal();
  /** Whether a slider is moving. */
  isLive = false;
  #past = [];
  #future = [];
  #committed;
  #refused = null;

  constructor(view) {
    this.view = view;
    this.#committed = view;
  }

  get canUndo() {
    return this.#past.length > 0;
  }

  get canRedo() {
    return this.#future.length > 0;
  }

  /** Show a view that will change again at once: a slider moves. */
  preview(view) {
    this.#show(view, true);
  }

  /** Show a view and remember the one before, to undo. */
  commit(view = this.view) {
    if (JSON.stringify(view) !== JSON.stringify(this.#committed)) {
      this.#remember();
      this.#committed = view;
    }
    this.#show(view, false);
  }

  /**
   * Remember the view that is shown, to come back to it whatever is amended.
   * @returns {object} the view that an undo will show
   */
  mark() {
    this.#remember();
    return this.#committed;
  }

  /** Add what the page found out by itself; that is nothing to undo. */
  amend(changes) {
    this.#committed = { ...this.#committed, ...changes };
    this.#show({ ...this.view, ...changes }, false);
  }

  /** Forget the view that was committed last once another one is: its values cannot be had. */
  refuse() {
    this.#refused = this.#committed;
  }

  /** Go one step back. */
  undo() {
    this.#travel(this.#past, this.#future);
  }

  /** Take back an undo. */
  redo() {
    this.#travel(this.#future, this.#past);
  }

  #remember() {
    if (this.#committed !== this.#refused) this.#past.push(this.#committed);
    if (this.#past.length > LONGEST) this.#past.shift();
    this.#future = [];
  }

  #travel(from, to) {
    if (from.length === 0) return;
    if (this.#committed !== this.#refused) to.push(this.#committed);
    this.#committed = from.pop();
    this.#show(this.#committed, false);
  }

  #show(view, live) {
    const before = this.view;
    this.view = view;
    this.isLive = live;
    this.changed.announce({ view, before, live });
  }
}
