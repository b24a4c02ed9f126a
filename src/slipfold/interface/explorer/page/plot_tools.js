/** What plots share: round steps, axes, the frame, where labels stand. */

import { element } from "./dom.js";
import { light, themeChanged, typeScale } from "./theme.js";

const MANTISSAS = [1, 2, 5, 10];

/** The step of one, two or five units of a decimal place that is nearest to a share of a range. */
export function roundStep(range, share) {
  const wanted = Math.abs(range) * share;
  if (!(wanted > 0)) return 0;
  const power = 10 ** Math.floor(Math.log10(wanted));
  const gap = (mantissa) => Math.abs(Math.log((mantissa * power) / wanted));
  return cleaned(MANTISSAS.reduce((best, next) => (gap(next) < gap(best) ? next : best)) * power);
}

/** The multiple of a step that is nearest to a value. */
export function snapped(value, step) {
  return step > 0 ? cleaned(Math.round(value / step) * step) : value;
}

/**
 * A value some steps on: first to the next multiple of the step.
 * @param {number} count of steps; below zero downwards
 */
export function stepped(value, step, count) {
  if (!(step > 0)) return value;
  const place = value / step;
  const near = Math.round(place);
  // What is a multiple but for rounding counts as one.
  const isMultiple = Math.abs(place - near) < 1e-6 * Math.max(Math.abs(place), 1);
  const start = isMultiple ? near : count > 0 ? Math.floor(place) : Math.ceil(place);
  return cleaned((start + count) * step);
}

/** Without the last bit's trace. */
function cleaned(value) {
  return Number(value.toPrecision(12));
}

/** Range over size below which numbers are the same. */
const NOISE = 1e-9;

/** Size below which a number is zero. */
const NOTHING = 1e-13;

/** Whether numbers from the least to the largest differ by no more than rounding does. */
export function areSame(low, high) {
  const largest = Math.max(Math.abs(low), Math.abs(high));
  return largest < NOTHING || high - low <= NOISE * largest;
}

/**
 * Least and largest of some numbers with a margin on each side.
 * @param {number} [margin] as a share of the range
 */
export function padded(values, margin = 0.06) {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  if (!Number.isFinite(low)) return [0, 1];
  // What does not move but for rounding is shown as a straight line, not as noise.
  const largest = Math.max(Math.abs(low), Math.abs(high));
  if (largest < NOTHING) return [-1, 1];
  const size = areSame(low, high) ? largest : high - low;
  return [low - margin * size, high + margin * size];
}

/** Whether a range shows all of another and is not much too large for it. */
export function fits(range, wanted) {
  const size = range[1] - range[0];
  return covers(range, wanted) && wanted[1] - wanted[0] > 0.55 * size;
}

/** Whether a range shows all of another but its margins. */
export function covers([low, high], [a, b]) {
  const slack = 0.05 * (b - a);
  return low <= a + slack && high >= b - slack;
}

/**
 * Round numbers that divide a range.
 * @param {number} count about how many
 */
export function ticks([low, high], count) {
  const step = stepAbove((high - low) / count);
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: Math.max(last - first + 1, 0) }, (_, i) =>
    Number(((first + i) * step).toPrecision(12)),
  );
}

function stepAbove(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return power * ([1, 2, 2.5, 5, 10].find((step) => step * power >= least * (1 - 1e-9)) ?? 10);
}

/** Pixels that a digit of a label takes, and the title beside the labels with its distances. */
const DIGIT = 8;
const TITLE = 34;

/** Characters for which there is always room, so that most axes begin at one place. */
const USUAL = 5;

/** Characters between the labels of an abscissa. */
const BETWEEN = 3;

/** Margins of a plot in pixels, with room for the numbers of its ordinate: they grow with the type in them. */
function margins(y) {
  const scale = typeScale();
  const l = TITLE + DIGIT * Math.max(longest(y), USUAL);
  return { l: l * scale, r: 18, t: 14, b: 46 * scale };
}

/** Characters of the longest label that plotly writes along a range. */
function longest([low, high]) {
  const step = stepAbove(Math.abs(high - low) / mostTicks());
  const largest = Math.max(Math.abs(low), Math.abs(high));
  const power = Math.floor(Math.log10(largest) + 0.01);
  const raised = Math.abs(power) > LEAST_POWER ? power : 0;
  const decimals = Math.max(raised - Math.floor(Math.log10(step) + 1e-9), 0);
  const whole = Math.max(power - raised, 0) + 1;
  return (Math.min(low, high) < 0) + whole + (decimals && decimals + 1) + (raised && EXPONENT);
}

