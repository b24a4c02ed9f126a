/** What the motion at the working point comes to, by its Lyapunov exponents: a torus or chaos. */

import { element } from "../controls/dom.js";
import { formatted } from "../parameters/quantities.js";
import { exponentsRequest } from "../session/view.js";

/** Errors by which an exponent differs from zero if it is said to, as the server judges it. */
const SURE = 3;

/** What rounding may leave of zero. */
const ROUNDING = 1e-9;

const NAMES = {
  equilibrium: "Equilibrium", periodic: "Periodic", torus: "Torus", chaos: "Chaos", undecided: "Undecided",
};

export class Exponents {
  /** The element to put on the page. */
  node;
  #session;
  #simulation;
  #told = element("p", { role: "status", id: "exponents" });
  #stop;
  #simulated;

  /**
   * @param {import("../session/session.js").Session} session
   * @param {import("./simulation.js").Simulation} simulation
   */
  constructor(session, simulation) {
    this.#session = session;
    this.#simulation = simulation;
    const button = (text, click, kind, title = null) =>
      element("button", { type: "button", class: kind, title, on: { click } }, text);
    this.#stop = button("Stop judging", () => this.#clear(), "quiet");
    this.#stop.hidden = true;
    this.node = element("div", { class: "exponents" },
      element("div", { class: "sentence" },
        button("Torus or chaos?", () => this.#ask(), "", "Judge this motion by its Lyapunov exponents"), this.#stop),
      this.#told);
    session.store.changed.subscribe(({ view, before }) => {
      if (systemOf(view) !== systemOf(before)) this.#clear();
    });
    simulation.changed.subscribe(() => simulation.request !== this.#simulated && this.#clear());
    session.failed.subscribe(({ kind, sentence }) => kind === "exponents" && sentence && this.#show([], false));
  }

  #ask() {
    const { requests, failed, view } = this.#session;
    this.#simulated = this.#simulation.request;
    const request = exponentsRequest(view, this.#simulation.start);
    const onAnswer = (answer) => this.#show(answer.done ? this.#verdict(answer) : this.#progress(answer), !answer.done);
    const onError = (sentence, again) => failed.announce(
      { kind: "exponents", sentence, again: again ? () => this.#ask() : null });
    failed.announce({ kind: "exponents", sentence: null });
    this.#show(["Following the motion and what disturbs it…"], true);
    requests.ask(request, { onAnswer, onError }, { supersede: true });
  }

  #clear() {
    this.#session.requests.cancel("exponents");
    this.#session.failed.announce({ kind: "exponents", sentence: null });
    this.#show([], false);
  }

  #show(parts, isRunning) {
    this.#told.replaceChildren(...parts);
    this.#stop.hidden = !isRunning;
  }

  #progress({ periods, total, exponents }) {
    const isForced = this.#session.model.forced;
    const far = isForced ? `${periods} of at most ${total} periods` : `${Math.round((100 * periods) / total)} % of the longest time`;
    const known = exponents.length ? `; exponents ${listed(exponents)} so far` : "";
    return [`After ${far}${known}…`];
  }

  #verdict({ kind_of_motion: kind, period, message, exponents, errors, per }) {
    const name = period ? `Period ${period}` : NAMES[kind];
    return [element("strong", {}, name), `: ${message}. Exponents per ${per}: ${listed(exponents, errors)}.`];
  }
}

/** Exponents in words: what is not told from zero is, and null is minus infinity. */
function listed(exponents, errors = exponents.map(() => 0)) {
  const texts = exponents.map((value, i) => {
    if (value === null) return "−∞";
    const error = errors[i] ?? 0;
    return Math.abs(value) <= SURE * error + ROUNDING ? "0" : formatted(value, digitsOf(value, error));
  });
  return texts.join(", ");
}

/** Digits that an error leaves, four at most. */
function digitsOf(value, error) {
  if (error === 0) return 4;
  return Math.min(Math.max(Math.floor(Math.log10(Math.abs(value) / error)) + 1, 1), 4);
}

/** What the motion depends on. */
function systemOf({ model, parameters }) {
  return JSON.stringify([model, parameters]);
}
