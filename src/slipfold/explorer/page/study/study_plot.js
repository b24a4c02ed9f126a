/** What a study found over one parameter as dots, over two as a map; a click opens a case. */

import { padded } from "../plots/axis_range.js";
import { escaped } from "../diagram/diagram_traces.js";
import { element } from "../controls/dom.js";
import { CONFIG, layout, mapping } from "../plots/plot_frame.js";
import { axisTitle, display, withUnit } from "../parameters/quantities.js";
import { inside } from "../session/view.js";
import { colouring } from "./study_colours.js";
import { LIGHT, colours, themeChanged } from "../style/theme.js";

const REACH = 14;
const DOT = 9;

/** Pixels between a case and what is said of it. */
const AWAY = 6;

/** Pixels that a file has besides for what explains its colours, for each letter of a word there, and for a title. */
const BAR = 90;
const LETTER = 7;
const TITLE = 26;

export class StudyPlot {
  /** The element to put on the page. */
  node = element("div", { class: "plot study-plot", tabindex: "0", role: "group" });
  #canvas = element("div", { class: "plot-canvas" });
  #chosen = element("div", { class: "cell chosen", hidden: true });
  #hovered = element("div", { class: "cell hovered", hidden: true });
  #tip = element("div", { class: "tip", hidden: true });
  #study;
  #choose;
  #picture = null;
  #drawn = null;
  #number = -1;
  #boxes = [];
  #map = null;
  #frame = 0;

