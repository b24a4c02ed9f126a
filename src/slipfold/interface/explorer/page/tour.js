/** The tour of the page, step by step. */

import { button, element } from "./dom.js";
import { withUnit } from "./quantities.js";
import { initialView } from "./view.js";

/**
 * @typedef {object} Step
 * @property {string} title
 * @property {(session: Session) => string} text
 * @property {string} at selector of what it is about
 * @property {(model: object) => View} [view] what to show
 * @property {(parts: object) => void} [act] what to do besides
 */

/** @type {Step[]} */
const STEPS = [
  {
    title: "A tip on a moving plate",
    at: "#diagram",
    text: () =>
      "A structure is pressed on a plate that slides under it. The pressing force pulses at 12.5 Hz; the diagram shows how far the tip moves sideways as the pulsation Nd grows. This is Fig. 2 of the paper, computed just now. Solid lines are stable responses, broken ones are not.",
    view: (model) => shown(model, {}, 0.02),
  },
  {
    title: "The threshold",
    at: "#diagram",
    text: (session) =>
      `${found(session, "PD", 1)} the response loses its stability by period doubling (PD). Below, the tip moves at the forcing frequency alone; beyond, at half of it too: the 2:1 internal resonance feeds the horizontal mode. See it in the mechanism and in the spectrum.`,
    view: (model) => shown(model, {}, 0.05, 2),
  },
  {
    title: "The Neimark–Sacker bifurcation",
    at: "#diagram",
    text: (session) =>
      `The doubled response loses its stability, too. ${found(session, "NS", 2)} a pair of multipliers leaves the unit circle (NS): the motion gets a second frequency. ${last(session, "NS", 2)} it is stable again.`,
    view: (model) => shown(model, {}, 0.11, 2),
  },
  {
    title: "A simulation",
    at: "#simulation",
    text: () =>
      "Between the two NS no periodic response is stable. A simulation from rest shows what happens instead: each dot is one forcing period. It does not settle on the dotted line.",
    view: (model) => shown(model, {}, 0.11, 2),
    act: ({ simulation }) => simulation.fromRest(),
  },
  {
    title: "Criticality",
    at: "#diagram",
    text: (session) =>
      `At 12.2 Hz the same threshold is subcritical (open marker). ${found(session, "PD", 1)} the tip jumps to a large motion. Coming down it stays there until the fold (LP). ${found(session, "LP", 2)} the fold lies far below the threshold: two responses are stable in between.`,
    view: (model) => shown(model, { f: 12.2 }, 0.1, 2, [pin(1, "f = 12.5 Hz", model, {})]),
  },
  {
    title: "Speed of the plate",
    at: "#parameters",
    text: ({ view }) =>
      `A faster plate damps less, so the threshold comes down as Vd grows; a slow plate removes the NS. Pinned beside the current curve are ${view.pins.map(({ name }) => name).join(", ")}. Move the slider of Vd yourself: everything follows.`,
    view: (model) => shown(model, {}, 0.05, 2,
      [0.4, 0.8, 1].map((Vd, i) => pin(i + 1, `Vd = ${Vd} m/s`, model, { Vd }))),
  },
  {
    title: "Direction of the plate",
    at: "#parameters",
    text: () =>
      "The direction α of the sliding decides how much of the friction acts along which mode. At 30° the threshold lies far higher than at 75°.",
    view: (model) => shown(model, {}, 0.05, 2,
      [30, 45, 75].map((degrees, i) => pin(i + 1, `α = ${degrees}°`, model, { alpha: (degrees * Math.PI) / 180 }))),
  },
  {
    title: "All at once",
    at: "#plane",
    text: () =>
      "The plane shows where in two parameters each of these points lies, and which response is stable between them. Drag the ring: the diagram and the orbit follow.",
    view: (model) => shown(model, {}, 0.11, 2),
  },
  {
    title: "Copy and save",
    at: ".masthead",
    text: () =>
      "The menu of each panel copies what it shows as Python or TOML, and saves it as CSV, netCDF or a picture. The address of this page reproduces the view. Everything can be undone.",
  },
];

