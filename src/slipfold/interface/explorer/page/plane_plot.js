/** Bifurcations in two parameters: colors, traces, and the plot with its working point. */

import { besideMarker, escaped } from "./diagram_data.js";
import { CheckedLine } from "./diagram_panel.js";
import { button, element } from "./dom.js";
import { PlaneLegend, PointCard, shadesOf } from "./plane_panel.js";
import {
  CONFIG, labelPlaces, mapLayout, mapping, onWhite, padded, pixelOf, redrawn, roundStep, snapped, withLegend,
} from "./plot_tools.js";
import { axisTitle, display, withUnit } from "./quantities.js";
import { colors, light, mixed, typeScale } from "./theme.js";
import { inside } from "./view.js";

const SHADES = { 1: "region-1", "1-2": "region-1-2", 2: "region-2", "": "region-none" };
const OTHERS = 12;

/** Turn of the hue that never comes back to where it was. */
const GOLDEN = 0.6180339887498949;

/** How much of the color of stick the regions have in which contacts of stable responses stop. */
const STOPPING = 0.3;

/**
 * The color of a region.
 * @param {object} regions the server's
 * @param {(name: string) => string} color of the style sheet
 */
export function regionColor({ stable, sticks }, id, color) {
  const tint = colorOf(stable[id], color);
  return sticks[id] ? mixed(tint, color("regime-sticks"), STOPPING) : tint;
}

/** The color of regions with stable responses of these periods. */
function colorOf(stable, color) {
  const known = SHADES[stable.join("-")];
  if (known) return color(known);
  const rank = rankOf(stable);
  if (rank < OTHERS) return color(`region-other-${rank + 1}`);
  return `hsl(${((rank * GOLDEN % 1) * 360).toFixed(1)}, 45%, ${color("region-lightness")})`;
}

/** Combinations numbered from 0: those of periods 1 and 2 by how many there are, then others. */
function rankOf(stable) {
  const count = stable.length;
  const doubled = stable.filter((period) => period === 2).length;
  if (stable.every((period) => period === 1 || period === 2)) {
    if (count === 2) return doubled / 2;
    return ((count - 2) * (count + 3)) / 2 - 1 + doubled;
  }
  return [...stable].sort((a, b) => a - b).reduce((sum, period, i) => sum + period * 31 ** i, 1000);
}

const REGIME_SHADES = {
  "period 1": "regime-1", "period 2": "regime-2", "period 4": "regime-4", "period 8": "regime-8",
  torus: "regime-torus", chaos: "regime-chaos", sticks: "regime-sticks", stopped: "regime-stopped",
  undecided: "panel",
};

/** The shade of a regime by its name: periods that have none of their own share one. */
function shadeOf(name) {
  return REGIME_SHADES[name] ?? "regime-other";
}

/**
 * Names and shades of all that motions do, each shade once, the quiet ones first.
 * @param {{names: string[]}} picture the server's
 */
export function regimeKeys({ names }) {
  const order = [...Object.values(REGIME_SHADES).slice(0, 4), "regime-other", ...Object.values(REGIME_SHADES).slice(4)];
  const keys = new Map(names.map((name) => {
    const tint = shadeOf(name);
    return [tint, { name: tint === "regime-other" ? "other periods" : name, tint }];
  }));
  return [...keys.values()].sort((a, b) => order.indexOf(a.tint) - order.indexOf(b.tint));
}

/**
 * Traces of plotly: a shade for what the motion of each cell does; none where that is not known yet.
 * @param {object|null} picture the server's
 * @param {[number, number]} factors of the two axes
 */
function regimeTraces(picture, color, [fx, fy]) {
  if (!picture) return [];
  const { x, y, labels, names } = picture;
  const tints = ["rgba(0,0,0,0)", ...names.map((name) => color(shadeOf(name)))];
  return [{
    type: "heatmap", x: x.values.map((v) => v * fx), y: y.values.map((v) => v * fy), z: labels,
    zmin: -0.5, zmax: tints.length - 0.5, showscale: false, hoverinfo: "skip", zsmooth: false,
    colorscale: tints.flatMap((tint, i) => [[i / tints.length, tint], [(i + 1) / tints.length, tint]]),
  }];
}

