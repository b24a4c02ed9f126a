/** A small plot in SVG: one of many beside each other, redrawn in a millisecond while a slider moves and a cursor runs through all of them, which is why they are not plotly's. */

import { element, set, svg } from "./dom.js";
import { padded, ticks } from "./plot_tools.js";
import { formatted } from "./quantities.js";

const MARGIN = { left: 46, right: 10, top: 8, bottom: 32 };

/** Widths in pixels of the ordinate's title with its distance, and of a digit beside it. */
const TITLE = 26;
const DIGIT = 6.2;

/** Pixels that the first number of the abscissa may reach below the ordinate's. */
const EDGE = 6;

/** Half the height of a band, in rows. */
const BAND = 0.32;

/**
 * @typedef {object} Line
 * @property {number[]} x
 * @property {number[]} y
 * @property {string} tint a class: `tint-1`, `tint-2`, `faint`
 * @property {string} [name] for the legend
 * @typedef {object} Picture
 * @property {{label: string, range?: [number, number]}} x
 * @property {{label: string, range?: [number, number], isLog?: boolean}} y
 * @property {Line[]} lines
 * @property {{x: number, y: number, tint: string}[]} [dots]
 * @property {{x: number[], y: number[], tint: string}[]} [clouds] thousands of dots as one element
 * @property {{x: number[], y: number[], tint: string}[]} [stems] lines from the bottom up
 * @property {{x: [number, number], row: number, tint: string}[]} [bands] bars along rows, which
 *   the ordinate names: `y.rows`
 * @property {string[]} [notes] lines of words in the upper left corner
 * @property {{x: number, text: string, isBefore?: boolean}[]} [above] words at the upper edge, the
 *   most important ones first
 */

export class SmallPlot {
  /** The element to put on the page. */
  node;
  #legend = element("span", { class: "legend" });
  #svg;
  #axes = svg("g", { class: "axes" });
  #ink = svg("g", {});
  #notes = svg("g", { class: "axes" });
  #cursors = svg("g", { class: "cursors" });
  #clip;
  #isEqual;
  #picture = null;
  #cursor = {};
  #map = null;
  #size = [0, 0];

