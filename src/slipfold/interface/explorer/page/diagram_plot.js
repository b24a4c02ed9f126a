/** The response diagram: curves, marks, the working point. plotly draws the curves; what follows the pointer lies above them and costs nothing to move. */

import {
  crossings, escaped, factors, lineTraces, markTrace, marksOf, nearestPlace, nearestSpecial,
} from "./diagram_data.js";
import { element } from "./dom.js";
import {
  CONFIG, covers, fits, labelPlaces, layout, mapping, onWhite, padded, pixelOf, plotly, redrawn, roundStep, stepped,
  withLegend,
} from "./plot_tools.js";
import { axisTitle, display, formatted, leastDamped, withUnit } from "./quantities.js";
import { measurementTraces, measurementValues } from "./measurements.js";
import { LiveLayer, MotionLayer, motionTraces } from "./motion_layer.js";
import { colors, light } from "./theme.js";
import { STATISTICS, inside } from "./view.js";

const REACH = 14;
const MARK = 9;
const MOVED = 4;
const KEY_STEPS = 200;
const FAINT = 0.4;

/** Milliseconds after the last curve of a moving slider from which plotly draws it. */
const STILL = 150;

export class DiagramPlot {
  /** The element to put on the page. */
  node = element("div", {
    class: "plot", tabindex: "0", role: "group", "aria-describedby": "diagram-keys",
    "aria-label": "Response diagram",
  });
  #canvas = element("div", { class: "plot-canvas" });
  #cursor = element("div", { class: "cursor-line", hidden: true });
  #chosen = element("div", { class: "place chosen", hidden: true });
  #hovered = element("div", { class: "place hovered", hidden: true });
  #tip = element("div", { class: "tip", hidden: true });
  #words = element("span", { role: "status" });
  #progress = element("span", { "aria-hidden": "true" });
  #waiting = element("p", { class: "waiting" }, this.#words, this.#progress);
  #session;
  #measurements;
  #sweep;
  #motions = new MotionLayer();
  #live = new LiveLayer();
  #still = 0;
  #drawn = null;
  #sight = { key: "", y: [0, 1] };
  #simulated = null;
  #isDrawnFaint = false;
  #drawSoon = redrawn(this.node, () => this.#redraw());
  /** Numbers of the drawings that were requested, and that are on the screen. */
  #asked = 0;
  #painted = 0;
  #pressed = null;