const DASHES = { supercritical: "solid", subcritical: "6px,3px" };

/** Of types without criticality, as in the package's figures. */
const OWN_DASHES = {
  LP: "7px,2px,1.5px,2px", GRAZE: "6px,2px,2px,2px,2px,2px", STICK: "12px,2px,2px,2px", LIFT: "2px,2px,2px,6px",
};
const WIDTHS = { 1: 2.4, 2: 1.5 };
const FAINT = 0.55;

/** Pixels of the marker of a point of codimension two. */
const MARKER = 6;

/** Points of a locus that are nothing but its own extrema. */
const UNMARKED = ["MIN", "MAX", "EVENT"];

/**
 * How a segment of a locus is drawn: the color shows the type, dashes the criticality, the
 * width the period.
 */
export function lineStyle({ type, period }, criticality, color) {
  return {
    color: color(`locus-${type}`) || color("ink"), width: WIDTHS[period] ?? 1.1,
    dash: OWN_DASHES[type] ?? DASHES[criticality] ?? "1.5px,2.5px",
  };
}

/** The name of a segment of a locus. */
export function nameOf({ name }, criticality) {
  return criticality ? `${name}, ${criticality}` : name;
}

/**
 * A plane as far as it is computed, of the lines that are being followed.
 * @param {object[]} lines the server's
 */
function draftOf(lines) {
  const loci = lines.map(({ type, period, name, x, y }) => (
    { type, period, name, segments: [{ criticality: null, x, y }], special: [] }));
  return { loci, regions: null, isDraft: true };
}

/**
 * The points of codimension two, each once, whatever number of loci meets there; of those of one type within
 * the width of a marker one is marked, with how many there are.
 * @param {object} plane the server's answer
 * @param {(x: number, y: number) => [number, number]} pixelOf a place in SI units
 */
function markedPoints({ loci }, pixelOf) {
  const points = new Map();
  for (const point of loci.flatMap((locus) => locus.special)) {
    const { type, x, y } = point;
    if (!UNMARKED.includes(type)) points.set(`${type} ${x.toPrecision(4)} ${y.toPrecision(4)}`, point);
  }
  const marked = [];
  for (const point of points.values()) {
    const at = pixelOf(point.x, point.y);
    const same = marked.find(({ type, at: [px, py] }) => type === point.type && Math.hypot(px - at[0], py - at[1]) < MARKER);
    if (same) same.count += 1;
    else marked.push({ ...point, at, count: 1 });
  }
  return marked;
}

function regionTraces(regions, color, fx, fy) {
  if (!regions) return [];
  const ids = Object.keys(regions.names).map(Number);
  const largest = Math.max(1, ...ids);
  const tint = (id) => (id in regions.stable ? regionColor(regions, id, color) : "rgba(0,0,0,0)");
  const scale = Array.from({ length: largest + 1 }, (_, id) => [
    [id / (largest + 1), tint(id)], [(id + 1) / (largest + 1), tint(id)],
  ]).flat();
  return [{
    type: "heatmap", x: regions.x.map((v) => v * fx), y: regions.y.map((v) => v * fy),
    z: regions.labels, zmin: -0.5, zmax: largest + 0.5, colorscale: scale, showscale: false,
    hoverinfo: "skip", zsmooth: false,
  }];
}

function locusTraces(locus, color, fx, fy, isDraft) {
  return locus.segments.map(({ criticality, x, y }) => ({
    type: "scatter", mode: "lines", hoverinfo: "skip", opacity: isDraft ? FAINT : 1,
    name: nameOf(locus, criticality),
    x: x.map((v) => v * fx), y: y.map((v) => v * fy),
    // With points left out a line would have corners.
    line: { ...lineStyle(locus, criticality, color), simplify: false },
  }));
}