  /**
   * @param {{isEqual?: boolean, onPoint?: (x: number) => void}} [how] isEqual: a unit is as long
   * upwards as sideways; onPoint: hears where the pointer is along x
   */
  constructor(id, title, { isEqual = false, onPoint = null } = {}) {
    this.#isEqual = isEqual;
    this.#clip = svg("rect", {});
    this.#svg = svg("svg", { class: "small-plot", role: "img", "aria-label": title },
      svg("clipPath", { id: `clip-${id}` }, this.#clip),
      this.#axes, svg("g", { "clip-path": `url(#clip-${id})` }, this.#ink, this.#cursors), this.#notes);
    this.node = element("figure", { class: "small", id: `plot-${id}` },
      element("figcaption", {}, element("span", {}, title), this.#legend), this.#svg);
    new ResizeObserver(() => {
      this.#measure();
      this.#redraw();
    }).observe(this.#svg);
    if (onPoint) {
      this.#svg.classList.add("pointable");
      const report = (event) => this.#map && onPoint(this.#map.dataX(event.offsetX));
      this.#svg.addEventListener("pointermove", report);
    }
  }

  /** The drawing and its caption, for a file. */
  get figure() {
    return { drawing: this.#svg, caption: this.node.querySelector("figcaption") };
  }

  /**
   * Show a picture.
   * @param {string} [description] for those who hear the page
   */
  draw(picture, description) {
    this.#picture = picture;
    if (description) this.#svg.setAttribute("aria-label", description);
    const names = picture.lines.filter(({ name }) => name);
    this.#legend.replaceChildren(...names.map(({ name, tint, dash }) =>
      element("span", { class: `key ${tint}${dash ? " dash" : ""}` }, name)));
    this.#redraw();
  }

  /**
   * Move the cursor: a line across, and dots.
   * @param {{x?: number, dots?: {x: number, y: number, tint: string}[]}} cursor
   */
  point(cursor) {
    this.#cursor = cursor;
    if (!this.#map) return;
    const { x, dots = [] } = cursor;
    const nodes = [...this.#cursors.children];
    const wanted = (x === undefined ? 0 : 1) + dots.length;
    while (nodes.length < wanted) nodes.push(this.#cursors.appendChild(svg("path", {})));
    while (nodes.length > wanted) nodes.pop().remove();
    if (x !== undefined) {
      const place = this.#map.x(x).toFixed(1);
      set(nodes.shift(), { d: `M${place} ${this.#map.top}V${this.#map.bottom}`, class: "across" });
    }
    dots.forEach((dot, i) => set(nodes[i], {
      d: `M${this.#map.x(dot.x).toFixed(1)} ${this.#map.y(dot.y).toFixed(1)}h0`,
      class: `dot ${dot.tint}`,
    }));
  }

  /** Ask for the size where it has changed: while a slider moves the browser would lay out the page for it. */
  #measure() {
    this.#size = [this.#svg.clientWidth, this.#svg.clientHeight];
  }

  #redraw() {
    if (!this.#size[0]) this.#measure(); // it was hidden
    const [width, height] = this.#size;
    if (!this.#picture || width < 80) return;
    this.#svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.#map = mapOf(this.#picture, width, height, this.#isEqual);
    this.#drawAxes(width, height);
    this.#drawInk();
    this.point(this.#cursor);
  }

  #drawAxes(width, height) {
    const { left, right, top, bottom, xRange, yRange, x, y } = this.#map;
    const { x: xAxis, y: yAxis } = this.#picture;
    set(this.#clip, { x: left, y: top, width: right - left, height: bottom - top });
    const [nodes, words] = [[], []];
    const text = (content, attributes) => nodes.push(svg("text", attributes, content));
    const note = (content, at, up) => words.push(svg("text", { class: "note", x: at, y: up }, content));
    const grid = [];
    const across = xAxis.ticks ?? apart(xRange, right - left);
    for (const [i, label] of labelsOf(across).entries()) {
      const value = across[i];
      grid.push(`M${x(value).toFixed(1)} ${top}V${bottom}`);
      const place = left + placed(x(value) - left, label, right - left);
      text(label, { x: place, y: bottom + 13, "text-anchor": "middle" });
    }
    const decades = yAxis.isLog;
    (yAxis.rows ?? []).forEach((name, row) =>
      text(name, { x: left - 6, y: y(row) + 4, "text-anchor": "end" }));
    const up = yAxis.rows ? [] : yTicks(yRange, top, bottom, decades);
    const labels = labelsOf(up);
    for (const [i, value] of up.entries()) {
      grid.push(`M${left} ${y.linear(value).toFixed(1)}H${right}`);
      const label = decades ? powerOfTen(value) : [labels[i]];
      nodes.push(svg("text", { x: left - 5, y: y.linear(value) + 4, "text-anchor": "end" }, ...label));
    }
    nodes.unshift(svg("path", { class: "grid", d: grid.join("") }));
    nodes.push(svg("rect", { class: "box", x: left, y: top, width: right - left, height: bottom - top }));
    text(xAxis.label, { class: "title", x: (left + right) / 2, y: height - 3, "text-anchor": "middle" });
    if (yAxis.label) {
      text(yAxis.label, {
        class: "title", transform: `translate(10 ${(top + bottom) / 2}) rotate(-90)`,
        "text-anchor": "middle",
      });
    }
    const { notes = [], above = [] } = this.#picture;
    notes.forEach((content, i) => note(content, left + 6, top + 13 * (i + 1)));
    // The first words choose first; those without room are left out.
    const taken = [];
    for (const { x: at, text: word, isBefore } of above) {
      const first = isBefore ? x(at) - 3 - word.length * DIGIT : x(at) + 3;
      const last = first + word.length * DIGIT;
      if (first < left || last > right || taken.some(([from, to]) => first < to && last > from)) continue;
      taken.push([first, last]);
      note(word, first, top + 11);
    }
    this.#axes.replaceChildren(...nodes);
    this.#notes.replaceChildren(...words);
  }

  #drawInk() {
    const { x, y, bottom } = this.#map;
    const { lines, dots = [], clouds = [], stems = [], bands = [] } = this.#picture;
    const at = (a, b) => `${x(a).toFixed(1)} ${y(b).toFixed(1)}`;
    this.#ink.replaceChildren(
      ...bands.map((band) => svg("path", {
        class: `band ${band.tint}`,
        d: `M${at(band.x[0], band.row - BAND)}H${x(band.x[1]).toFixed(1)}V${y(band.row + BAND).toFixed(1)}H${x(band.x[0]).toFixed(1)}Z`,
      })),
      ...lines.filter((line) => line.x.length > 0).map((line) => svg("path", {
        class: `line ${line.tint}${line.dash ? " dash" : ""}`,
        d: `M${line.x.map((value, i) => at(value, line.y[i])).join("L")}`,
      })),
      ...stems.map((stem) => svg("path", {
        class: `stem ${stem.tint}`,
        d: stem.x.map((value, i) => `M${at(value, stem.y[i])}V${bottom}`).join(""),
      })),
      ...dots.map((dot) => svg("path", { class: `dot ${dot.tint}`, d: `M${at(dot.x, dot.y)}h0` })),
      ...clouds.map((cloud) => svg("path", {
        class: `dot ${cloud.tint}`, d: cloud.x.map((value, i) => `M${at(value, cloud.y[i])}h0`).join(""),
      })),
    );
  }
}

function mapOf({ x, y, lines, dots = [], clouds = [], stems = [] }, width, height, isEqual) {
  let left = MARGIN.left;
  const right = width - MARGIN.right;
  const top = MARGIN.top;
  const bottom = height - MARGIN.bottom;
  const all = [...lines, ...stems, ...clouds];
  const scale = y.isLog ? (value) => Math.log10(Math.max(value, 1e-300)) : (value) => value;
  let xRange = x.range ?? padded([...all.flatMap((line) => line.x), ...dots.map((dot) => dot.x)]);
  let yRange = y.range ??
    padded([...all.flatMap((line) => line.y), ...dots.map((dot) => dot.y)].map(scale), 0.08);
  // Long numbers need room beside the title, and so do names.
  const beside = y.rows ?? labelsOf(yTicks(yRange, top, bottom, y.isLog));
  const longest = Math.max(...beside.map((text) => text.length));
  if (!y.isLog) left = Math.max(left, (y.rows ? 10 : TITLE) + DIGIT * longest);
  if (isEqual) [xRange, yRange] = equal(xRange, yRange, right - left, bottom - top);
  const linear = (value) => bottom - ((value - yRange[0]) / (yRange[1] - yRange[0])) * (bottom - top);
  return {
    left, right, top, bottom, xRange, yRange,
    x: (value) => left + ((value - xRange[0]) / (xRange[1] - xRange[0])) * (right - left),
    y: Object.assign((value) => linear(scale(value)), { linear }),
    dataX: (pixel) => xRange[0] + ((pixel - left) / (right - left)) * (xRange[1] - xRange[0]),
  };
}

/** Evenly spaced numbers as text, with as many digits as distinguish neighbors. */
function labelsOf(values) {
  const largest = Math.max(...values.map(Math.abs));
  const digits = values.length > 1 ? Math.ceil(Math.log10(largest / (values[1] - values[0]))) + 2 : 0;
  return values.map((value) => formatted(value, Math.min(Math.max(digits, 4), 12)));
}

/** Where a label is centered: at an edge it would be cut, or overlap the lowest number of the ordinate. */
function placed(x, label, width) {
  const half = (label.length * DIGIT) / 2;
  return Math.min(Math.max(x, half - EDGE), width + MARGIN.right - half);
}

/** Round numbers across a width, as many as have room for their digits. */
function apart(range, width) {
  const fits = (values) => {
    const labels = labelsOf(values);
    const places = labels.map((label, i) => placed(((values[i] - range[0]) / (range[1] - range[0])) * width, label, width));
    const isApart = (label, i) => i === 0 || places[i] - places[i - 1] >= ((labels[i - 1].length + label.length) / 2 + 1) * DIGIT;
    return labels.every(isApart);
  };
  let count = Math.max(width / 55, 3);
  let values = atLeastTwo(range, count);
  while (values.length > 2 && !fits(values)) {
    const fewer = ticks(range, (count /= 1.3));
    // One alone does not show the scale.
    values = fewer.length > 1 ? fewer : [values[0], values.at(-1)];
  }
  if (values.length < 2 || fits(values)) return values;
  const finer = ticks(range, 12); // of which the outer two are as far apart as can be
  return [finer[0], finer.at(-1)];
}

function yTicks(range, top, bottom, isLog) {
  const count = Math.max((bottom - top) / (isLog ? 22 : 30), 2);
  return isLog ? ticks(range, count).filter(Number.isInteger) : atLeastTwo(range, count);
}

/** Round numbers that divide a range, about so many: one alone does not show the scale. */
function atLeastTwo(range, count) {
  const values = ticks(range, count);
  return values.length > 1 ? values : ticks(range, 2 * count);
}

/** Widen one of two ranges until a unit of both is equally long. */
function equal(x, y, width, height) {
  const unit = Math.max((x[1] - x[0]) / width, (y[1] - y[0]) / height);
  const around = ([low, high], size) => [(low + high - size) / 2, (low + high + size) / 2];
  return [around(x, unit * width), around(y, unit * height)];
}

function powerOfTen(exponent) {
  const raised = svg("tspan", { dy: "-4", "font-size": "80%" }, formatted(exponent));
  return ["10", raised];
}