/** Labels of an axis at most: fewer of large type, which would be turned on end. */
function mostTicks() {
  return Math.round(7 / typeScale());
}

/** The least power of ten that is written as one, and the characters that it takes. */
const LEAST_POWER = 3;
const EXPONENT = 4;

export const CONFIG = {
  displayModeBar: false,
  doubleClick: false,
  responsive: false,
  scrollZoom: false,
  showTips: false,
};

/**
 * Execute plotly.js, once. That takes as long as the server needs for a curve: it comes after the first requests, which
 * it would hold up.
 */
export function loadPlotly() {
  if (arrived === null) return;
  document.head.append(element("script", { src: "/plotly.min.js", on: { load: arrived } }));
  arrived = null;
}

let arrived;

/** Settled when plotly.js can draw. */
export const plotly = new Promise((resolve) => { arrived = resolve; });

/**
 * A function that draws at the next opportunity, once whatever number of times it was called: by itself
 * for another theme, or another size of an element.
 */
export function redrawn(node, draw) {
  let frame = 0;
  const schedule = () => {
    frame ||= requestAnimationFrame(async () => {
      await plotly;
      frame = 0;
      draw();
    });
  };
  themeChanged.subscribe(schedule);
  new ResizeObserver(schedule).observe(node);
  return schedule;
}

/** Where the pointer is within an element, in pixels. */
export function pixelOf({ clientX, clientY }, node) {
  const { left, top } = node.getBoundingClientRect();
  return [clientX - left, clientY - top];
}

/** A layout of a map, which is neither zoomed nor crossed by a grid. */
export function mapLayout(color, x, y, size) {
  const sheet = layout(color, x, y, size);
  for (const ruler of [sheet.xaxis, sheet.yaxis]) Object.assign(ruler, { showgrid: false, fixedrange: true });
  return { ...sheet, dragmode: false };
}

/** A layout for a file: on white. */
export function onWhite(sheet) {
  const rules = { gridcolor: light("grid"), linecolor: light("axis"), tickcolor: light("axis") };
  return {
    ...sheet, paper_bgcolor: "#ffffff", plot_bgcolor: "#ffffff", font: { ...sheet.font, color: light("ink") },
    xaxis: { ...sheet.xaxis, ...rules }, yaxis: { ...sheet.yaxis, ...rules },
  };
}

/**
 * A layout in the page's style.
 * @param {(name: string) => string} color from `colors()`
 * @param {[number, number]} size in pixels
 */
export function layout(color, x, y, [width, height]) {
  return {
    width,
    height,
    margin: margins(y.range),
    paper_bgcolor: "rgba(0,0,0,0)",
    plot_bgcolor: "rgba(0,0,0,0)",
    font: { family: "system-ui, sans-serif", size: 13 * typeScale(), color: color("ink") },
    showlegend: false,
    hovermode: false,
    dragmode: "zoom",
    xaxis: axis(color, x, Math.floor(width / (DIGIT * typeScale() * (longest(x.range) + BETWEEN)))),
    yaxis: axis(color, y),
  };
}

function axis(color, { title, range }, room = Infinity) {
  return {
    title: { text: title, standoff: 8 },
    range: [...range],
    autorange: false,
    zeroline: false,
    showgrid: true,
    gridcolor: color("grid"),
    linecolor: color("axis"),
    linewidth: 1,
    mirror: true,
    ticks: "inside",
    ticklen: 5,
    tickcolor: color("axis"),
    nticks: Math.min(mostTicks(), room),
    automargin: false,
    exponentformat: "power",
    minexponent: LEAST_POWER,
    // On one of them: on all of them it would run into the title.
    showexponent: "last",
  };
}

/** Of the legend of a saved picture, in pixels. */
const LEGEND_LINE = 20;
const LEGEND_SAMPLE = 45;
const LETTER = 7;

/**
 * A layout with a legend below the plot, for a file.
 * @param {string[]} names in the legend; without any there is none
 */
