/** The plane of two parameters: the bifurcation set, and the working point that is dragged in it. */

import { padded } from "../plots/axis_range.js";
import { CheckedLine } from "../diagram/checked_line.js";
import { escaped } from "../diagram/diagram_traces.js";
import { element } from "../controls/dom.js";
import { labelPlaces } from "../plots/label_places.js";
import { PlaneLegend, shadesOf } from "./plane_legend.js";
import { draftOf, markedPoints, planeTraces, regionNames } from "./plane_traces.js";
import { CONFIG, frame, layout, mapping } from "../plots/plot_frame.js";
import { axisTitle, display, withUnit } from "../parameters/quantities.js";
import { regimeTraces } from "./regime_shades.js";
import { roundStep, snapped } from "../plots/steps.js";
import { colours, themeChanged } from "../style/theme.js";
import { UnderPointer } from "./under_pointer.js";
import { inside } from "../session/view.js";

const KEY_STEPS = 100;

/** What the ring moves by when it is dragged, over the window. */
const FINE = 0.001;
/** Of the legend of a saved picture, in pixels. */
const LEGEND_LINE = 20;
const LEGEND_SAMPLE = 45;
const LETTER = 7;

export class PlanePlot {
  /** The element to put on the page. */
  node = element("div", { class: "plot plane-plot" });
  /** What its lines and shades mean. */
  legend = new PlaneLegend();
  /** What was computed again by other means. */
  checked = new CheckedLine();
  /** What there is under the pointer. */
  pointed = new UnderPointer();
  #canvas = element("div", { class: "plot-canvas" });
  #draft = element("p", { class: "draft-mark", hidden: true }, "draft");
  #point;
  #session;
  #regimes;
  /** What is drawn: the server's answer, or as much of it as has come. */
  #shown = null;
  /** Whether it is of what was asked for last, and not of what was before. */
  #isOfAsked = false;
  #lines = new Map();
  #map = null;
  #frame = 0;