function specialTrace(special, labels, color, fx, fy) {
  return {
    type: "scatter", mode: "markers+text", hoverinfo: "skip",
    x: special.map(({ x }) => x * fx), y: special.map(({ y }) => y * fy),
    text: labels.map(besideMarker), textposition: labels.map(({ position }) => position),
    textfont: { size: 11 * typeScale(), color: color("ink") },
    marker: { size: MARKER, color: color("ink") },
  };
}

/**
 * The names of the regions where they fit.
 * @param {{width: number, height: number}} frame of the plot in pixels
 */
function regionNames(regions, color, [fx, fy], frame) {
  if (!regions) return [];
  return regionPlaces(regions, frame).map(({ text, x, y }) => ({
    x: x * fx, y: y * fy, text: escaped(text), showarrow: false,
    font: { size: 12 * typeScale(), color: color("muted") },
  }));
}

const WIDTH = 7;
const HEIGHT = 18;
const MARGIN = 8;

/**
 * A place for the name of each region.
 * @param {object} regions the server's: `labels` row by row from the bottom, `names`
 * @param {{width: number, height: number}} frame of the plot in pixels
 * @returns {{text: string, x: number, y: number}[]} in SI units; names that do not fit are left out
 */
function regionPlaces(regions, frame) {
  const { labels, names, stable } = regions;
  const cell = [frame.width / labels[0].length, frame.height / labels.length];
  const rows = Math.ceil((HEIGHT * typeScale()) / cell[1]);
  return Object.entries(names).flatMap(([id, name]) => {
    for (const text of [name, name.replace(/^periods? /, ""), ...shorter(stable[id] ?? [])]) {
      const columns = Math.ceil((text.length * WIDTH * typeScale() + MARGIN) / cell[0]);
      const place = roomiest(labels, Number(id), columns, rows);
      if (place) return [{ text, x: middle(regions.x, place[0]), y: middle(regions.y, place[1]) }];
    }
    return [];
  });
}

/** Names of a region that take less room: its periods alone. */
function shorter(stable) {
  return stable.length > 1 ? [stable.join(" and "), stable.join("+")] : stable.map(String);
}

/** The middle of a box within a region, around which there is most of the region. */
function roomiest(labels, id, columns, rows) {
  const sums = summed(labels, id);
  const within = (left, bottom, right, top) =>
    sums[top][right] - sums[bottom][right] - sums[top][left] + sums[bottom][left];
  const [height, width] = [labels.length, labels[0].length];
  let best = null;
  let most = 0;
  for (let bottom = 0; bottom + rows <= height; bottom++) {
    for (let left = 0; left + columns <= width; left++) {
      const [right, top] = [left + columns, bottom + rows];
      if (within(left, bottom, right, top) < columns * rows) continue;
      const around = within(
        Math.max(left - columns, 0), Math.max(bottom - 2 * rows, 0),
        Math.min(right + columns, width), Math.min(top + 2 * rows, height));
      if (around > most) [most, best] = [around, [left + columns / 2, bottom + rows / 2]];
    }
  }
  return best;
}

/** How many cells of a region lie below and left of each corner. */
function summed(labels, id) {
  const sums = [new Array(labels[0].length + 1).fill(0)];
  for (const row of labels) {
    const below = sums.at(-1);
    const line = [0];
    row.forEach((label, i) => line.push(line[i] + below[i + 1] - below[i] + Number(label === id)));
    sums.push(line);
  }
  return sums;
}

/** The coordinate at a place between cells. */
function middle(centers, place) {
  const step = (centers.at(-1) - centers[0]) / (centers.length - 1);
  return centers[0] + (place - 0.5) * step;
}

class UnderPointer {
  /** The element to put on the page. */
  node = element("p", { class: "under-pointer" });
  simulated = "";
  isRingSeen = false;