export function withLegend(sheet, names) {
  if (names.length === 0) return sheet;
  const widest = Math.max(...names.map((name) => name.length)) * LETTER + LEGEND_SAMPLE;
  const rows = Math.ceil(names.length / Math.max(Math.floor((sheet.width - 20) / widest), 1));
  const room = LEGEND_LINE * rows + 12;
  return {
    ...sheet, height: sheet.height + room, margin: { ...sheet.margin, b: sheet.margin.b + room }, showlegend: true,
    legend: { orientation: "h", yref: "container", y: 0, yanchor: "bottom", x: 0, entrywidth: widest - LEGEND_SAMPLE },
  };
}

/** The part of the page on which data lie, as `{left, top, width, height}` within a plot whose ordinate has the range y. */
function frame([width, height], y) {
  const { l, r, t, b } = margins(y);
  return { left: l, top: t, width: width - l - r, height: height - t - b };
}

/**
 * How data and pixels belong together.
 * @param {[number, number]} size of the plot in pixels
 * @param {[number, number]} x range
 * @param {[number, number]} y range
 */
export function mapping(size, x, y) {
  const { left, top, width, height } = frame(size, y);
  return {
    frame: { left, top, width, height },
    toPixel: (a, b) => [
      left + ((a - x[0]) / (x[1] - x[0])) * width,
      top + (1 - (b - y[0]) / (y[1] - y[0])) * height,
    ],
    toData: (px, py) => [
      x[0] + ((px - left) / width) * (x[1] - x[0]),
      y[0] + (1 - (py - top) / height) * (y[1] - y[0]),
    ],
    isInside: (px, py) => px >= left && px <= left + width && py >= top && py <= top + height,
  };
}

const POSITIONS = [
  "top center", "top right", "top left", "middle right", "middle left",
  "bottom right", "bottom left", "bottom center",
];
const HEIGHT = 14;
const SIZE = 12;
const GAP = 8;

const pen = document.createElement("canvas").getContext("2d");

/** Pixels within which markers lie on each other: they share a text. */
const CLOSE = 9;

/** Pixels that a text keeps from the axes, and from the next one. */
const CLEAR = 3;

/** Share of a text that may lie on other texts; it is left out where there is no such place. */
const HIDDEN = 0.05;

/** Points of a line under a text above which it is shortened. */
const SHORTENED = 2;

/** Points of a line under a text that are rather taken than that it stands as near to another marker. */
const MISTAKEN = 6;

/** Points of lines under texts above which one of them is left out. */
const LEFT_OUT = 20;

/** Of more texts than these only their own order is tried. */
const MOST_ORDERS = 20;

/**
 * Choose a place for each text: they choose one after the other, each of them first in turn, and the
 * best of these orders is kept. Texts of markers that lie on each other become one, e.g. "3 PD", and a
 * text without room is empty.
 * @param {{text: string, short: string, at: [number, number], of?: string, count?: number}[]} texts with their places
 *   in pixels, and what they name: what is marked twice counts once, and what stands for several counts as them
 * @param {[number, number][][]} lines in pixels
 * @param {{left: number, top: number, width: number, height: number}} frame to stay in, in pixels
 * @param {[number, number][]} others markers without a text, in pixels
 * @returns {{text: string, position: string}[]} with plotly's `textposition`
 */
export function labelPlaces(texts, lines, frame, others = []) {
  const places = [...texts.map(({ at }) => at), ...others];
  const markers = places.map((at) => boxAround(at, 10, 10));
  const ink = points(lines);
  pen.font = `${SIZE * typeScale()}px system-ui, sans-serif`;
  const offers = gathered(texts).map(({ words, group }) => {
    const own = group.map((i) => texts[i].at);
    const foreign = places.filter((place) => !own.includes(place));
    return group.flatMap((index, rank) => words.flatMap((text, shortened) => POSITIONS.map((position, i) => {
      const { at } = texts[index];
      const box = boxAt(position, at, pen.measureText(text).width);
      const over = outside(box, frame) + 0.4 * overlap(box, markers) + inkUnder(box, ink);
      const isOther = foreign.some((place) => distance(box, place) < distance(box, at) + 2);
      return { index, text, position, box, cost: 0.3 * i + 0.1 * rank + over + SHORTENED * shortened + MISTAKEN * isOther };
    })));
  });
  const named = offers.map((_, i) => i);
  const orders = named.length > MOST_ORDERS ? [named] : named.map((first) => [first, ...named.filter((i) => i !== first)]);
  const [{ chosen } = { chosen: [] }] = orders.map((order) => inOrder(offers, order)).sort((a, b) => a.cost - b.cost);
  return texts.map((_, i) => chosen[i] ?? { text: "", position: POSITIONS[0] });
}

