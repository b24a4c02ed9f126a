/** What stands around the diagram: its controls, pinned curves, special points, checks. */

import { MARKERS, branchesOf, distinct, fillOf, placeOfSpecial } from "./diagram_data.js";
import { Choice, button, closeButton, element, roving, svg } from "./dom.js";
import { QuantityBox } from "./parameters.js";
import { asSentence, display, withUnit } from "./quantities.js";
import {
  STATISTICS, diagramRequest, initialView, inside, spanOf, systemOf, withParameter, withPin, withPinName, withStart,
  withVaried, withoutPin,
} from "./view.js";

export class CheckedLine {
  /** The element to put on the page. */
  node = element("p", { class: "checked" });

  /** @param {{sentence: string, agree: boolean}|null} [checked] the server's */
  show(checked = null) {
    this.node.textContent = asSentence(checked?.sentence ?? "");
    this.node.title = this.node.textContent;
    this.node.classList.toggle("disagrees", checked?.agree === false);
  }
}

export class DiagramControls {
  /** The element to put on the page. */
  node;
  #session;
  #vary;
  #statistic;
  #show;
  #from = this.#bound(0, "from");
  #to = this.#bound(1, "to");
  #unit = element("span", { class: "unit" });
  #whole = button("Whole diagram", () => this.#commit({ zoom: null }), { class: "small-button whole absent" });

  constructor(session) {
    this.#session = session;
    this.#vary = new Choice("Vary", (name) => this.#varied(name));
    this.#statistic = new Choice("Draw", (statistic) => this.#commit({ statistic, at: null, zoom: null }));
    this.#show = new Choice("of", (show) => this.#commit({ show, at: null, zoom: null }));
    this.node = element("div", { class: "sentence" },
      this.#vary.node, this.#from.node, element("span", {}, "to"), this.#to.node,
      this.#unit, element("span", { class: "axis-choice" }, this.#statistic.node, this.#show.node), this.#whole);
    session.store.changed.subscribe(() => this.#refresh());
    this.#refresh();
  }

  #refresh() {
    const { model, view } = this.#session;
    this.#vary.show(model.parameters.map(option), view.vary);
    this.#show.show([...model.states, ...model.outputs].map(option), view.show);
    this.#statistic.show(
      Object.entries(STATISTICS).map(([value, text]) => ({ value, text })), view.statistic);
    const varied = this.#session.quantity(view.vary);
    const range = view.span[1] - view.span[0];
    this.#from.show(varied, view.span[0], range);
    this.#to.show(varied, view.span[1], range);
    this.#unit.textContent = display(varied).unit;
    this.#whole.classList.toggle("absent", view.zoom === null);
  }

  #bound(index, word) {
    return new QuantityBox({ class: "bound", "aria-label": `Vary ${word}` }, (value) => this.#bounded(index, value));
  }

  #bounded(index, end) {
    const { view } = this.#session;
    const span = [...view.span];
    span[index] = end;
    if (span[0] === span[1]) return `the span of ${view.vary} would be empty; give two different values`;
    const value = inside(view.parameters[view.vary], span);
    this.#commit({ span, zoom: null, parameters: { ...view.parameters, [view.vary]: value } });
  }

  #varied(name) {
    const { model, view, store, place } = this.#session;
    const span = spanOf(model, name);
    const value = inside(view.parameters[name], span);
    // The first branch is that of the response along any parameter.
    const isOwn = !place || place.branch === 1 || value !== view.parameters[name];
    const start = isOwn ? null : this.#session.startOfOrbit(value);
    const next = withVaried(view, name, span, start, place?.y);
    store.commit({ ...next, parameters: { ...view.parameters, [name]: value } });
  }

  #commit(changes) {
    this.#session.store.commit({ ...this.#session.view, ...changes });
  }
}

function option(quantity) {
  return { value: quantity.name, text: quantity.label ?? quantity.name, title: quantity.doc };
}

const MOST = 12;

export class Pins {
  /** The button to put on the page. */
  node = button("Pin this curve", () => this.pin(), { class: "small-button" });
  /** What each curve is. */
  legend = element("ul", { class: "pins", "aria-label": "Curves" });
  #session;

  constructor(session) {
    this.#session = session;
    session.store.changed.subscribe(({ view, before }) => {
      this.node.disabled = view.pins.length >= MOST;
      if (view.pins !== before.pins) this.#show(view.pins);
    });
    this.#show(session.view.pins);
  }

