/** A study: its cases, colors, plot and panel. */

import { escaped } from "./diagram_data.js";
import { Choice, element } from "./dom.js";
import { CONFIG, mapLayout, mapping, onWhite, padded, pixelOf, redrawn } from "./plot_tools.js";
import { axisTitle, display, formatted, optionOf, withUnit } from "./quantities.js";
import { wrapped } from "./svg_file.js";
import { colors, themeChanged } from "./theme.js";
import { initialView, inside } from "./view.js";

/** Plasma, as in the package's figures. */
const PLASMA = [
  "#0d0887", "#46039f", "#7201a8", "#9c179e", "#bd3786", "#d8576b", "#ed7953", "#fb9f3a", "#fdca26", "#f0f921",
];

/** Names in the style sheet of the colors of words. */
const WORDS = ["live", "pin-3", "pin-5", "pin-1", "pin-6", "pin-2", "pin-4", "simulation"];

/** The scale of numbers as a style sheet writes it. */
const GRADIENT = `linear-gradient(to right, ${PLASMA.join(", ")})`;

/**
 * Numbers, as they are shown, colors and keys of a quantity.
 * @param {number[]} cases that are seen
 * @returns {{numbers: (number|null)[], range: [number, number], scale: [number, string][],
 * words: {text: string, color: string}[]|null, ends: [string, string]|null}}
 */
function coloring(quantity, cases, color) {
  const { isText, values: found } = quantity;
  if (!isText) {
    const { factor } = display(quantity);
    const values = found.map((value) => (value === null ? null : value * factor));
    const known = cases.map((i) => values[i]).filter((value) => value !== null);
    const [low, high] = known.length ? [Math.min(...known), Math.max(...known)] : [0, 1];
    return {
      numbers: values, range: low < high ? [low, high] : [low - 0.5, high + 0.5], words: null,
      scale: PLASMA.map((tint, i) => [i / (PLASMA.length - 1), tint]),
      ends: known.length ? [formatted(low), formatted(high)] : null,
    };
  }
  // A word has one color whatever part of the study is seen.
  const texts = [...new Set(found.filter((value) => value !== null))].sort();
  const words = texts.map((text, i) => ({ text, color: color(WORDS[i % WORDS.length]) }));
  const scale = words.flatMap(({ color: tint }, i) => [[i / words.length, tint], [(i + 1) / words.length, tint]]);
  return {
    numbers: found.map((value) => (value === null ? null : texts.indexOf(value))), words, ends: null,
    range: [-0.5, Math.max(texts.length, 1) - 0.5], scale: words.length ? scale : [[0, PLASMA[0]], [1, PLASMA[0]]],
  };
}

export class Study {
  /** @param {object} answer the server's answer */
  constructor(answer) {
    Object.assign(this, answer);
    this.count = answer.reasons.length;
  }

  /** All cases as the rows of a spreadsheet, in SI units: as `to_csv` has them. */
  table() {
    const columns = [...this.parameters, ...this.quantities];
    const heads = columns.map(({ name, unit }) => (unit ? `${name} (${unit})` : name));
    const rows = this.reasons.map((reason, i) => [i, ...columns.map(({ values }) => values[i] ?? ""), reason]);
    return [["case", ...heads, "failed"], ...rows].map((row) => `${row.map(cell).join(",")}\n`).join("");
  }

  /** A parameter by name. */
  parameter(name) {
    return this.parameters.find((item) => item.name === name);
  }

  /** All values of a parameter, each once. */
  axis(name) {
    return [...new Set(this.parameter(name).values)].sort((a, b) => a - b);
  }

  /** The cases that a picture shows: of a grid those at some values of the parameters that it does not. */
  seen(x, y, at) {
    const fixed = this.isGrid ? this.parameters.filter(({ name }) => name !== x && name !== y) : [];
    return [...Array(this.count).keys()].filter((i) => fixed.every(({ name, values }) => values[i] === at[name]));
  }

  /** The case that a view shows, or -1. */
  shownBy({ model, parameters }) {
    if (model !== this.model) return -1;
    // An address has twelve digits of a value.
    const isSame = (a, b) => Math.abs(a - b) <= 1e-10 * Math.max(Math.abs(a), Math.abs(b));
    return this.reasons.findIndex((_, i) =>
      this.parameters.every(({ name, values }) => isSame(values[i], parameters[name])));
  }