/** Beyond what any response reaches: of several on a branch the largest is meant. */
const LARGEST = 10;

/** A view of the paper's base case. */
function shown(model, values, Nd, branch = null, pins = []) {
  const usual = initialView(model);
  const parameters = { ...usual.parameters, ...values, Nd };
  return { ...usual, parameters, pins, at: branch && { branch, y: LARGEST } };
}

function pin(id, name, model, values) {
  return { id, name, parameters: { ...initialView(model).parameters, ...values } };
}

function points({ diagram }, type, period) {
  return (diagram?.branches ?? [])
    .filter((branch) => branch.period === period)
    .flatMap((branch) => branch.special)
    .filter((point) => point.type === type);
}

function found(session, type, period) {
  return sentence(session, points(session, type, period)[0]);
}

function last(session, type, period) {
  return sentence(session, points(session, type, period).at(-1));
}

function sentence({ diagram }, point) {
  return point ? `At ${diagram.x.label} = ${withUnit(diagram.x, point.value)}` : "Somewhere";
}

const SEEN = "slipfold-tour-seen";

/** Name of the model that the tour shows. */
export const TOUR_MODEL = "sliding";

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
  #before = null;
  #title = element("h2", { id: "tour-title", tabindex: "-1" });
  #text = element("p", {});
  #count = element("span", { class: "count" });
  #back;
  #next;

  /** @param {{simulation: Simulation}} parts of the page that steps act on */
  constructor(session, parts) {
    this.#session = session;
    this.#parts = parts;
    this.#back = button("Back", () => this.#go(this.#step - 1));
    this.#next = button("Next", () => this.#go(this.#step + 1), { class: "main" });
    this.node = element("section", {
      class: "tour", role: "dialog", "aria-labelledby": "tour-title", hidden: true,
    }, this.#title, this.#text,
    element("div", { class: "actions" }, this.#count,
      button("Skip the tour", () => this.end(), { class: "quiet" }), this.#back, this.#next));
    this.node.addEventListener("keydown", (event) => event.key === "Escape" && this.end());
    session.diagramArrived.subscribe(() => this.#showText());
    // An undo that comes back to what the reader had before has left the tour.
    session.store.changed.subscribe(({ view }) => this.#step >= 0 && view === this.#before && this.end());
  }

  /**
   * Begin, from the first step. What the reader had before can be had again by an undo, which
   * ends the tour.
   */
  start() {
    this.node.hidden = false;
    this.#before = this.#session.store.mark();
    this.#go(0);
    this.#title.focus({ preventScroll: true });
  }

  /** End, at the last step or before. */
  end() {
    localStorage.setItem(SEEN, "yes");
    this.node.hidden = true;
    this.#step = -1;
    this.#highlight(null);
  }

  #go(step) {
    if (step >= STEPS.length) {
      this.end();
      return;
    }
    const model = this.#session.models.find(({ name }) => name === TOUR_MODEL);
    const { title, at, view, act } = STEPS[step];
    this.#step = step;
    this.#title.textContent = title;
    this.#count.textContent = `${step + 1} of ${STEPS.length}`;
    this.#back.disabled = step === 0;
    this.#next.textContent = step + 1 === STEPS.length ? "Done" : "Next";
    if (this.#parts.simulation.state.ends.length > 0) this.#parts.simulation.clear();
    // The steps are the tour's, not the reader's: there is nothing to undo between them.
    const { view: before } = this.#session;
    const plane = (before.model === TOUR_MODEL ? before.plane : null) ?? model.plane;
    if (view) this.#session.store.amend({ ...view(model), plane });
    act?.(this.#parts);
    this.#showText();
    this.#highlight(document.querySelector(at));
  }

  #showText() {
    if (this.#step >= 0) this.#text.textContent = STEPS[this.#step].text(this.#session);
  }

  #highlight(target) {
    document.querySelectorAll(".highlighted").forEach((node) => node.classList.remove("highlighted"));
    target?.classList.add("highlighted");
    target?.scrollIntoView({ block: "nearest" });
  }
}
