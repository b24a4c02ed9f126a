/** Which starts come to which motion: over which states, how far, and what was found. */

import { BasinsPlot, keysOf } from "./basins_plot.js";
import { Choice } from "../controls/choice.js";
import { element } from "../controls/dom.js";
import { axisTitle } from "../parameters/quantities.js";
import { basinsRequest } from "../session/view.js";

/** How far starts lie from zero, in sizes of the orbit that is shown. */
const REACHES = ["1", "2", "4", "8"];

export class BasinsPanel {
  /** The element to put on the page. */
  node;
  #session;
  #choices;
  #reach = new Choice("within", (reach) => this.#turn({ reach }));
  #words = element("p", { class: "basins-words", role: "status" });
  #legend = element("ul", { class: "basins-legend" });
  #stop;
  #plot;
  #picked;
  #sizes = {};

  /**
   * @param {import("../session/session.js").Session} session
   * @param {import("../orbit/simulation.js").Simulation} simulation
   */
  constructor(session, simulation) {
    this.#session = session;
    const button = (text, click, kind = "") =>
      element("button", { type: "button", class: kind, on: { click } }, text);
    this.#stop = button("Stop computing", () => this.#halt(), "quiet");
    this.#choices = ["x", "y"].map((axis, i) =>
      new Choice(["over", "and"][i], (name) => this.#turn({ [axis]: name })));
    this.#plot = new BasinsPlot((x, y) =>
      simulation.fromStates({ [this.#picked.x]: x, [this.#picked.y]: y }));
    this.node = element("div", { class: "basins" },
      element("div", { class: "sentence" }, button("Compute the basins", () => this.#ask()),
        ...this.#choices.map(({ node }) => node), this.#reach.node, element("span", {}, "of the orbit"), this.#stop),
      this.#words, this.#plot.node, this.#legend);
    session.store.changed.subscribe(({ view, before }) => {
      if (view.model !== before.model) this.#begin();
      if (systemOf(view) !== systemOf(before)) this.#clear();
    });
    session.orbitArrived.subscribe((arrived) => arrived && this.#measure(arrived.answer));
    session.failed.subscribe(({ kind, sentence }) => kind === "basins" && sentence && this.#clear(sentence));
    this.#begin();
    this.#clear();
  }

  #begin() {
    const [first, second = first] = this.#session.model.states.map(({ name }) => name);
    this.#picked = { x: first, y: second, reach: "4" };
    this.#sizes = {};
    this.#show();
  }

  #turn(changes) {
    const { x, y } = this.#picked;
    const next = { ...this.#picked, ...changes };
    if (next.x === next.y) Object.assign(next, { x: y, y: x });
    this.#picked = next;
    this.#show();
    this.#clear();
  }

  #show() {
    const options = this.#session.model.states.map((item) =>
      ({ value: item.name, text: axisTitle(item), title: item.doc }));
    this.#choices.forEach((choice, i) => choice.show(options, [this.#picked.x, this.#picked.y][i]));
    this.#reach.show(REACHES.map((value) => ({ value, text: `${value} ×` })), this.#picked.reach);
    // There is a plane where there are two states.
    this.node.classList.toggle("absent", options.length < 2);
  }

  #measure({ states }) {
    this.#sizes = Object.fromEntries(
      Object.entries(states).map(([name, values]) => [name, Math.max(...values.map(Math.abs))]));
  }

  #ask() {
    const { requests, failed, view } = this.#session;
    const axis = (name) => {
      const end = Number((Number(this.#picked.reach) * (this.#sizes[name] || 1)).toPrecision(2));
      return { name, span: [-end, end] };
    };
    const request = basinsRequest(view, axis(this.#picked.x), axis(this.#picked.y));
    const onError = (sentence, again) => failed.announce(
      { kind: "basins", sentence, again: again ? () => this.#ask() : null });
    this.#clear();
    this.#working("Computing the basins…");
    requests.ask(request, { onAnswer: (answer) => this.#take(answer), onError }, { supersede: true });
  }

  #take({ far, done, ...picture }) {
    if (far) {
      this.#working(`${far[0]} of ${far[1]} starts have come to something…`);
      return;
    }
    this.#plot.show(picture);
    this.#legend.replaceChildren(...keysOf(picture).filter(({ isSeen }) => isSeen).map(({ name, tint }) =>
      element("li", {}, element("span", { class: "shade", style: `background: var(--${tint})` }), name)));
    const size = picture.x.values.length;
    const others = this.#session.model.states.length > 2 ? ", all other states as at the model's start" : "";
    if (done) this.#rest(`From ${size} × ${size} starts${others}. Click one to let it go.`);
    else this.#working(`From ${size} × ${size} starts; computing more…`);
  }

  #halt() {
    this.#session.requests.cancel("basins");
    this.#rest("Stopped.");
  }

  #clear(failure = null) {
    this.#session.requests.cancel("basins");
    if (!failure) this.#session.failed.announce({ kind: "basins", sentence: null });
    this.#plot.show(null);
    this.#legend.replaceChildren();
    this.#rest("");
  }

  #working(text) {
    this.#words.textContent = text;
    this.#stop.hidden = false;
  }

  #rest(text) {
    this.#words.textContent = text;
    this.#stop.hidden = true;
  }
}

/** What motions depend on. */
function systemOf({ model, parameters }) {
  return JSON.stringify([model, parameters]);
}
