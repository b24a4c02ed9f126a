/** What stands around the plane: regimes, legend, controls, the switch between diagram and plane. */

import { Choice, button, element, svg } from "./dom.js";
import { QuantityBox } from "./parameters.js";
import { lineStyle, nameOf, regimeKeys, regionColor } from "./plane_plot.js";
import { roundStep, snapped } from "./plot_tools.js";
import { asSentence, display, withUnit } from "./quantities.js";
import { Signal } from "./store.js";
import { colors } from "./theme.js";
import { inside, planeRequest, spanOf, withVaried } from "./view.js";

export class Regimes {
  /** The element to put on the page. */
  node;
  /** The picture that has come last, or null. */
  picture = null;
  /** Announces that the picture has changed. */
  changed = new Signal();
  #session;
  #of = "";
  #words = element("span", { role: "status" });
  #ask = button("Compute the regimes", () => this.#begin(), {
    title: "Simulate from the model's start all over the plane: periods, tori, chaos",
  });
  #stop = button("Stop simulating", () => this.#halt(), { class: "quiet", hidden: true });
  #away = button("Remove", () => this.#clear(), { class: "quiet", hidden: true, title: "Show the regions of the plane again" });

  constructor(session) {
    this.#session = session;
    this.node = element("div", { class: "sentence regimes" }, this.#ask, this.#words, this.#stop, this.#away);
    session.store.changed.subscribe(() => this.#follow());
    session.failed.subscribe(({ kind, sentence }) => kind === "regimes" && sentence && this.#clear(sentence));
    this.#follow();
  }

  #key() {
    const { view } = this.#session;
    return view.plane ? JSON.stringify(planeRequest(view)) : "";
  }

  #follow() {
    // There is a phase at which to look at motions where something forces them.
    this.node.hidden = !this.#session.model.forced;
    if (this.#of && this.#of !== this.#key()) this.#clear();
    else if (!this.#of) this.#session.failed.announce({ kind: "regimes", sentence: null });
  }

  #begin() {
    this.#clear();
    this.#of = this.#key();
    this.#showStatus("Simulating…", true);
    const request = { ...planeRequest(this.#session.view), kind: "regimes" };
    this.#session.ask(request, (answer) => this.#take(answer), () => this.#begin());
  }

  #take({ far, done, ...picture }) {
    if (far) {
      this.#showStatus(`Simulating: ${Math.floor((100 * far[0]) / far[1])} % of this picture…`, true);
      return;
    }
    this.#show(picture);
    const size = `${picture.x.values.length} × ${picture.y.values.length} motions from the model's start`;
    this.#showStatus(done ? `${size}.` : `${size}; simulating more…`, !done);
  }

  #halt() {
    this.#session.requests.cancel("regimes");
    this.#showStatus("Stopped.", false);
  }

  #clear(failure = null) {
    this.#session.requests.cancel("regimes");
    if (!failure) this.#session.failed.announce({ kind: "regimes", sentence: null });
    this.#of = "";
    this.#show(null);
    this.#showStatus("", false);
  }

  #show(picture) {
    if (picture === this.picture) return;
    this.picture = picture;
    this.node.dataset.cells = picture ? String(picture.x.values.length) : "";
    this.#away.hidden = !picture;
    this.#ask.hidden = Boolean(picture);
    this.changed.announce(picture);
  }

  #showStatus(text, isRunning) {
    this.#words.textContent = text;
    this.#stop.hidden = !isRunning;
  }
}

const HARD = "subcritical";

