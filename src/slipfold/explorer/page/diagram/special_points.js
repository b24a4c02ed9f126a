/** The special points of the diagram as a list: to read, to hear, and to go there. */

import { CheckedLine } from "./checked_line.js";
import { MARKERS } from "./diagram_traces.js";
import { element, svg } from "../controls/dom.js";
import { withUnit } from "../parameters/quantities.js";
import { placeOfSpecial } from "./working_point.js";

/** Ends of branches that need no word: the end of the span, and where another branch is met. */
const EXPECTED = new Set(["span", "closed", "born"]);

const SHAPES = {
  circle: "M4 0A4 4 0 1 1-4 0A4 4 0 1 1 4 0Z",
  square: "M-3.6-3.6H3.6V3.6H-3.6Z",
  "triangle-up": "M0-4.4L4.4 3.6H-4.4Z",
  diamond: "M0-4.8L4.8 0L0 4.8L-4.8 0Z",
  pentagon: "M0-4.6L4.4-1.4L2.7 3.7H-2.7L-4.4-1.4Z",
  "x-thin": "M-4-4L4 4M-4 4L4-4",
};

export class SpecialPoints {
  /** The element to put on the page. */
  node = element("div", { class: "specials" });
  #list = element("ul", { "aria-label": "Special points of the diagram" });
  #ends = element("p", { class: "ends" });
  #checked = new CheckedLine();
  #session;
  #key = "";

  /** @param {import("../session/session.js").Session} session */
  constructor(session) {
    this.#session = session;
    this.node.append(this.#list, this.#ends, this.#checked.node);
    session.diagramArrived.subscribe(({ answer }) => this.#show(answer));
    for (const signal of [session.diagramArrived, session.failed]) {
      signal.subscribe(() => this.node.classList.toggle("refused", session.hasFailed));
    }
  }

  #show(diagram) {
    const items = diagram.branches.flatMap((branch) =>
      branch.special.map((special) => ({ branch, special, text: textOf(special, diagram.x) })));
    const ends = diagram.branches.filter(({ stopped }) => !EXPECTED.has(stopped.kind));
    const named = (kind, period) => {
      if (this.#session.model.forced) return `Period ${period}`;
      return kind === "equilibrium" ? "The equilibrium" : "The cycle";
    };
    const sentences = ends.map(({ kind, period, stopped }) =>
      `${named(kind, period)} ends at ${withUnit(diagram.x, stopped.value)}: ${stopped.reason}.`);
    const key = JSON.stringify([items.map(({ text }) => text), sentences]);
    this.#ends.textContent = [...new Set(sentences)].join(" ");
    this.#ends.title = this.#ends.textContent;
    this.#checked.show(diagram.checked);
    this.#items = items;
    this.node.classList.toggle("draft", Boolean(diagram.draft));
    if (key === this.#key) return;
    this.#key = key;
    this.#list.replaceChildren(...items.map((item, i) => this.#button(item, i)));
    this.#list.hidden = items.length === 0;
  }

  #items = [];

  #button({ special, text }, i) {
    const go = () => {
      const item = this.#items[i];
      this.#session.choose(placeOfSpecial(item.branch, item.special));
    };
    return element("li", {},
      element("button", { type: "button", class: "chip", title: special.sentence, on: { click: go } },
        glyph(special.type, special.criticality === "subcritical"), text));
  }
}

/**
 * The marker of a special point, as in the diagram.
 * @param {string} type
 * @param {boolean} hollow
 */
export function glyph(type, hollow) {
  return svg("svg", { viewBox: "-6 -6 12 12", class: `glyph${hollow ? " hollow" : ""}`, "aria-hidden": "true" },
    svg("path", { d: SHAPES[MARKERS[type]] ?? SHAPES.circle }));
}

function textOf(special, x) {
  const parts = [special.type, withUnit(x, special.value), special.criticality];
  return parts.filter(Boolean).join(" ");
}
