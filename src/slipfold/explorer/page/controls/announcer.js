/** Says in one sentence what has changed, for those who hear the page; never while a slider moves. */

import { element } from "./dom.js";
import { withUnit } from "../parameters/quantities.js";

const QUIET = 700;

export class Announcer {
  /** The element to put on the page. */
  node = element("p", { class: "unseen", "aria-live": "polite", id: "announcement" });
  #timer = 0;

  /** @param {import("../session/session.js").Session} session */
  constructor(session) {
    session.diagramArrived.subscribe(({ answer }) => {
      if (!session.store.isLive && !answer.draft) this.say(summary(answer));
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
 * @returns {string}
 */
export function summary(diagram) {
  const count = diagram.branches.length;
  const branches = `${count} ${count === 1 ? "branch" : "branches"} of ${diagram.y.label} over ${diagram.x.label}`;
  const points = diagram.branches.flatMap(({ special }) => special);
  if (points.length === 0) return `${branches}; no bifurcation.`;
  const named = points.map(({ type, value, criticality }) =>
    [type, "at", withUnit(diagram.x, value), criticality].filter(Boolean).join(" "));
  return `${branches}; ${named.join(", ")}.`;
}