/** The lines of a plane, each type and period once, and what dashes mean if a line has both kinds. */
function lineKeys({ loci }) {
  const names = [...new Set(loci.map(({ name }) => name))].sort();
  const keys = names.map((name) => {
    const [locus, ...others] = loci.filter((item) => item.name === name);
    const kinds = [locus, ...others].flatMap(({ segments }) => segments.map(({ criticality }) => criticality));
    const criticality = kinds.find((kind) => kind === "supercritical") ?? kinds[0];
    const isHard = kinds.every((kind) => kind === HARD);
    return { name: isHard ? nameOf(locus, HARD) : name, locus, criticality, isMixed: !isHard && kinds.includes(HARD) };
  });
  const mixed = keys.find(({ isMixed }) => isMixed);
  return mixed ? [...keys, { name: HARD, locus: { ...mixed.locus, type: "" }, criticality: HARD }] : keys;
}

/**
 * Names and colors of the shades that are seen: those of motions where there are such.
 * @param {object|null} plane the server's answer, or as far as it has come
 * @param {object|null} picture of what motions do
 */
export function shadesOf(plane, picture, color) {
  if (picture) return regimeKeys(picture).map(({ name, tint }) => ({ name, tint: color(tint) }));
  return shadeKeys(plane ?? { regions: null }).map(({ name, id }) => ({ name, tint: regionColor(plane.regions, id, color) }));
}

/** The shades of regions, each once; what is unknown has none. */
function shadeKeys({ regions }) {
  if (!regions) return [];
  const keys = Object.entries(regions.stable).map(([id, stable]) =>
    ({ name: words(regions.names[id], stable), stable, id }));
  const rank = ({ stable }) => stable.length || Infinity;
  return distinct(keys).sort((a, b) => rank(a) - rank(b) || (a.name < b.name ? -1 : 1));
}

export class PlaneLegend {
  /** The element to put on the page. */
  node = element("ul", { class: "plane-legend", tabindex: "0", "aria-label": "Lines and areas of the plane" });

  /**
   * @param {object|null} plane the server's answer, or as far as it has come
   * @param {object|null} picture of what motions do
   */
  show(plane, picture) {
    const color = colors();
    const lines = plane ? lineKeys(plane) : [];
    const shades = shadesOf(plane, picture, color);
    this.node.replaceChildren(
      ...lines.map(({ name, locus, criticality }) =>
        element("li", {}, sample(lineStyle(locus, criticality, color)), name)),
      ...shades.map(({ name, tint }) =>
        element("li", {}, element("span", { class: "shade", style: `background: ${tint}` }), name)));
  }
}

function words(name, stable) {
  if (stable.length === 0) return "none stable";
  if (stable.length > 1) return `${name}, ${stable.length === 2 ? "both" : "all"} stable`;
  const [period, ...stops] = name.split(", ");
  return [`${period} stable`, ...stops].join(", ");
}

function sample({ color, width, dash }) {
  const dashes = dash === "solid" ? null : dash.replaceAll("px", "");
  return svg("svg", { viewBox: "0 0 28 8", width: 28, height: 8, "aria-hidden": "true" },
    svg("path", { d: "M0 4H28", stroke: color, "stroke-width": width, "stroke-dasharray": dashes }));
}

function distinct(keys) {
  return [...new Map(keys.map((key) => [key.name, key])).values()];
}

/** How far beside a point of codimension two the diagrams lie at most that show what changes, over the window. */
const BESIDE = 0.06;

/** How far beside it they lie: half the way to where something else changes. */
function beside({ x }, points, [low, high]) {
  const others = points.map((other) => Math.abs(other.x - x)).filter((gap) => gap > 1e-6 * (high - low));
  return Math.min(BESIDE * (high - low), ...others.map((gap) => gap / 2));
}

export class PointCard {
  /** The element to put on the plot. */
  node = element("div", { class: "point-card", role: "dialog", tabindex: "-1", "aria-label": "Point of codimension two", hidden: true });
  #session;

  constructor(session) {
    this.#session = session;
    this.node.addEventListener("pointerdown", (event) => event.stopPropagation());
    this.node.addEventListener("keydown", (event) => event.key === "Escape" && this.hide());
  }