  /**
   * @param {import("../session/session.js").Session} session
   * @param {import("./regimes.js").Regimes} regimes
   */
  constructor(session, regimes) {
    this.#session = session;
    this.#regimes = regimes;
    regimes.changed.subscribe(() => this.#schedule());
    this.#point = element("button", {
      type: "button", class: "working-point", "aria-label": "Working point", hidden: true,
      title: "The working point: drag it, or move it with the arrow keys",
      on: { keydown: (event) => this.#key(event) },
    });
    this.node.append(this.#canvas, this.#draft, this.#point);
    session.planeChanged.subscribe((change) => this.#changed(change));
    session.store.changed.subscribe(({ view, before }) => {
      if (view.model !== before.model || !view.plane) this.#shown = null;
      if (view.plane !== before.plane) this.#schedule();
      this.#place();
    });
    themeChanged.subscribe(() => this.#schedule());
    new ResizeObserver(() => this.#schedule()).observe(this.node);
    this.node.addEventListener("pointerdown", (event) => this.#grab(event));
    this.node.addEventListener("pointermove", (event) => this.#tell(event));
    this.node.addEventListener("pointerleave", () => this.pointed.show(null));
    this.#schedule();
  }

  /** The figure as plotly's data and layout, for a file. */
  figure() {
    const colour = colours();
    const named = new Set();
    const data = structuredClone(this.#canvas.data).map((trace) => {
      const isNew = trace.mode === "lines" && !named.has(trace.name);
      if (isNew) named.add(trace.name);
      return { ...trace, showlegend: isNew };
    });
    const shades = shadesOf(this.#shown, this.#regimes.picture, colour).map(({ name, tint }) => ({
      type: "scatter", mode: "markers", x: [null], y: [null], name, showlegend: true,
      marker: { symbol: "square", size: 12, color: tint },
    }));
    const sheet = structuredClone(this.#canvas.layout);
    const names = [...named, ...shades.map(({ name }) => name)];
    const widest = Math.max(...names.map((name) => name.length)) * LETTER + LEGEND_SAMPLE;
    const rows = Math.ceil(names.length / Math.max(Math.floor((sheet.width - 20) / widest), 1));
    const room = LEGEND_LINE * rows + 12;
    return {
      data: [...data, ...shades],
      layout: {
        ...sheet, paper_bgcolor: colour("panel"), plot_bgcolor: colour("panel"),
        height: sheet.height + room, margin: { ...sheet.margin, b: sheet.margin.b + room },
        showlegend: true,
        legend: { orientation: "h", yref: "container", y: 0, yanchor: "bottom", x: 0, entrywidth: widest - LEGEND_SAMPLE },
      },
    };
  }

  #changed({ answer, stale = false, isSame = false, id, lines = [], loci }) {
    if (stale && !this.#session.store.isLive) this.#isOfAsked = false;
    if (isSame) this.node.classList.toggle("stale", !this.#isOfAsked);
    if (id !== this.#lines.of) this.#lines = Object.assign(new Map(), { of: id });
    for (const line of lines) this.#lines.set(line.number, line);
    const shown = answer ?? (loci ? { loci, regions: null } : lines.length > 0 && draftOf([...this.#lines.values()]));
    // What belongs to other values is pale, and gives way to the first lines of what is asked for.
    if (shown || stale) this.node.classList.toggle("stale", stale);
    if (!shown) return;
    this.#isOfAsked = true;
    this.#shown = shown;
    this.#schedule();
  }

  #schedule() {
    if (this.#frame) return;
    this.#frame = requestAnimationFrame(() => {
      this.#frame = 0;
      this.#draw();
    });
  }

  #axes() {
    const { plane } = this.#session.view;
    const x = this.#session.quantity(plane.x.name);
    const y = this.#session.quantity(plane.y.name);
    return { x, y, fx: display(x).factor, fy: display(y).factor, plane };
  }

  #draw() {
    if (!this.#session.view.plane || this.node.clientWidth === 0) return;
    const { x, y, fx, fy, plane } = this.#axes();
    const size = [this.node.clientWidth, this.node.clientHeight];
    const range = {
      x: padded(plane.x.span, 0).map((v) => v * fx),
      y: padded(plane.y.span, 0).map((v) => v * fy),
    };
    this.#map = mapping(size, range.x, range.y);
    const colour = colours();
    const sheet = layout(colour, { title: escaped(axisTitle(x)), range: range.x },
      { title: escaped(axisTitle(y)), range: range.y }, size);
    sheet.dragmode = false;
    sheet.xaxis.showgrid = sheet.yaxis.showgrid = false;
    sheet.xaxis.fixedrange = sheet.yaxis.fixedrange = true;
    const shown = this.#shown;
    const { picture } = this.#regimes;
    // Names of regions would lie on what motions do there.
    sheet.annotations = picture ? [] : regionNames(shown?.regions, colour, [fx, fy], frame(size));
    const below = regimeTraces(picture, colour, [fx, fy]);
    const traces = shown
      ? planeTraces(shown, colour, [fx, fy], this.#positions(shown, fx, fy, size), below) : below;
    window.Plotly.react(this.#canvas, traces, sheet, CONFIG);
    this.legend.show(shown, picture);
    this.checked.show(shown?.checked);
    this.#draft.hidden = !shown?.isDraft;
    this.node.dataset.loci = shown?.done ? shown.loci.length : 0;
    this.#place();
  }

  #positions(plane, fx, fy, size) {
    const at = (x, y) => this.#map.toPixel(x * fx, y * fy);
    const lines = plane.loci.flatMap((locus) => locus.stretches)
      .map(({ x, y }) => x.map((value, i) => at(value, y[i])));
    const texts = markedPoints(plane).map(({ type, x, y }) => ({ text: type, at: at(x, y) }));
    return labelPlaces(texts, lines, frame(size));
  }

  #place() {
    const { view } = this.#session;
    if (!view.plane || !this.#map) return;
    const { x, y, fx, fy, plane } = this.#axes();
    const values = [view.parameters[plane.x.name], view.parameters[plane.y.name]];
    const [px, py] = this.#map.toPixel(values[0] * fx, values[1] * fy);
    this.#point.hidden = !this.#map.isInside(px, py);
    this.#point.style.transform = `translate(${px}px, ${py}px)`;
    const text = `${x.label ?? x.name} = ${withUnit(x, values[0])}, ${y.label ?? y.name} = ${withUnit(y, values[1])}`;
    this.#point.setAttribute("aria-label", `Working point: ${text}. Arrow keys move it`);
  }

  #tell({ clientX, clientY }) {
    const box = this.node.getBoundingClientRect();
    const pixel = [clientX - box.left, clientY - box.top];
    if (!this.#session.view.plane || !this.#map?.isInside(...pixel)) {
      this.pointed.show(null);
      return;
    }
    const { x, y, fx, fy } = this.#axes();
    const [a, b] = this.#map.toData(...pixel);
    this.pointed.show({ x, y, at: [a / fx, b / fy], shown: this.#shown, picture: this.#regimes.picture });
  }

  #grab(event) {
    if (!this.#map || event.button !== 0 || !this.#session.view.plane) return;
    const box = this.node.getBoundingClientRect();
    const at = ({ clientX, clientY }) => [clientX - box.left, clientY - box.top];
    if (!this.#map.isInside(...at(event))) return;
    event.preventDefault();
    this.#point.focus({ preventScroll: true });
    this.node.setPointerCapture(event.pointerId);
    this.node.classList.add("dragging");
    const move = (moved) => this.#move(...at(moved), "preview");
    const end = (moved) => {
      this.node.removeEventListener("pointermove", move);
      this.node.classList.remove("dragging");
      this.#move(...at(moved), "commit");
    };
    this.node.addEventListener("pointermove", move);
    this.node.addEventListener("pointerup", end, { once: true });
    this.node.addEventListener("pointercancel", end, { once: true });
    this.#move(...at(event), "preview");
  }

  #move(px, py, how) {
    const { fx, fy, plane } = this.#axes();
    const [a, b] = this.#map.toData(px, py);
    const round = (value, [low, high], factor) => snapped(value, roundStep((high - low) * factor, FINE));
    this.#set(round(a, plane.x.span, fx) / fx, round(b, plane.y.span, fy) / fy, how);
  }

  #key(event) {
    const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    const step = steps[event.key];
    if (!step) return;
    event.preventDefault();
    const { fx, fy, plane } = this.#axes();
    const { parameters } = this.#session.view;
    const moved = ({ name, span: [low, high] }, factor, count) => {
      const range = (high - low) * factor;
      const by = count * (event.shiftKey ? 10 : 1) * Math.sign(range) * roundStep(range, 1 / KEY_STEPS);
      return count ? snapped(parameters[name] * factor + by, roundStep(range, FINE)) / factor : parameters[name];
    };
    this.#set(moved(plane.x, fx, step[0]), moved(plane.y, fy, step[1]), "commit");
  }

  #set(a, b, how) {
    const { view, store } = this.#session;
    const { x, y } = view.plane;
    const parameters = {
      ...view.parameters, [x.name]: inside(a, x.span), [y.name]: inside(b, y.span),
    };
    store[how]({ ...view, parameters });
  }
}