  /**
   * Describe a place; null describes the simulation at the working point, if there is one.
   * quantities of both axes, their values in SI units, the plane's answer and the picture of regimes
   */
  show(place) {
    const here = this.simulated && this.isRingSeen ? `At the ring: ${this.simulated}` : "";
    this.node.textContent = place ? sentence(place) : here;
  }
}

function sentence({ x, y, at, shown, picture, point, line }) {
  if (point) {
    const others = point.count > 1 ? ` ${point.count - 1} more ${point.type} within this marker.` : "";
    return `${point.sentence}.${others} Click it.`;
  }
  const values = [x, y].map((axis, i) => `${axis.label ?? axis.name} = ${withUnit(axis, Number(at[i].toPrecision(4)))}`);
  const known = [...(line ? [line] : []), ...regimeAt(picture, at), ...regionAt(shown?.regions, at)];
  const hint = known.length < 2 ? " A click simulates there." : ""; // three lines hold no more
  return `${values.join(", ")}${known.length ? ": " : ""}${known.join("; ")}.${hint}`;
}

function regionAt(regions, at) {
  const id = regions && cellOf(regions.labels, regions.x, regions.y, at);
  if (!id) return [];
  if (!regions.known[id]) return ["not known what is stable"];
  return [regions.stable[id].length ? `stable: ${regions.names[id]}` : "neither period 1 nor 2 stable"];
}

function regimeAt(picture, at) {
  const number = picture && cellOf(picture.labels, picture.x.values, picture.y.values, at);
  return number ? [`motion from the start: ${picture.names[number - 1]}`] : [];
}

/**
 * The point of codimension two or the name of the locus at a pixel.
 * @param {(x: number, y: number) => [number, number]} pixelOf a place in SI units
 */
function meetAt(plane, pixelOf, [px, py]) {
  if (!plane) return {};
  const [nearest] = markedPoints(plane, pixelOf)
    .map((point) => ({ point, away: Math.hypot(point.at[0] - px, point.at[1] - py) })).sort((a, b) => a.away - b.away);
  if (nearest?.away < REACH) return { point: nearest.point };
  for (const locus of plane.loci) {
    for (const { criticality, x, y } of locus.segments) {
      for (let i = 0; i + 1 < x.length; i++) {
        const ends = [pixelOf(x[i], y[i]), pixelOf(x[i + 1], y[i + 1])];
        if (distance(ends, [px, py]) < REACH) return { line: nameOf(locus, criticality) };
      }
    }
  }
  return {};
}

/** The distance of a point from a line between two others. */
function distance([[ax, ay], [bx, by]], [px, py]) {
  const length = (bx - ax) ** 2 + (by - ay) ** 2;
  const share = length && ((px - ax) * (bx - ax) + (py - ay) * (by - ay)) / length;
  const inner = Math.min(Math.max(share, 0), 1);
  return Math.hypot(ax + inner * (bx - ax) - px, ay + inner * (by - ay) - py);
}

/** The label of the cell in which a place lies. */
function cellOf(labels, first, second, [x, y]) {
  return labels[nearest(second, y)][nearest(first, x)];
}

/** The number of the nearest of evenly spaced values. */
function nearest(values, value) {
  const step = (values.at(-1) - values[0]) / (values.length - 1);
  return Math.min(Math.max(Math.round((value - values[0]) / step), 0), values.length - 1);
}

const KEY_STEPS = 100;

/** Pixels within which the pointer is on a point or a line. */
const REACH = 7;

/** Pixels that the pointer may move between press and release in a click; more is a drag. */
const CLICK = 4;