/** The cheapest place of each text in an order beside those before; none where a text would lie on another, or on too much else. */
function inOrder(offers, order) {
  const labels = [];
  const chosen = [];
  let cost = 0;
  for (const i of order) {
    const priced = offers[i].map((offer) => ({ ...offer, hidden: overlap(offer.box, labels) }))
      .map((offer) => ({ ...offer, cost: offer.cost + 0.4 * offer.hidden }))
      .sort((a, b) => a.cost - b.cost);
    const isClear = ({ hidden, box: [left, top, right, bottom] }) => hidden <= HIDDEN * (right - left) * (bottom - top);
    const best = priced.find((offer, rank) => isClear(offer) && (rank === 0 || offer.cost < LEFT_OUT));
    cost += best?.cost ?? priced[0].cost + LEFT_OUT;
    if (!best) continue;
    const { index, text, position, box: [left, top, right, bottom] } = best;
    labels.push([left - CLEAR, top, right + CLEAR, bottom]);
    chosen[index] = { text, position };
  }
  return { chosen, cost };
}

/**
 * Markers that lie on each other, by their numbers, with what may stand beside one of them, the best first: all names
 * of several, else the text or the short one.
 */
function gathered(texts) {
  const groups = [];
  texts.forEach(({ at }, i) => {
    const near = groups.find(([first]) => apart(texts[first].at, at) < CLOSE);
    if (near) near.push(i);
    else groups.push([i]);
  });
  return groups.map((group) => {
    const all = group.map((i) => texts[i]);
    const named = [...new Map(all.map((each) => [each.of ?? each, each])).values()];
    const [{ text, short, count = 1 }] = named;
    return { group, words: named.length > 1 || count > 1 ? [counted(named)] : [text, short] };
  });
}

/** Names with how often they occur: "3 PD, NS". */
function counted(named) {
  return [...Map.groupBy(named, ({ short }) => short)].map(([name, all]) => {
    const total = all.reduce((sum, { count = 1 }) => sum + count, 0);
    return total > 1 ? `${total} ${name}` : name;
  }).join(", ");
}

function boxAt(position, [x, y], width) {
  const [vertical, horizontal] = position.split(" ");
  const height = HEIGHT * typeScale();
  const down = { top: -GAP - height / 2, middle: 0, bottom: GAP + height / 2 }[vertical];
  const beside = vertical === "middle" ? GAP : 4;
  const right = { left: -beside - width / 2, center: 0, right: beside + width / 2 }[horizontal];
  return boxAround([x + right, y + down], width, height);
}

function boxAround([x, y], width, height) {
  return [x - width / 2, y - height / 2, x + width / 2, y + height / 2];
}

function outside([left, top, right, bottom], frame) {
  const [ends, floor] = [frame.left + frame.width, frame.top + frame.height];
  const beyond = [frame.left - left, frame.top - top, right - ends, bottom - floor].map((value) => Math.max(value + CLEAR, 0));
  return 100 * beyond.reduce((sum, value) => sum + value, 0);
}

function apart([x, y], [a, b]) {
  return Math.hypot(x - a, y - b);
}

function distance([left, top, right, bottom], [x, y]) {
  return Math.hypot(Math.max(left - x, 0, x - right), Math.max(top - y, 0, y - bottom));
}

function overlap(box, others) {
  let area = 0;
  for (const other of others) {
    const width = Math.min(box[2], other[2]) - Math.max(box[0], other[0]);
    const height = Math.min(box[3], other[3]) - Math.max(box[1], other[1]);
    if (width > 0 && height > 0) area += width * height;
  }
  return area;
}

function inkUnder([left, top, right, bottom], ink) {
  return ink.filter(([x, y]) => x > left && x < right && y > top && y < bottom).length;
}

/** Lines as points a few pixels apart. */
function points(lines) {
  const found = [];
  for (const line of lines) {
    for (let i = 0; i + 1 < line.length; i++) {
      const [a, b] = [line[i], line[i + 1]];
      const count = Math.min(Math.ceil(Math.hypot(b[0] - a[0], b[1] - a[1]) / 4), 500);
      for (let k = 0; k < count; k++) {
        found.push([a[0] + ((b[0] - a[0]) * k) / count, a[1] + ((b[1] - a[1]) * k) / count]);
      }
    }
  }
  return found;
}