  /**
   * @param {import("./study.js").Study} study
   * @param {(number: number) => void} choose hears of the case that is to be opened
   */
  constructor(study, choose) {
    this.#study = study;
    this.#choose = choose;
    this.node.append(this.#canvas, this.#chosen, this.#hovered, this.#tip);
    this.node.setAttribute("aria-label", `${study.title}. Arrow keys open the case beside the one that is shown`);
    themeChanged.subscribe(() => this.#schedule());
    new ResizeObserver(() => this.#schedule()).observe(this.node);
    this.node.addEventListener("pointermove", (event) => this.#hover(this.#under(event)));
    this.node.addEventListener("pointerleave", () => this.#hover(null));
    this.node.addEventListener("click", (event) => this.#open(this.#under(event)));
    this.node.addEventListener("keydown", (event) => this.#key(event));
  }

  /** @param {{x: string, y: string|null, at: Record<string, number>, quantity: object}} picture */
  show(picture) {
    this.#picture = picture;
    this.#schedule();
  }

  /** Mark a case; -1 is none. */
  mark(number) {
    this.#number = number;
    this.#put(this.#chosen, this.#boxes.find((box) => box.number === number));
  }

  /** What is drawn, with its colours explained: for a file. */
  figure() {
    const { quantity, y } = this.#picture;
    const { trace, sheet, colour_of: { words } } = this.#drawn;
    const bar = {
      title: { text: escaped(axisTitle(quantity)), side: words ? "top" : "right" }, outlinewidth: 0, thickness: 14,
      ...(words ? { tickvals: words.map((_, i) => i), ticktext: words.map(({ text }) => escaped(text)) } : {}),
    };
    const shown = { showscale: true, colorbar: bar };
    const isMap = trace.type === "heatmap";
    const told = isMap ? { ...trace, ...shown } : { ...trace, marker: { ...trace.marker, ...(y === null ? {} : shown) } };
    const { margin, width, ...rest } = structuredClone(sheet);
    for (const axis of [rest.xaxis, rest.yaxis]) {
      Object.assign(axis, { gridcolor: LIGHT.grid, linecolor: LIGHT.axis, tickcolor: LIGHT.axis });
    }
    const room = y === null ? 0 : BAR + (words ? LETTER * Math.max(0, ...words.map(({ text }) => text.length)) : 0);
    return {
      data: [told],
      layout: {
        ...rest, paper_bgcolor: "#ffffff", plot_bgcolor: "#ffffff", font: { ...rest.font, color: LIGHT.ink },
        width: width + room, margin: { ...margin, r: margin.r + room, t: margin.t + TITLE },
        height: sheet.height + TITLE,
        title: { text: escaped(this.#study.title), font: { size: 13 }, x: 0.5 },
      },
    };
  }

  #schedule() {
    if (this.#frame) return;
    this.#frame = requestAnimationFrame(() => {
      this.#frame = 0;
      this.#draw();
    });
  }

  #draw() {
    if (!this.#picture || this.node.clientWidth === 0) return;
    const { x, y, at, quantity } = this.#picture;
    const cases = this.#study.seen(x, y, at);
    const colour = colours();
    const colour_of = colouring(quantity, cases, colour);
    const size = [this.node.clientWidth, this.node.clientHeight];
    const drawn = y === null ? this.#overOne(cases, colour_of, colour)
      : this.#study.isGrid ? this.#asMap(cases, colour_of) : this.#asDots(cases, colour_of, colour);
    const titled = (name) => escaped(axisTitle(this.#study.parameter(name)));
    const sheet = layout(colour, { title: titled(x), range: drawn.x },
      { title: y === null ? escaped(axisTitle(quantity)) : titled(y), range: drawn.y }, size);
    sheet.dragmode = false;
    sheet.xaxis.fixedrange = sheet.yaxis.fixedrange = true;
    if (y !== null) sheet.xaxis.showgrid = sheet.yaxis.showgrid = !this.#study.isGrid;
    if (y === null && colour_of.words) {
      Object.assign(sheet.yaxis, {
        tickvals: colour_of.words.map((_, i) => i), ticktext: colour_of.words.map(({ text }) => escaped(text)),
      });
    }
    this.#map = mapping(size, drawn.x, drawn.y);
    this.#drawn = { trace: drawn.trace, sheet, colour_of };
    window.Plotly.react(this.#canvas, [drawn.trace], sheet, CONFIG);
    this.#boxes = drawn.boxes(this.#map.toPixel);
    this.mark(this.#number);
    this.node.dataset.cases = String(this.#boxes.length);
  }

  /** Values of a parameter as they are shown. */
  #shown(name) {
    const parameter = this.#study.parameter(name);
    return parameter.values.map((value) => value * display(parameter).factor);
  }

  #overOne(cases, { numbers, words }, colour) {
    const across = this.#shown(this.#picture.x);
    const known = cases.filter((i) => numbers[i] !== null).sort((a, b) => across[a] - across[b]);
    const x = known.map((i) => across[i]);
    const y = known.map((i) => numbers[i]);
    const isLine = this.#study.isGrid && !words;
    return {
      x: padded(cases.map((i) => across[i]), 0.03),
      y: words ? [-0.5, words.length - 0.5] : padded(y),
      trace: {
        type: "scatter", mode: isLine ? "lines+markers" : "markers", x, y, hoverinfo: "skip",
        line: { color: colour("live"), width: 1.5 }, marker: { color: colour("live"), size: 6 },
      },
      boxes: dotsAt(known, x, y),
    };
  }

  #asDots(cases, { numbers, range, scale }, colour) {
    const { x: first, y: second } = this.#picture;
    const [across, up] = [this.#shown(first), this.#shown(second)];
    const x = cases.map((i) => across[i]);
    const y = cases.map((i) => up[i]);
    const isKnown = (i) => numbers[i] !== null;
    return {
      x: padded(x), y: padded(y),
      trace: {
        type: "scatter", mode: "markers", x, y, hoverinfo: "skip",
        marker: {
          size: DOT, color: cases.map((i) => numbers[i] ?? range[0]), cmin: range[0], cmax: range[1],
          colorscale: scale, showscale: false, line: { color: colour("muted"), width: 0.8 },
          symbol: cases.map((i) => (isKnown(i) ? "circle" : "x-thin-open")),
        },
      },
      boxes: dotsAt(cases, x, y),
    };
  }

  #asMap(cases, { numbers, range, scale }) {
    const { x: first, y: second } = this.#picture;
    const places = [first, second].map((name) => {
      const shown = this.#shown(name);
      const values = [...new Set(cases.map((i) => shown[i]))].sort((a, b) => a - b);
      const index = new Map(values.map((value, i) => [value, i]));
      return { edges: edgesOf(values), of: (i) => index.get(shown[i]) };
    });
    const [across, up] = places;
    const z = up.edges.slice(1).map(() => across.edges.slice(1).map(() => null));
    for (const i of cases) z[up.of(i)][across.of(i)] = numbers[i];
    const ends = ({ edges }) => [edges[0], edges.at(-1)];
    return {
      x: ends(across), y: ends(up),
      trace: {
        type: "heatmap", x: across.edges, y: up.edges, z, zmin: range[0], zmax: range[1], colorscale: scale,
        showscale: false, hoverinfo: "skip",
      },
      boxes: (toPixel) => cases.map((number) => {
        const [column, row] = [across.of(number), up.of(number)];
        const [left, top] = toPixel(across.edges[column], up.edges[row + 1]);
        const [right, bottom] = toPixel(across.edges[column + 1], up.edges[row]);
        return { number, left, top, right, bottom };
      }),
    };
  }

  #under(event) {
    if (!this.#map) return null;
    const frame = this.node.getBoundingClientRect();
    const [x, y] = [event.clientX - frame.left, event.clientY - frame.top];
    if (!this.#map.isInside(x, y)) return null;
    const away = ({ left, top, right, bottom }) =>
      Math.hypot(Math.max(left - x, 0, x - right), Math.max(top - y, 0, y - bottom));
    const [nearest] = [...this.#boxes].sort((a, b) => away(a) - away(b));
    return nearest && away(nearest) <= REACH ? nearest : null;
  }

  #hover(box) {
    this.#put(this.#hovered, box);
    this.#tip.hidden = !box;
    this.node.classList.toggle("on-case", Boolean(box));
    if (!box) return;
    this.#tip.textContent = this.#described(box.number);
    const { clientWidth: width, clientHeight: height } = this.node;
    const { offsetWidth, offsetHeight } = this.#tip;
    const isRight = box.left + box.right > width;
    const isLow = box.top + box.bottom > height;
    const x = isRight ? box.left - offsetWidth - AWAY : box.right + AWAY;
    const y = isLow ? box.top - offsetHeight - AWAY : box.bottom + AWAY;
    this.#tip.style.transform =
      `translate(${inside(x, [0, width - offsetWidth])}px, ${inside(y, [0, height - offsetHeight])}px)`;
  }

  #described(number) {
    const given = this.#study.parameters.map((item) => `${item.label} = ${withUnit(item, item.values[number])}`);
    const reason = this.#study.reasons[number];
    const found = reason ? [wrapped(reason)] : this.#study.quantities
      .filter(({ values }) => values[number] !== null)
      .map((item) => `${item.name}: ${item.isText ? item.values[number] : withUnit(item, item.values[number])}`);
    return [given.join(", "), ...found].join("\n");
  }

  #open(box) {
    if (box) this.#choose(box.number);
  }

  /** Open what is nearest in a direction. */
  #key(event) {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (!step || this.#boxes.length === 0) return;
    event.preventDefault();
    const middle = ({ left, right, top, bottom }) => [(left + right) / 2, (top + bottom) / 2];
    const here = this.#boxes.find((box) => box.number === this.#number);
    if (!here) return void this.#open(this.#boxes[0]);
    const [x, y] = middle(here);
    const ahead = this.#boxes.map((box) => {
      const [dx, dy] = [middle(box)[0] - x, middle(box)[1] - y];
      const along = dx * step[0] + dy * step[1];
      return { box, along, cost: along + 3 * Math.abs(dx * step[1] + dy * step[0]) };
    }).filter(({ along }) => along > 1).sort((a, b) => a.cost - b.cost);
    this.#open(ahead[0]?.box);
  }

  #put(mark, box) {
    mark.hidden = !box;
    if (!box) return;
    const { left, top, right, bottom } = box;
    mark.classList.toggle("dot", left === right);
    const room = left === right ? DOT : 0;
    mark.style.transform = `translate(${left - room}px, ${top - room}px)`;
    mark.style.width = `${right - left + 2 * room}px`;
    mark.style.height = `${bottom - top + 2 * room}px`;
  }
}

function dotsAt(numbers, x, y) {
  return (toPixel) => numbers.map((number, i) => {
    const [left, top] = toPixel(x[i], y[i]);
    return { number, left, top, right: left, bottom: top };
  });
}

/** Edges of cells halfway between values. */
function edgesOf(values) {
  const inner = values.slice(1).map((value, i) => (value + values[i]) / 2);
  if (inner.length === 0) return [values[0] - 0.5 * (Math.abs(values[0]) || 1), values[0] + 0.5 * (Math.abs(values[0]) || 1)];
  return [2 * values[0] - inner[0], ...inner, 2 * values.at(-1) - inner.at(-1)];
}

/** A sentence in lines that fit into a tip. */
function wrapped(sentence) {
  return sentence.replace(/(.{1,48})(\s+|$)/g, "$1\n").trimEnd();
}