  /** The view of a case: what was computed of it, as far as the page shows that. */
  viewOf(number, view, models) {
    const usual = initialView(models.find(({ name }) => name === this.model));
    const base = view.model === this.model ? view : usual;
    const own = Object.fromEntries(this.parameters.map(({ name, values }) => [name, values[number]]));
    const vary = this.vary ?? base.vary;
    const ends = this.span ?? base.span;
    const span = vary in own ? [Math.min(...ends, own[vary]), Math.max(...ends, own[vary])] : ends;
    // Where something was found along the diagram, that is what is looked at.
    const found = this.quantities.find(({ name }) => name === "threshold")?.values[number];
    const value = inside(own[vary] ?? found ?? base.parameters[vary], span);
    const parameters = { ...usual.parameters, ...own, [vary]: value };
    return { ...base, vary, span, parameters, at: null, zoom: null };
  }
}

/** What a cell of a spreadsheet holds. */
function cell(value) {
  const text = String(value);
  return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

const REACH = 14;
const DOT = 9;

/** Pixels between a case and its tooltip, and letters of a line of that. */
const AWAY = 6;
const TIP = 48;

/** Pixels that a file has besides for its color bar, for each letter of a word there, and for a title. */
const BAR = 90;
const LETTER = 7;
const TITLE = 26;

class StudyPlot {
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
  #schedule = redrawn(this.node, () => this.#draw());

  /** @param {(number: number) => void} choose hears of the case that is to be opened */
  constructor(study, choose) {
    this.#study = study;
    this.#choose = choose;
    this.node.append(this.#canvas, this.#chosen, this.#hovered, this.#tip);
    this.node.setAttribute("aria-label", `${study.title}. Arrow keys open the case beside the one that is shown`);
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

  /** What is drawn, with its colors explained: for a file. */
  figure() {
    const { quantity, y } = this.#picture;
    const { trace, sheet, color_of: { words } } = this.#drawn;
    const bar = {
      title: { text: escaped(axisTitle(quantity)), side: words ? "top" : "right" }, outlinewidth: 0, thickness: 14,
      ...(words ? { tickvals: words.map((_, i) => i), ticktext: words.map(({ text }) => escaped(text)) } : {}),
    };
    const shown = { showscale: true, colorbar: bar };
    const isMap = trace.type === "heatmap";
    const withBar = isMap ? { ...trace, ...shown } : { ...trace, marker: { ...trace.marker, ...(y === null ? {} : shown) } };
    const { margin, width, ...rest } = onWhite(structuredClone(sheet));
    const room = y === null ? 0 : BAR + (words ? LETTER * Math.max(0, ...words.map(({ text }) => text.length)) : 0);
    return {
      data: [withBar],
      layout: {
        ...rest, width: width + room, margin: { ...margin, r: margin.r + room, t: margin.t + TITLE },
        height: sheet.height + TITLE,
        title: { text: escaped(this.#study.title), font: { size: 13 }, x: 0.5 },
      },
    };
  }

  #draw() {
    if (!this.#picture || this.node.clientWidth === 0) return;
    const { x, y, at, quantity } = this.#picture;
    const cases = this.#study.seen(x, y, at);
    const color = colors();
    const color_of = coloring(quantity, cases, color);
    const size = [this.node.clientWidth, this.node.clientHeight];
    const drawn = y === null ? this.#overOne(cases, color_of, color)
      : this.#study.isGrid ? this.#asMap(cases, color_of) : this.#asDots(cases, color_of, color);
    const titled = (name) => escaped(axisTitle(this.#study.parameter(name)));
    const sheet = mapLayout(color, { title: titled(x), range: drawn.x },
      { title: y === null ? escaped(axisTitle(quantity)) : titled(y), range: drawn.y }, size);
    if (y === null || !this.#study.isGrid) sheet.xaxis.showgrid = sheet.yaxis.showgrid = true;
    if (y === null && color_of.words) {
      Object.assign(sheet.yaxis, {
        tickvals: color_of.words.map((_, i) => i), ticktext: color_of.words.map(({ text }) => escaped(text)),
      });
    }
    this.#map = mapping(size, drawn.x, drawn.y);
    this.#drawn = { trace: drawn.trace, sheet, color_of };
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

  #overOne(cases, { numbers, words }, color) {
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
        line: { color: color("live"), width: 1.5 }, marker: { color: color("live"), size: 6 },
      },
      boxes: dotsAt(known, x, y),
    };
  }

  #asDots(cases, { numbers, range, scale }, color) {
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
          colorscale: scale, showscale: false, line: { color: color("muted"), width: 0.8 },
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
    const [x, y] = pixelOf(event, this.node);
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
    const found = reason ? wrapped(reason, TIP) : this.#study.quantities
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

export class StudyPanel {
  /** What stands beside the heading, and the elements below it. */
  title;
  nodes;
  #study;
  #picture;
  #plot;
  #quantity;
  #axes;
  #fixed = element("span", { class: "study-fixed" });
  #legend = element("div", { class: "study-legend" });

  constructor(session, study) {
    this.#study = study;
    const [first, second = null] = study.parameters.map(({ name }) => name);
    const at = Object.fromEntries(study.parameters.map(({ name }) => [name, study.axis(name)[0]]));
    const quantity = study.quantities.find(({ isText }) => !isText) ?? study.quantities[0];
    this.#picture = { x: first, y: second, at, quantity };
    this.title = element("p", { class: "orbit-title", title: study.title }, study.title);
    this.#plot = new StudyPlot(study, (number) =>
      session.store.commit(study.viewOf(number, session.view, session.models)));
    this.#quantity = new Choice("Draw", (name) =>
      this.#become({ quantity: study.quantities.find((item) => item.name === name) }));
    this.#axes = ["x", "y"].map((axis, i) => new Choice(["over", "and"][i], (name) => this.#turn(axis, name)));
    const controls = element("div", { class: "sentence" }, this.#quantity.node,
      ...this.#axes.slice(0, second === null ? 1 : 2).map(({ node }) => node), this.#fixed);
    this.nodes = [controls, this.#plot.node, this.#legend];
    session.store.changed.subscribe(({ view }) => this.#plot.mark(study.shownBy(view)));
    themeChanged.subscribe(() => this.#showLegend());
    this.#become({});
    this.#plot.mark(study.shownBy(session.view));
  }

  /** What is drawn, for a file. */
  figure() {
    return this.#plot.figure();
  }

  #turn(axis, name) {
    const { x, y } = this.#picture;
    const other = axis === "x" ? "y" : "x";
    const isSwap = { x, y }[other] === name;
    this.#become({ [axis]: name, ...(isSwap ? { [other]: { x, y }[axis] } : {}) });
  }

  #become(changes) {
    this.#picture = { ...this.#picture, ...changes };
    const { x, y, quantity } = this.#picture;
    this.#quantity.show(this.#study.quantities.map(optionOf), quantity.name);
    this.#axes.forEach((choice, i) => choice.show(this.#study.parameters.map(optionOf), [x, y][i]));
    this.#showFixed();
    this.#showLegend();
    this.#plot.show(this.#picture);
  }

  /** Values of the parameters of a grid that are on no axis. */
  #showFixed() {
    const { x, y, at } = this.#picture;
    const others = this.#study.isGrid ? this.#study.parameters.filter(({ name }) => name !== x && name !== y) : [];
    this.#fixed.replaceChildren(...others.map((parameter) => {
      const { name, label } = parameter;
      const values = this.#study.axis(name);
      const choice = new Choice(`at ${label} =`, (index) =>
        this.#become({ at: { ...this.#picture.at, [name]: values[Number(index)] } }));
      choice.show(values.map((value, i) => ({ value: String(i), text: withUnit(parameter, value) })),
        String(values.indexOf(at[name])));
      return choice.node;
    }));
  }

  #showLegend() {
    const { x, y, at, quantity } = this.#picture;
    const { words, ends } = coloring(quantity, this.#study.seen(x, y, at), colors());
    const title = element("span", { title: quantity.doc }, axisTitle(quantity));
    if (y === null) this.#legend.replaceChildren(element("span", {}, quantity.doc));
    else if (words) {
      this.#legend.replaceChildren(title, ...words.map(({ text, color }) => element("span", { class: "word" },
        element("span", { class: "shade", style: `background: ${color}` }), text)));
    } else if (ends) {
      this.#legend.replaceChildren(title, element("span", {}, ends[0]),
        element("span", { class: "scale", style: `background: ${GRADIENT}` }), element("span", {}, ends[1]),
        element("span", { class: "meaning-of" }, quantity.doc));
    } else this.#legend.replaceChildren(element("span", {}, `There is no ${quantity.name} of these cases.`));
  }
}
