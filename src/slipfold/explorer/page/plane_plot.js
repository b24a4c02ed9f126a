/** The plane of two parameters: the bifurcation set, and the working point that is dragged in it. */

import { padded } from "./axis_range.js";
import { escaped } from "./diagram_traces.js";
import { element } from "./dom.js";
import { labelPlaces } from "./label_places.js";
import { markedPoints, planeTraces, regionNames } from "./plane_traces.js";
import { CONFIG, frame, layout, mapping } from "./plot_frame.js";
import { axisTitle, display, withUnit } from "./quantities.js";
import { colours, themeChanged } from "./theme.js";
import { inside } from "./view.js";

const KEY_STEPS = 100;

export class PlanePlot {
  /** The element to put on the page. */
  node = element("div", { class: "plot plane-plot" });
  #canvas = element("div", { class: "plot-canvas" });
  #point;
  #session;
  #arrived = null;
  #map = null;
  #frame = 0;

  /** @param {import("./session.js").Session} session */
  constructor(session) {
    this.#session = session;
    this.#point = element("button", {
      type: "button", class: "working-point", "aria-label": "Working point", hidden: true,
      title: "The working point: drag it, or move it with the arrow keys",
      on: { keydown: (event) => this.#key(event) },
    });
    this.node.append(this.#canvas, this.#point);
    session.planeChanged.subscribe((change) => this.#changed(change));
    session.store.changed.subscribe(({ view, before }) => {
      if (view.model !== before.model || !view.plane) this.#arrived = null;
      if (view.plane !== before.plane) this.#schedule();
      this.#place();
    });
    themeChanged.subscribe(() => this.#schedule());
    new ResizeObserver(() => this.#schedule()).observe(this.node);
    this.node.addEventListener("pointerdown", (event) => this.#grab(event));
    this.#schedule();
  }

  /** The figure as plotly's data and layout, for a file. */
  figure() {
    const data = structuredClone(this.#canvas.data);
    const sheet = structuredClone(this.#canvas.layout);
    return { data, layout: { ...sheet, paper_bgcolor: colours()("panel"), plot_bgcolor: colours()("panel") } };
  }

  #changed({ answer, stale }) {
    this.node.classList.toggle("stale", Boolean(stale));
    if (!answer) return;
    this.#arrived = answer;
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
    sheet.annotations = regionNames(this.#arrived?.regions, colour, [fx, fy], frame(size));
    const traces = this.#arrived
      ? planeTraces(this.#arrived, colour, [fx, fy], this.#positions(this.#arrived, fx, fy, size))
      : [];
    window.Plotly.react(this.#canvas, traces, sheet, CONFIG);
    this.node.dataset.loci = this.#arrived?.loci.length ?? 0;
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
    const { fx, fy } = this.#axes();
    const [a, b] = this.#map.toData(px, py);
    this.#set(a / fx, b / fy, how);
  }

  #key(event) {
    const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    const step = steps[event.key];
    if (!step) return;
    event.preventDefault();
    const { plane } = this.#axes();
    const { parameters } = this.#session.view;
    const [a, b] = [plane.x, plane.y].map(({ name, span }, i) =>
      parameters[name] + (step[i] * (event.shiftKey ? 10 : 1) * (span[1] - span[0])) / KEY_STEPS);
    this.#set(a, b, "commit");
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
