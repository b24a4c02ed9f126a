/** Basins of attraction: plot and panel. */

import { escaped } from "./diagram_data.js";
import { Choice, button, element } from "./dom.js";
import { CONFIG, mapLayout, mapping, pixelOf, redrawn } from "./plot_tools.js";
import { axisTitle, display, optionOf } from "./quantities.js";
import { colors } from "./theme.js";
import { basinsRequest, solutionOf } from "./view.js";

/** Colors of attractors: the first two differ most in lightness. */
const TINTS = ["region-2", "live", ...Array.from({ length: 12 }, (_, i) => `region-other-${i + 1}`)];

/** Opacity of the color above a cell where one start does not stand for all of it. */
const VEIL = 0.4;

/** What starts came to that converged to no attractor, from the least label on. */
const NOTHING = [
  { label: -2, name: "not finished", tint: "panel" },
  { label: -1, name: "ended", tint: "axis" },
  { label: 0, name: "undecided", tint: "region-none" },
];

/**
 * Names and colors of all that starts came to, in the order of their labels.
 * @param {{labels: number[][], attractors: {name: string, fraction: number}[]}} basins
 */
function keysOf({ labels, attractors }) {
  const seen = new Set(labels.flat());
  const found = attractors.map(({ name, fraction }, i) => ({
    label: i + 1, name: `${name}, ${(100 * fraction).toPrecision(3)} %`, tint: TINTS[i % TINTS.length],
  }));
  return [...NOTHING, ...found].map((key) => ({ ...key, isSeen: key.label > 0 || seen.has(key.label) }));
}

class BasinsPlot {
  /** The element to put on the page. */
  node = element("div", { class: "plot basins-plot", hidden: true });
  #canvas = element("div", { class: "plot-canvas" });
  #basins = null;
  #map = null;
  #schedule = redrawn(this.node, () => this.#draw());

  /** @param {(x: number, y: number) => void} pick hears of a start that is clicked, in SI units */
  constructor(pick) {
    this.node.append(this.#canvas);
    this.node.addEventListener("click", (event) => {
      const at = pixelOf(event, this.node);
      if (!this.#map?.isInside(...at)) return;
      const [x, y] = this.#map.toData(...at);
      pick(x / display(this.#basins.x).factor, y / display(this.#basins.y).factor);
    });
  }

  /** Show a picture in place of the one before; null shows none. */
  show(basins) {
    this.#basins = basins;
    this.node.hidden = !basins;
    this.node.dataset.points = basins ? String(basins.x.values.length) : "";
    this.#schedule();
  }

  #draw() {
    if (!this.#basins || this.node.clientWidth === 0) return;
    const { x, y, labels } = this.#basins;
    const color = colors();
    const keys = keysOf(this.#basins);
    const [across, up] = [x, y].map((axis) => axis.values.map((value) => value * display(axis).factor));
    const size = [this.node.clientWidth, this.node.clientHeight];
    const range = { x: ends(across), y: ends(up) };
    this.#map = mapping(size, range.x, range.y);
    const sheet = mapLayout(color, { title: escaped(axisTitle(x)), range: range.x },
      { title: escaped(axisTitle(y)), range: range.y }, size);
    const colorscale = keys.flatMap(({ tint }, i) =>
      [i, i + 1].map((end) => [end / keys.length, color(tint)]));
    const trace = {
      type: "heatmap", x: across, y: up, z: labels, colorscale, showscale: false, hoverinfo: "skip",
      zmin: keys[0].label - 0.5, zmax: keys.at(-1).label + 0.5,
    };
    // Nothing is drawn where a cell is certain: null has no color.
    const veil = {
      type: "heatmap", x: across, y: up, z: this.#basins.uncertain.map((row) => row.map((value) => value || null)),
      colorscale: [[0, color("pin-3")], [1, color("pin-3")]], showscale: false, hoverinfo: "skip", opacity: VEIL,
    };
    window.Plotly.react(this.#canvas, [trace, veil], sheet, CONFIG);
  }
}

/** Where the outermost cells end. */
function ends(values) {
  const half = (values.at(-1) - values[0]) / (values.length - 1) / 2;
  return [values[0] - half, values.at(-1) + half];
}

/** How far starts lie from zero, in sizes of the orbit that is shown. */
const REACHES = ["1", "2", "4", "8"];

/** Milliseconds after which the panel says why there is no picture yet. */
const PATIENCE = 10_000;
const SLOW = " Motions that never repeat take seconds each, until their Lyapunov exponents are known. Stop, and classify one of them with \"Torus or chaos?\", or choose values at which motions repeat.";

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
  #timer = 0;
  #advice = "";
  #sizes = {};

  constructor(session, simulation) {
    this.#session = session;
    this.#stop = button("Stop computing", () => this.#halt(), { class: "quiet" });
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
      if (solutionOf(view) !== solutionOf(before)) this.#clear();
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
    const options = this.#session.model.states.map(optionOf);
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
    const { view } = this.#session;
    const axis = (name) => {
      const end = Number((Number(this.#picked.reach) * (this.#sizes[name] || 1)).toPrecision(2));
      return { name, span: [-end, end] };
    };
    const request = basinsRequest(view, axis(this.#picked.x), axis(this.#picked.y));
    this.#clear();
    this.#working("Computing the basins…");
    this.#timer = setTimeout(() => {
      const others = this.#session.requests.meanwhile("basins");
      this.#advice = others ? ` Computed meanwhile, and perhaps first: ${others}.` : SLOW;
      this.#working("Computing the basins…");
    }, PATIENCE);
    this.#session.ask(request, (answer) => this.#take(answer), () => this.#ask());
  }

  #take({ far, done, ...picture }) {
    if (far) {
      this.#working(`${far[0]} of ${far[1]} starts have settled…`);
      return;
    }
    this.#stopTimer();
    this.#plot.show(picture);
    const uncertain = picture.uncertain.flat();
    const share = uncertain.filter(Boolean).length / uncertain.length;
    const key = (background, name) => element("li", {}, element("span", { class: "shade", style: `background: ${background}` }), name);
    this.#legend.replaceChildren(
      ...keysOf(picture).filter(({ isSeen }) => isSeen).map(({ name, tint }) => key(`var(--${tint})`, name)),
      ...(share > 0 ? [key(`color-mix(in srgb, var(--pin-3) ${100 * VEIL}%, transparent)`,
        `boundary: starts within a cell differ, ${(100 * share).toPrecision(3)} % of the cells`)] : []));
    const size = picture.x.values.length;
    const others = this.#session.model.states.length > 2 ? ", all other states as at the model's start" : "";
    if (done) this.#rest(`From ${size} × ${size} starts${others}. Click one to simulate from it.`);
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
    this.#words.textContent = `${text}${this.#advice}`;
    this.#stop.hidden = false;
  }

  /** Stop the timer of the explanation: a picture is there, or none is awaited. */
  #stopTimer() {
    clearTimeout(this.#timer);
    this.#advice = "";
  }

  #rest(text) {
    this.#stopTimer();
    this.#words.textContent = text;
    this.#stop.hidden = true;
  }
}