  /**
   * Explain a point, with buttons that lead to the diagrams on both sides of it.
   * @param {{x: number, y: number, sentence: string, meaning: string}} point
   * @param {object[]} points of all loci
   * @param {[number, number]} at where it is on the plot, in pixels
   */
  show(point, points, [px, py]) {
    const { x } = this.#session.view.plane;
    const quantity = this.#session.quantity(x.name);
    const { factor } = display(quantity);
    const away = beside(point, points, x.span);
    const side = (sign) => {
      const round = snapped((point.x + sign * away) * factor, roundStep(away * factor, 0.1)) / factor;
      const value = inside(round, x.span);
      return button(`${quantity.label} = ${withUnit(quantity, value, 9)}`,
        () => this.#go(value, point.y), { class: "small-button" });
    };
    this.node.replaceChildren(
      element("p", {}, `${point.sentence}.`), element("p", {}, point.meaning),
      element("div", { class: "sentence" }, element("span", {}, "Diagrams beside it:"), side(-1), side(1),
        button("Close", () => this.hide(), { class: "quiet" })));
    this.node.hidden = false;
    const { clientWidth, clientHeight } = this.node.parentElement;
    const { offsetWidth, offsetHeight } = this.node;
    const above = py - 12 - offsetHeight;
    const top = above < 0 ? inside(py + 12, [0, clientHeight - offsetHeight]) : above;
    this.node.style.transform = `translate(${inside(px - 40, [4, clientWidth - offsetWidth - 4])}px, ${top}px)`;
    this.node.focus({ preventScroll: true });
  }

  /** Take it away. */
  hide() {
    this.node.hidden = true;
  }

  /** Draw the diagram along the ordinate at a value of the abscissa. */
  #go(value, y) {
    const { view, store } = this.#session;
    const { plane } = view;
    store.commit({
      ...withVaried(view, plane.y.name, plane.y.span),
      parameters: { ...view.parameters, [plane.x.name]: value, [plane.y.name]: inside(y, plane.y.span) },
    });
  }
}

/** What is said when its computation is stopped, by what is drawn. */
const STOPPED = {
  nothing: "Stopped before anything was found.",
  part: "Stopped; the bifurcation set is unfinished.",
  others: "Stopped; the bifurcation set that is drawn belongs to other values.",
};

const COMPUTING = "Computing the bifurcation set…";
const AXES = { x: "Across", y: "Up" };

export class PlaneControls {
  /** The element to put on the page. */
  node = element("div", { class: "sentence" });
  /** What the server is doing, in words. */
  progress = element("div", { class: "progress" });
  /** What is to be known of a plane that is whole. */
  note = element("p", { class: "plane-note", role: "status" });
  #session;
  #rows;
  #drawn = "nothing";
  #words = element("span", { role: "status" });
  #stop = button("Stop", () => this.#cancel(), { class: "quiet", hidden: true });
  #again = button("Compute", () => this.#session.computePlane(), { class: "quiet", hidden: true });

