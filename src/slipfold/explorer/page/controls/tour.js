/** The guided tour: a card that stays out of the way, and a frame around what it speaks of. */

import { element } from "./dom.js";
import { STEPS } from "./tour_steps.js";

const SEEN = "slipfold-tour-seen";

/** Name of the model that the tour is about. */
export const TOLD_OF = "sliding";

/** Whether this reader has not been here before. */
export function isFirstVisit() {
  return localStorage.getItem(SEEN) === null;
}

export class Tour {
  /** The element to put on the page. */
  node;
  #session;
  #parts;
  #step = -1;
  #title = element("h2", { id: "tour-title", tabindex: "-1" });
  #text = element("p", {});
  #count = element("span", { class: "count" });
  #back;
  #next;

  /**
   * @param {import("../session/session.js").Session} session
   * @param {{simulation: import("../orbit/simulation.js").Simulation}} parts of the page that steps act on
   */
  constructor(session, parts) {
    this.#session = session;
    this.#parts = parts;
    const button = (text, click, kind = "") =>
      element("button", { type: "button", class: kind, on: { click } }, text);
    this.#back = button("Back", () => this.#go(this.#step - 1));
    this.#next = button("Next", () => this.#go(this.#step + 1), "main");
    this.node = element("section", {
      class: "tour", role: "dialog", "aria-labelledby": "tour-title", hidden: true,
    }, this.#title, this.#text,
    element("div", { class: "actions" }, this.#count,
      button("Skip the tour", () => this.end(), "quiet"), this.#back, this.#next));
    this.node.addEventListener("keydown", (event) => event.key === "Escape" && this.end());
    session.diagramArrived.subscribe(() => this.#tell());
  }

  /**
   * Begin, from the first step. What the reader had before can be had again by an undo.
   * @param {{isFirst?: boolean}} [how] isFirst: there was nothing before
   */
  start({ isFirst = false } = {}) {
    this.node.hidden = false;
    if (!isFirst) this.#session.store.mark();
    this.#go(0);
    this.#title.focus({ preventScroll: true });
  }

  /** End, at the last step or before. */
  end() {
    localStorage.setItem(SEEN, "yes");
    this.node.hidden = true;
    this.#step = -1;
    this.#mark(null);
  }

  #go(step) {
    if (step >= STEPS.length) {
      this.end();
      return;
    }
    const model = this.#session.models.find(({ name }) => name === TOLD_OF);
    const { title, at, view, act } = STEPS[step];
    this.#step = step;
    this.#title.textContent = title;
    this.#count.textContent = `${step + 1} of ${STEPS.length}`;
    this.#back.disabled = step === 0;
    this.#next.textContent = step + 1 === STEPS.length ? "Done" : "Next";
    if (this.#parts.simulation.state.count > 0) this.#parts.simulation.clear();
    // The steps are the tour's, not the reader's: there is nothing to undo between them.
    if (view) this.#session.store.amend({ ...view(model), plane: this.#session.view.plane ?? model.plane });
    act?.(this.#parts);
    this.#tell();
    this.#mark(document.querySelector(at));
  }

  #tell() {
    if (this.#step >= 0) this.#text.textContent = STEPS[this.#step].text(this.#session);
  }

  #mark(target) {
    document.querySelectorAll(".told").forEach((node) => node.classList.remove("told"));
    target?.classList.add("told");
    target?.scrollIntoView({ block: "nearest" });
  }
}