  /** Keep the live curve for comparison. */
  pin() {
    const { store, view } = this.#session;
    store.commit(withPin(view, this.#nameOf(view)));
  }

  /** A curve's name: how it differs from the model's own values. */
  #nameOf(view) {
    const usual = initialView(this.#session.model).parameters;
    const differing = this.#session.model.parameters.filter(({ name }) =>
      name !== view.vary && view.parameters[name] !== usual[name]);
    if (differing.length === 0) return "base case";
    return differing.map((parameter) =>
      `${parameter.label ?? parameter.name} = ${withUnit(parameter, view.parameters[parameter.name])}`).join(", ");
  }

  #show(pins) {
    const items = pins.map((pin, i) => element("li", { class: `pin pin-${(i % 6) + 1}` },
      element("span", { class: "swatch", "aria-hidden": "true" }), this.#name(pin),
      closeButton(`Remove ${pin.name}`, () => this.#session.store.commit(withoutPin(this.#session.view, pin.id)))));
    const live = element("li", { class: "pin live" },
      element("span", { class: "swatch", "aria-hidden": "true" }), "current");
    this.legend.replaceChildren(...(pins.length ? [live, ...items] : []));
  }

  #name(pin) {
    const input = element("input", {
      type: "text", value: pin.name, maxlength: "60", "aria-label": "Name of the pinned curve",
      on: {
        change: () => this.#session.store.commit(withPinName(this.#session.view, pin.id, input.value)),
      },
    });
    input.size = Math.max(pin.name.length, 6);
    return input;
  }
}

/** Ends of branches that need no word: the end of the span, and where another branch is met. */
const EXPECTED = new Set(["span", "closed", "bifurcation"]);

/** Share of the span by which a motion starts beyond the end of a branch. */
const BEYOND = 0.02;

/** Markers by plotly's names, about the origin. */
export const SHAPES = {
  circle: "M4 0A4 4 0 1 1-4 0A4 4 0 1 1 4 0Z",
  square: "M-3.6-3.6H3.6V3.6H-3.6Z",
  "triangle-up": "M0-4.4L4.4 3.6H-4.4Z",
  "triangle-down": "M0 4.4L4.4-3.6H-4.4Z",
  "triangle-left": "M-4.4 0L3.6-4.4V4.4Z",
  "triangle-right": "M4.4 0L-3.6-4.4V4.4Z",
  cross: "M-1.4-4H1.4V-1.4H4V1.4H1.4V4H-1.4V1.4H-4V-1.4H-1.4Z",
  diamond: "M0-4.8L4.8 0L0 4.8L-4.8 0Z",
  pentagon: "M0-4.6L4.4-1.4L2.7 3.7H-2.7L-4.4-1.4Z",
  "x-thin": "M-4-4L4 4M-4 4L4-4",
};

export class SpecialPoints {
  /** The element to put on the page. */
  node = element("div", { class: "specials" });
  #list = roving(element("ul", { "aria-label": "Special points of the diagram" }));
  #ends = element("p", { class: "ends" });
  #checked = new CheckedLine();
  #session;
  #key = "";

  constructor(session) {
    this.#session = session;
    this.node.append(this.#list, this.#ends, this.#checked.node);
    session.diagramArrived.subscribe(({ answer }) => this.#show(answer));
    // Special points of another model are not shown beside the name of this one.
    session.store.changed.subscribe(({ view, before }) => this.node.classList.toggle(
      "absent", (view.model !== before.model || this.node.classList.contains("absent")) && !session.diagram));
    for (const signal of [session.diagramArrived, session.failed]) {
      signal.subscribe(() => this.node.classList.toggle("refused", session.hasFailed));
    }
  }

  #show(diagram) {
    this.node.classList.remove("absent");
    const branches = branchesOf(diagram);
    const items = distinct(branches.flatMap((branch) =>
      branch.special.map((special) => ({ branch, special, text: textOf(special, diagram.x), x: special.value, y: special.y }))));
    const ends = branches.filter(({ stopped }) => !EXPECTED.has(stopped.kind));
    const named = (kind, period) => {
      if (this.#session.model.forced) return `Period ${period}`;
      return kind === "equilibrium" ? "The equilibrium" : "The cycle";
    };
    const sentences = ends.map(({ kind, period, stopped }) =>
      `${named(kind, period)} ends at ${withUnit(diagram.x, stopped.value)}: ${stopped.reason}.`);
    const key = JSON.stringify([items.map(({ text }) => text), sentences]);
    const failed = diagram.unfollowed.map((why) => `No branch was followed from a motion: ${why}.`);
    this.#ends.replaceChildren(...this.#ways(diagram, ends), [...new Set([...sentences, ...failed])].join(" "));
    this.#ends.title = this.#ends.textContent;
    this.#checked.show(diagram.checked);
    this.#items = items;
    if (key === this.#key) return;
    this.#key = key;
    this.#list.replaceChildren(...items.map((item, i) => this.#button(item, i)));
    this.#list.hidden = items.length === 0;
  }

  /** Buttons that follow what motions settle on beyond ends of branches, each place once. */
  #ways({ x, branches }, ends) {
    const [low, high] = [Math.min(...this.#session.view.span), Math.max(...this.#session.view.span)];
    const starts = ends.filter(({ stopped }) => stopped.beyond).map(({ stopped: { value, beyond } }) => ({
      value: Number((value + beyond.direction * BEYOND * (high - low)).toPrecision(6)), state: beyond.state,
    }));
    const isBare = ({ value }) => value > low && value < high && !branches.some((branch) =>
      value >= Math.min(...branch.x) && value <= Math.max(...branch.x));
    return starts.filter(isBare).map((start) => button(
      `Follow what motions settle on at ${withUnit(x, start.value)}`,
      () => this.#session.store.commit(withStart(this.#session.view, start)),
      { class: "small-button", title: "Integrates a motion there until it is steady, and follows its branch" }));
  }

  #items = [];

  #button({ special, text }, i) {
    const go = () => {
      const item = this.#items[i];
      this.#session.choose(placeOfSpecial(item.branch, item.special));
    };
    return element("li", {},
      element("button", { type: "button", class: "chip", title: special.sentence, on: { click: go } },
        glyph(special), text));
  }
}

export class Elsewhere {
  /** The element to put on the page. */
  node = element("div", { class: "sentence", role: "status", hidden: true });
  #session;
  #asked = null; // the system of the last search

  /**
   * If the first diagram of a forced system has no bifurcation, look for a parameter over which there is one; if
   * there is no diagram, as where a contact sticks for good, for one over which there is a response.
   */
  constructor(session) {
    this.#session = session;
    session.diagramArrived.subscribe(({ answer }) => answer.done && this.#consider(answer));
    session.failed.subscribe(({ kind, sentence }) => kind === "diagram" && sentence && this.#consider({ branches: [] }));
    session.store.changed.subscribe(({ view, before }) => systemOf(view) !== systemOf(before) && this.#drop());
  }

  #consider({ branches }) {
    const { model, view, requests, store } = this.#session;
    const isQuiet = branches.every(({ special }) => special.length === 0);
    if (!model.forced || !isQuiet || store.isLive || this.#asked === systemOf(view)) return;
    this.#asked = systemOf(view);
    const { also: _, span: __, show: ___, statistic: ____, ...request } = diagramRequest(view);
    requests.ask({ ...request, kind: "screen" }, { onAnswer: (answer) => this.#offer(answer), onError: () => {} });
  }

  #offer({ vary, span, type, value }) {
    if (!vary || !(type || this.#session.hasFailed)) return;
    const quantity = this.#session.quantity(vary);
    const near = Number(value.toPrecision(4));
    const show = () => {
      const { view, store } = this.#session;
      store.commit(withVaried(type ? view : withParameter(view, vary, near), vary, span));
    };
    const at = `at ${withUnit(quantity, near)}`;
    const found = type ? `the response has a bifurcation (${type} ${at})` : `there is a response, as ${at}`;
    this.node.hidden = false;
    this.node.replaceChildren(
      element("span", {}, `Over ${quantity.label ?? vary} ${found}.`),
      element("button", { type: "button", class: "small-button", on: { click: show } }, "Show"));
  }

  #drop() {
    this.#asked = null;
    this.#session.requests.cancel("screen");
    this.node.hidden = true;
    this.node.replaceChildren();
  }
}

/** The marker of a special point, as in the diagram. */
function glyph(special) {
  return svg("svg", { viewBox: "-6 -6 12 12", class: `glyph ${fillOf(special)}`, "aria-hidden": "true" },
    svg("path", { d: SHAPES[MARKERS[special.type]] ?? SHAPES.circle }));
}

function textOf(special, x) {
  const parts = [special.type, withUnit(x, special.value), special.criticality];
  return parts.filter(Boolean).join(" ");
}