  constructor(session) {
    this.#session = session;
    this.#rows = Object.entries(AXES).map(([axis, label]) => this.#row(axis, label));
    this.node.append(...this.#rows.flatMap(({ nodes }) => nodes));
    this.progress.append(this.#words, this.#stop, this.#again);
    session.store.changed.subscribe(() => this.#refresh());
    session.planeChanged.subscribe((change) => this.#changed(change));
    session.failed.subscribe(({ kind, sentence }) =>
      kind === "plane" && sentence && this.#idle("The bifurcation set was not computed."));
    session.connection.changed.subscribe(() => this.#connected());
    this.#refresh();
  }

  #row(axis, label) {
    const choice = new Choice(label, (name) => this.#choose(axis, name));
    const bounds = [0, 1].map((i) => new QuantityBox(
      { class: "bound", "aria-label": `${label} ${i === 0 ? "from" : "to"}` }, (value) => this.#bounded(axis, i, value)));
    const unit = element("span", { class: "unit" });
    const group = element("span", { class: "axis-choice" }, choice.node, bounds[0].node,
      element("span", {}, "to"), bounds[1].node, unit);
    return { axis, choice, bounds, unit, nodes: [group] };
  }

  #refresh() {
    const { view, model } = this.#session;
    if (!view.plane) return;
    const options = model.parameters.map(({ name, label, doc }) =>
      ({ value: name, text: label ?? name, title: doc }));
    for (const { axis, choice, bounds, unit } of this.#rows) {
      const { name, span } = view.plane[axis];
      const quantity = this.#session.quantity(name);
      choice.show(options, name);
      bounds.forEach((box, i) => box.show(quantity, span[i], span[1] - span[0]));
      unit.textContent = display(quantity).unit;
    }
  }

  #choose(axis, name) {
    const { view, model } = this.#session;
    const other = axis === "x" ? "y" : "x";
    const next = { ...view.plane, [axis]: { name, span: spanOf(model, name) } };
    if (view.plane[other].name === name) next[other] = view.plane[axis];
    this.#commit(next);
  }

  #bounded(axis, index, end) {
    const { plane } = this.#session.view;
    const span = [...plane[axis].span];
    span[index] = end;
    if (!(span[0] < span[1])) return `${plane[axis].name} has to grow from the first value to the last; give others`;
    this.#commit({ ...plane, [axis]: { ...plane[axis], span } });
  }

  #commit(plane) {
    this.#session.store.commit({ ...this.#session.view, plane });
  }

  #changed({ answer, progress, stale, loci, lines = [] }) {
    if (answer || loci || lines.length > 0) this.#drawn = "part";
    else if (stale && !progress && !this.#session.store.isLive && this.#drawn === "part") this.#drawn = "others";
    if (answer) this.#idle("", asSentence(answer.note ?? ""));
    else if (progress) this.#working(progress);
    else if (stale && !this.#session.store.isLive) this.#working(COMPUTING);
  }

  /** Nothing is computed without a server; with one, what was requested is requested again. */
  #connected() {
    const { connection, requests } = this.#session;
    if (!requests.isBusy("plane")) return;
    if (connection.isAlive) this.#working(COMPUTING);
    else {
      this.#words.textContent = "Not computed: there is no connection.";
      this.#stop.hidden = true;
    }
  }

  #working(text) {
    this.#words.textContent = text;
    this.#words.title = this.note.textContent = "";
    this.#stop.hidden = false;
    this.#again.hidden = true;
  }

  /** Nothing is computed: why, or of a plane that is whole what is to be known of it. */
  #idle(text, note = "") {
    this.#words.textContent = text;
    this.#words.title = text; // the line may be too short
    this.note.textContent = note;
    this.#stop.hidden = true;
    this.#again.hidden = text === "";
  }

  #cancel() {
    this.#session.requests.cancel("plane");
    this.#idle(STOPPED[this.#drawn]);
  }
}

export class PlaneSwitch {
  /** The element to put on the page. */
  node = button("Plane", () => this.#toggle(), { class: "small-button" });
  #session;

  constructor(session) {
    this.#session = session;
    session.store.changed.subscribe(() => this.#show());
    this.#show();
  }

  #show() {
    const { view: { plane }, model } = this.#session;
    // A plane takes two parameters.
    this.node.hidden = model.parameters.length < 2;
    this.node.setAttribute("aria-pressed", String(plane !== null));
    this.node.title = plane ? "Hide the plane of two parameters" : "Show the plane of two parameters";
  }

  #toggle() {
    const { view, model, store } = this.#session;
    store.commit({ ...view, plane: view.plane ? null : model.plane ?? this.#usual() });
  }

  /** What is varied upwards, and the first other parameter across. */
  #usual() {
    const { view, model } = this.#session;
    const other = model.parameters.find(({ name }) => name !== view.vary);
    return {
      x: { name: other.name, span: spanOf(model, other.name) },
      y: { name: view.vary, span: view.span },
    };
  }
}