  constructor(session, measurements, sweep) {
    this.#session = session;
    this.#measurements = measurements;
    this.#sweep = sweep;
    // Names of special points lie above the motions.
    this.node.append(this.#motions.node, this.#canvas, this.#live.node, this.#cursor, this.#chosen, this.#hovered, this.#tip,
      this.#waiting);
    this.#showStatus();
    session.diagramArrived.subscribe(() => this.#drawNow());
    session.pinsChanged.subscribe(() => this.#schedule());
    measurements.changed.subscribe(() => this.#schedule());
    sweep.changed.subscribe(() => this.#drawMotions());
    session.progressed.subscribe((far) => { this.#progress.textContent = far ? this.#progressText(far) : ""; });
    session.placeChanged.subscribe(() => this.#place());
    session.orbitArrived.subscribe((arrived) => this.#tipOf(arrived));
    session.failed.subscribe(({ sentence }) => sentence && this.#showStatus());
    session.connection.changed.subscribe(() => this.#showStatus());
    session.store.changed.subscribe(({ view, before }) => {
      if (view.zoom !== before.zoom) this.#schedule();
      if (view.model !== before.model) this.#simulated = null;
      this.#place();
      if (this.#isFaint !== this.#isDrawnFaint) this.#schedule();
      this.#showStatus();
    });
    this.#listen();
  }

  /**
   * Show how a simulation went: one dot a period, at the working point.
   * @param {{x: number, y: number[]}|null} points in SI units
   */
  simulated(points) {
    const isGone = this.#simulated && !points;
    this.#simulated = points;
    this.#drawMotions();
    if (isGone) this.#schedule(); // the ordinate may have held it
  }

  /** The figure as plotly's data and layout, for a file: with a legend and on white. */
  figure() {
    const { diagram, names } = this.#drawn;
    const traces = [...motionTraces(this.#simulated, this.#sweep.runs, factors(diagram), light), ...this.#traces(diagram, light)];
    for (const trace of traces) trace.showlegend = Boolean(trace.name) && trace.x.length > 0;
    const isExplained = names.length > 0 || this.#measured(diagram) !== null;
    const sheet = withLegend(structuredClone(this.#canvas.layout),
      isExplained ? traces.filter(({ showlegend }) => showlegend).map(({ name }) => name) : []);
    return { data: traces, layout: onWhite(sheet) };
  }

  #schedule() {
    this.#asked += 1;
    if (this.#session.diagram) this.node.setAttribute("aria-busy", "true");
    this.#drawSoon();
  }

  /** Draw without waiting for a frame: the next one shows it. While a slider moves the axes stand still. */
  #drawNow() {
    this.#asked += 1;
    this.#redraw(this.#drawn?.size);
  }

  /** Draw; another size than the known one calls for it by itself. */
  #redraw(size = this.#size) {
    if (!this.#session.store.isLive || !this.#drawLive(size)) this.#draw();
  }

  get #size() {
    return [this.node.clientWidth, this.node.clientHeight];
  }

  /** Draw the curve alone, if plotly has drawn all else; return whether it has. */
  #drawLive(size) {
    const { diagram, view } = this.#session;
    if (!this.#drawn || view.pins.length > 0 || this.#measured(diagram)) return false;
    const range = this.#ranges(diagram);
    if (JSON.stringify([size, range, diagram.x, diagram.y]) !== this.#drawn.sheet) return false;
    this.#drawn.diagram = diagram;
    this.#live.draw(this.#traces(diagram, colors()), this.#drawn.map, this.#canvas.layout.font.family);
    this.node.classList.add("moving");
    clearTimeout(this.#still);
    this.#still = setTimeout(() => this.#draw(), STILL);
    this.#place();
    this.#announceSoon(this.#asked, diagram);
    return true;
  }

  async #draw() {
    if (!window.Plotly) await plotly;
    const { diagram, view } = this.#session;
    if (!diagram || this.node.clientWidth === 0) return;
    clearTimeout(this.#still);
    const number = this.#asked;
    const size = this.#size;
    const range = this.#ranges(diagram);
    const sheetKey = JSON.stringify([size, range, diagram.x, diagram.y]);
    this.#drawn = { diagram, map: mapping(size, range.x, range.y), names: view.pins, sheet: sheetKey, size };
    const color = colors();
    const title = { x: axisTitle(diagram.x), y: valueTitle(diagram.y) };
    const sheet = layout(color, { title: escaped(title.x), range: range.x },
      { title: escaped(title.y), range: range.y }, size);
    const plotted = window.Plotly.react(this.#canvas, this.#traces(diagram, color), sheet, CONFIG);
    this.#place();
    this.#drawMotions();
    await plotted;
    if (number === this.#asked) this.node.classList.remove("moving"); // else the live curve may be newer
    this.#listenToPlot();
    this.#announceSoon(number, diagram);
  }

  /** Announce a diagram after the next frame: what is posted in a frame is done once that is on the screen. */
  #announceSoon(number, diagram) {
    requestAnimationFrame(() => setTimeout(() => this.#announcePainted(number, diagram)));
  }

  /** Announce that a diagram is on the screen: measurements and tests wait for it. */
  #announcePainted(number, { id, moved = false }) {
    this.#painted = number;
    this.node.dataset.drawn = id;
    this.#showStatus();
    this.node.dispatchEvent(new CustomEvent("painted", { detail: { id, moved } }));
  }

  #traces(diagram, color) {
    const { pins } = this.#session;
    const paper = color("panel");
    const pinned = this.#session.view.pins.flatMap((pin, i) => {
      const answer = pins.get(pin.id);
      if (!answer) return [];
      const tint = color(`pin-${(i % 6) + 1}`);
      const name = escaped(pin.name);
      return [...lineTraces(answer, tint, name), markTrace(answer, tint, paper, [])];
    });
    const live = color("live");
    const marks = markTrace(diagram, live, paper, this.#labels(diagram));
    this.#isDrawnFaint = this.#isFaint;
    return [
      ...pinned,
      ...faint([...lineTraces(diagram, live, "current"), marks], this.#isDrawnFaint),
      ...measurementTraces(this.#measured(diagram), factors(diagram), color("measurements")),
    ];
  }

  /** Whether the curve drawn belongs to other values: that of these is to come. */
  get #isFaint() {
    return !this.#session.isSettled && !this.#session.isMore;
  }

  /** What was measured of what a diagram shows. */
  #measured({ x, y }) {
    return this.#measurements.of({ vary: x.name, show: y.name, statistic: y.statistic });
  }

  #labels(diagram) {
    const [fx, fy] = factors(diagram);
    const { map } = this.#drawn;
    const at = (x, y) => map.toPixel(x * fx, y * fy);
    const texts = marksOf(diagram).map(({ of, text, short, x, y }) => ({ of, text, short, at: at(x, y) }));
    const drawn = [diagram, ...this.#session.pins.values()];
    const lines = drawn.flatMap(({ branches }) => branches.map(({ x, y }) => x.map((value, i) => at(value, y[i]))));
    const pinned = drawn.slice(1).flatMap((answer) => marksOf(answer).map((mark) => at(mark.x, mark.y)));
    const { parameters, vary } = this.#session.view;
    const [x] = at(parameters[vary], 0); // the working point's line, on which simulations are drawn
    const line = [[x, map.frame.top], [x, map.frame.top + map.frame.height]];
    return labelPlaces(texts, [...lines, line], map.frame, pinned);
  }

  /** What the axes show: the zoom, or everything; while a slider moves they only grow. */
  #ranges(diagram) {
    const { view } = this.#session;
    const [fx, fy] = factors(diagram);
    if (view.zoom) return { x: view.zoom.x.map((v) => v * fx), y: view.zoom.y.map((v) => v * fy) };
    const wanted = padded(this.#values(diagram)).map((value) => value * fy);
    const key = JSON.stringify([view.model, view.vary, view.span, view.show, view.statistic]);
    const { key: before, y } = this.#sight;
    if (key !== before) this.#sight = { key, y: wanted };
    else if (this.#session.store.isLive && !covers(y, wanted)) {
      this.#sight.y = [Math.min(y[0], wanted[0]), Math.max(y[1], wanted[1])];
    } else if (!this.#session.store.isLive && !fits(y, wanted)) this.#sight.y = wanted;
    return { x: padded(view.span, 0.015).map((value) => value * fx), y: this.#sight.y };
  }

  *#values(diagram) {
    for (const answer of [diagram, ...this.#session.pins.values()]) {
      // A family of cycles, as around a center, has every amplitude: it is seen as far as the others.
      const isBounded = ({ stopped }) => stopped.kind !== "family";
      const seen = answer.branches.some((branch) => isBounded(branch) && hasHeight(branch))
        ? answer.branches.filter(isBounded) : answer.branches;
      for (const branch of seen) yield* branch.y;
    }
    yield* this.#simulated?.y ?? [];
    yield* this.#sweep.places.map(({ y }) => y);
    yield* measurementValues(this.#measured(diagram), this.#session.view.span);
  }

  #progressText({ progress, value }) {
    const vary = this.#session.quantity(this.#session.view.vary);
    return ` ${progress}, ${vary.label} = ${withUnit(vary, value)}`;
  }

  /** Show whether the diagram is complete; one of another model is not shown. */
  #showStatus() {
    const { isSettled, diagram, connection, hasFailed } = this.#session;
    const isPainted = !diagram || (this.#painted === this.#asked && !this.node.classList.contains("moving"));
    this.node.classList.toggle("refused", hasFailed);
    this.node.setAttribute("aria-busy", String(!isSettled || !isPainted));
    this.node.classList.toggle("empty", !diagram);
    this.node.classList.toggle("working", !isSettled);
    this.node.classList.toggle("of-others", this.#isFaint);
    const more = diagram?.moved ? "Computing the rest of the response…" : "Following what motions settle on elsewhere…";
    const words = this.#session.isMore ? more : "Computing the response…";
    this.#words.textContent = connection.isAlive ? words : "Not computed: there is no connection.";
  }

  /** Draw a simulation and a sweep; plotly draws again only where they need another range. */
  #drawMotions() {
    if (!this.#drawn) return;
    const { diagram, map } = this.#drawn;
    const [fx, fy] = factors(diagram);
    this.#motions.draw(this.#simulated, this.#sweep.runs, map, [fx, fy]);
    const [low, high] = this.#sight.y;
    const isBeyond = (y) => y * fy < low || y * fy > high;
    const isWider = this.#sweep.places.some(({ y }) => isBeyond(y)) || this.#simulated?.y.some(isBeyond);
    if (isWider && !this.#session.view.zoom) this.#schedule();
  }

  /** Move what marks the working point. */
  #place() {
    if (!this.#drawn) return;
    const { place, view } = this.#session;
    const { diagram, map } = this.#drawn;
    const [fx] = factors(diagram);
    const box = map.frame;
    const [x] = map.toPixel(view.parameters[view.vary] * fx, 0);
    const isSeen = x >= box.left - 1 && x <= box.left + box.width + 1;
    this.#cursor.hidden = !isSeen;
    this.#cursor.style.transform = `translateX(${x}px)`;
    this.#cursor.style.top = `${box.top}px`;
    this.#cursor.style.height = `${box.height}px`;
    this.#put(this.#chosen, place);
  }

  #put(mark, place) {
    const { diagram, map } = this.#drawn;
    const [fx, fy] = factors(diagram);
    const [x, y] = place ? map.toPixel(place.x * fx, place.y * fy) : [0, 0];
    mark.hidden = !place || !map.isInside(x, y);
    mark.style.transform = `translate(${x}px, ${y}px)`;
    return [x, y];
  }

  #listen() {
    this.node.addEventListener("pointermove", (event) => this.#point(event));
    this.node.addEventListener("pointerleave", () => this.#hover(null));
    this.node.addEventListener("pointerdown", (event) => {
      this.#pressed = [event.clientX, event.clientY];
    }, true);
    this.node.addEventListener("click", (event) => this.#click(event), true);
    this.node.addEventListener("keydown", (event) => this.#key(event));
  }

  #listenToPlot() {
    if (this.#canvas.dataset.listening) return;
    this.#canvas.dataset.listening = "true";
    this.#canvas.on("plotly_relayout", (change) => this.#zoomed(change));
    this.#canvas.on("plotly_doubleclick", () => this.#zoom(null));
  }

  #zoomed(change) {
    const { x, y } = this.#canvas.layout ? ranges(this.#canvas.layout) : {};
    if (!Object.keys(change).some((key) => /^[xy]axis\.range/.test(key))) return;
    const [fx, fy] = factors(this.#drawn.diagram);
    this.#zoom({ x: x.map((value) => value / fx), y: y.map((value) => value / fy) });
  }

  #zoom(zoom) {
    this.#session.store.commit({ ...this.#session.view, zoom });
  }

  #placeAt(event) {
    if (!this.#drawn || event.buttons > 0 || this.#session.hasFailed) return null;
    const { diagram, map } = this.#drawn;
    const point = pixelOf(event, this.node);
    if (!map.isInside(...point)) return null;
    const [fx, fy] = factors(diagram);
    const pixel = (x, y) => map.toPixel(x * fx, y * fy);
    return nearestSpecial(diagram, pixel, point, MARK) ?? nearestPlace(diagram, pixel, point, REACH);
  }

  #point(event) {
    this.#hover(this.#placeAt(event));
  }

  #hover(place) {
    if (!this.#drawn) return;
    const wasHovering = !this.#hovered.hidden;
    const [x, y] = this.#put(this.#hovered, place);
    this.#tip.hidden = !place;
    this.node.classList.toggle("on-curve", Boolean(place));
    if (place) {
      this.#tip.textContent = this.#describe(place);
      this.#tip.dataset.place = keyOf(place);
      const isRight = x > this.node.clientWidth / 2;
      this.#tip.style.transform = `translate(${x}px, ${y}px) translate(${isRight ? "calc(-100% - 14px)" : "14px"}, -120%)`;
    }
    if (place || wasHovering) this.#session.hover(place);
  }

  /** Describe the least damped mode of the equilibrium under the pointer, once it is computed. */
  #tipOf(arrived) {
    if (this.#tip.hidden || !arrived?.answer.eigenvalues || this.#tip.dataset.place !== keyOf(arrived.place)) return;
    this.#tip.textContent = [this.#describe(arrived.place), leastDamped(arrived.answer.eigenvalues)].join("\n");
  }

  #describe(place) {
    const { diagram } = this.#drawn;
    const at = `${diagram.x.label} = ${withUnit(diagram.x, place.x)}`;
    const y = display(diagram.y);
    const value = `${valueTitle({ ...diagram.y, statistic: place.statistic })} = ${formatted(place.y * y.factor)}`;
    if (place.special) return `${place.special.sentence}\n${value}`;
    const kind = place.kind === "stable" ? "stable" : `unstable: ${place.kind}`;
    const moving = this.#session.model.forced ? `period ${place.period}` : "cycle";
    const orbit = place.isEquilibrium ? "equilibrium" : moving;
    return `${at}\n${value}\n${orbit}, ${kind}`;
  }

  #click(event) {
    const start = this.#pressed ?? [event.clientX, event.clientY];
    if (Math.hypot(event.clientX - start[0], event.clientY - start[1]) > MOVED) return;
    const place = this.#placeAt(event);
    if (place) this.#session.choose(place);
  }

  /** The value of the parameter a round step on, in the unit that is shown. */
  #stepped(count, { shiftKey }) {
    const { vary, span: [a, b], parameters } = this.#session.view;
    const { factor } = display(this.#session.quantity(vary));
    const step = roundStep((b - a) * factor, 1 / KEY_STEPS) * (shiftKey ? 10 : 1);
    return stepped(parameters[vary] * factor, step, count * Math.sign(b - a)) / factor;
  }

  #key(event) {
    const { view, place, diagram, store } = this.#session;
    if (!diagram || event.ctrlKey || event.metaKey || event.altKey) return;
    const [a, b] = view.span;
    const value = view.parameters[view.vary];
    const moved = { ArrowLeft: this.#stepped(-1, event), ArrowRight: this.#stepped(1, event), Home: a, End: b }[event.key];
    if (moved !== undefined) {
      const parameters = { ...view.parameters, [view.vary]: inside(moved, view.span) };
      store.commit({ ...view, parameters });
    } else if (["ArrowUp", "ArrowDown"].includes(event.key)) {
      const places = crossings(diagram, value).sort((p, q) => p.y - q.y);
      const here = places.findIndex((p) => p.branch === place?.branch && p.y === place.y);
      const next = places[here + (event.key === "ArrowUp" ? 1 : -1)];
      if (next) this.#session.choose(next);
    } else return;
    event.preventDefault();
  }
}

/** What distinguishes a place from others. */
function keyOf({ branch, arclength }) {
  return `${branch} ${arclength}`;
}

function hasHeight({ y }) {
  return Math.max(...y) > Math.min(...y);
}

/** Traces as they are, or faint where they are those of other values. */
function faint(traces, isFaint) {
  return traces.map((trace) => ({ ...trace, opacity: isFaint ? FAINT : 1 }));
}

/** The title of the ordinate, e.g. `max |x/L|`. */
export function valueTitle(quantity) {
  const words = STATISTICS[quantity.statistic];
  const { unit } = display(quantity);
  const text = words.includes("|·|")
    ? words.replace("|·|", `|${quantity.label}|`)
    : `${words} ${quantity.label}`;
  return unit ? `${text} (${unit})` : text;
}

function ranges({ xaxis, yaxis }) {
  return { x: xaxis.range.map(Number), y: yaxis.range.map(Number) };
}