/** What the ring moves by when it is dragged, over the window. */
const FINE = 0.001;

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
  /** The button that shows what a motion at the working point does. */
  simulate;
  #card;
  #session;
  #regimes;
  #simulation;
  /** What is drawn: the server's answer, or as much of it as has come. */
  #shown = null;
  /** Whether it is of what was requested last, and not of what was before. */
  #isOfAsked = false;
  #lines = new Map();
  #map = null;
  /** The pixel under the pointer, which may rest while what it points at is drawn. */
  #pointer = null;
  #schedule = redrawn(this.node, () => this.#draw());

  constructor(session, regimes, simulation) {
    this.#session = session;
    this.#regimes = regimes;
    this.#simulation = simulation;
    this.#card = new PointCard(session);
    this.simulate = button("Simulate at the ring", () => simulation.fromRest(), {
      class: "small-button", title: "Simulate from rest at the working point, the ring",
    });
    simulation.changed.subscribe(({ view, verdict }) => {
      this.pointed.simulated = view && verdict ? verdict.split(/[:;]/)[0] : "";
      this.#place();
    });
    regimes.changed.subscribe(() => this.#schedule());
    this.#point = element("button", {
      type: "button", class: "working-point", "aria-label": "Working point", hidden: true,
      title: "The working point: drag it, or move it with the arrow keys",
      on: { keydown: (event) => this.#key(event) },
    });
    this.node.append(this.#canvas, this.#draft, this.#point, this.#card.node);
    session.planeChanged.subscribe((change) => this.#changed(change));
    session.store.changed.subscribe(({ view, before }) => {
      if (view.model !== before.model || !view.plane) this.#shown = null;
      if (view.plane !== before.plane) this.#schedule();
      this.#place();
    });
    this.node.addEventListener("pointerdown", (event) => this.#grab(event));
    const point = (pixel) => {
      this.#pointer = pixel;
      this.#describe();
    };
    this.node.addEventListener("pointermove", (event) => point(pixelOf(event, this.node)));
    this.node.addEventListener("pointerleave", () => point(null));
    this.#schedule();
  }

  /** The figure as plotly's data and layout, for a file. */
  figure() {
    const named = new Set();
    const data = this.#traces(light).map((trace) => {
      const isNew = trace.mode === "lines" && !named.has(trace.name);
      if (isNew) named.add(trace.name);
      return { ...trace, showlegend: isNew };
    });
    const shades = shadesOf(this.#shown, this.#regimes.picture, light).map(({ name, tint }) => ({
      type: "scatter", mode: "markers", x: [null], y: [null], name, showlegend: true,
      marker: { symbol: "square", size: 12, color: tint, line: { color: light("rule"), width: 1 } },
    }));
    const sheet = withLegend(structuredClone(this.#canvas.layout), [...named, ...shades.map(({ name }) => name)]);
    const annotations = sheet.annotations.map((text) => ({ ...text, font: { ...text.font, color: light("muted") } }));
    return { data: [...data, ...shades], layout: { ...onWhite(sheet), annotations } };
  }

  #changed({ answer, stale = false, isSame = false, id, lines = [], loci }) {
    if (stale && !this.#session.store.isLive) this.#isOfAsked = false;
    if (isSame) this.node.classList.toggle("stale", !this.#isOfAsked);
    // A message about the view alone has no id of a request, and leaves the lines as they are.
    if (id !== undefined && id !== this.#lines.of) this.#lines = Object.assign(new Map(), { of: id });
    for (const line of lines) this.#lines.set(line.number, line);
    const shown = answer ?? (loci ? { loci, regions: null } : lines.length > 0 && draftOf([...this.#lines.values()]));
    // What belongs to other values is pale, and gives way to the first lines of what is requested.
    if (shown || stale) this.node.classList.toggle("stale", stale);
    if (stale) this.#card.hide();
    if (!shown) return;
    this.#isOfAsked = true;
    this.#shown = shown;
    this.#schedule();
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
    const color = colors();
    const sheet = mapLayout(color, { title: escaped(axisTitle(x)), range: range.x },
      { title: escaped(axisTitle(y)), range: range.y }, size);
    const shown = this.#shown;
    const { picture } = this.#regimes;
    // Names of regions would lie on what motions do there.
    sheet.annotations = picture ? [] : regionNames(shown?.regions, color, [fx, fy], this.#map.frame);
    window.Plotly.react(this.#canvas, this.#traces(color), sheet, CONFIG);
    this.legend.show(shown, picture);
    this.checked.show(shown?.checked);
    this.#draft.hidden = !shown?.isDraft;
    this.node.dataset.loci = shown?.done ? shown.loci.length : 0;
    this.#place();
  }

  #traces(color) {
    const { fx, fy } = this.#axes();
    const below = regimeTraces(this.#regimes.picture, color, [fx, fy]);
    const shown = this.#shown;
    if (!shown) return below;
    const at = (x, y) => this.#map.toPixel(x * fx, y * fy);
    const points = markedPoints(shown, at);
    const lines = shown.loci.flatMap((locus) => locus.segments)
      .map(({ x, y }) => x.map((value, i) => at(value, y[i])));
    const texts = points.map(({ type, at: place, count }) => ({ text: type, short: type, at: place, count }));
    return [
      ...regionTraces(shown.regions, color, fx, fy),
      ...below,
      ...shown.loci.flatMap((locus) => locusTraces(locus, color, fx, fy, shown.isDraft)),
      specialTrace(points, labelPlaces(texts, lines, this.#map.frame), color, fx, fy),
    ];
  }

  #place() {
    const { view } = this.#session;
    if (!view.plane || !this.#map) return;
    const { x, y, fx, fy, plane } = this.#axes();
    const values = [view.parameters[plane.x.name], view.parameters[plane.y.name]];
    const [px, py] = this.#map.toPixel(values[0] * fx, values[1] * fy);
    this.#point.hidden = !this.#map.isInside(px, py);
    this.#point.style.transform = `translate(${px}px, ${py}px)`;
    this.simulate.disabled = this.#point.hidden;
    this.pointed.isRingSeen = !this.#point.hidden;
    this.#describe();
    const text = `${x.label ?? x.name} = ${withUnit(x, values[0])}, ${y.label ?? y.name} = ${withUnit(y, values[1])}`;
    this.#point.setAttribute("aria-label", `Working point: ${text}. Arrow keys move it`);
  }

  #describe() {
    const pixel = this.#pointer;
    if (!pixel || !this.#session.view.plane || !this.#map?.isInside(...pixel)) {
      this.pointed.show(null);
      return;
    }
    const { x, y, fx, fy } = this.#axes();
    const [a, b] = this.#map.toData(...pixel);
    const met = this.#meetAt(pixel);
    this.pointed.show({ x, y, at: [a / fx, b / fy], shown: this.#shown, picture: this.#regimes.picture, ...met });
  }

  #meetAt(pixel) {
    const { fx, fy } = this.#axes();
    return meetAt(this.#shown, (x, y) => this.#map.toPixel(x * fx, y * fy), pixel);
  }

  #grab(event) {
    if (!this.#map || event.button !== 0 || !this.#session.view.plane) return;
    const at = (moved) => pixelOf(moved, this.node);
    this.#card.hide();
    if (!this.#map.isInside(...at(event))) return;
    const { point } = event.target === this.#point ? {} : this.#meetAt(at(event));
    event.preventDefault(); // the focus is set below
    if (point) {
      this.#card.show(point, this.#shown.loci.flatMap(({ special }) => special), at(event));
      return;
    }
    this.#point.focus({ preventScroll: true });
    this.node.setPointerCapture(event.pointerId);
    this.node.classList.add("dragging");
    const move = (moved) => this.#move(...at(moved), "preview");
    const end = (moved) => {
      this.node.removeEventListener("pointermove", move);
      this.node.classList.remove("dragging");
      this.#move(...at(moved), "commit");
      const [[x, y], [left, top]] = [at(moved), at(event)];
      const isClick = moved.type === "pointerup" && Math.hypot(x - left, y - top) < CLICK && event.target !== this.#point;
      if (isClick) this.#simulation.fromRest();
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
