/** Layers above the curves of a diagram, so that plotly need not draw again: the periods of a simulation and the places of a sweep in a few paths, and the live curve while a slider moves. */

import { SHAPES } from "./diagram_panel.js";
import { set, svg } from "./dom.js";

const RUNS = ["up", "down"];

/** Dots of a simulation, one a forcing period: up to `all` of them are drawn, and `few` of more. */
const DOTS = { all: 600, few: 150 };

/** Steps in which dots become more opaque towards the last one, and the opacity of the first and the last. */
const FADING = { steps: 8, from: 0.15, to: 0.75 };

/** Radius of the ring around the last one, in pixels. */
const RING = 4.5;

/**
 * Dots of a simulation in groups of one opacity, the last ones at the end.
 * @param {number[]} values one a period
 */
function faded(values) {
  // An odd step keeps both the largest and the smallest values, which alternate.
  const step = values.length > DOTS.all ? Math.ceil(values.length / DOTS.few) | 1 : 1;
  const kept = values.filter((_, i) => (values.length - 1 - i) % step === 0);
  const each = Math.max(Math.ceil(kept.length / FADING.steps), 1);
  return Array.from({ length: FADING.steps }, (_, i) => ({
    opacity: FADING.from + ((FADING.to - FADING.from) * i) / (FADING.steps - 1),
    values: kept.slice(Math.max(kept.length - (FADING.steps - i) * each, 0), Math.max(kept.length - (FADING.steps - 1 - i) * each, 0)),
  }));
}

export class MotionLayer {
  /** The element to put on the plot. */
  node = svg("svg", { class: "motion-layer", "aria-hidden": "true" });
  #dots = faded([]).map(({ opacity }) => svg("path", { class: "simulated", opacity }));
  #last = svg("circle", { class: "simulated-last", r: RING });
  #runs = Object.fromEntries(RUNS.map((run) => [run, svg("path", { class: `sweep ${run}` })]));

  constructor() {
    this.node.append(...this.#dots, this.#last, ...Object.values(this.#runs));
  }

  /**
   * @param {{x: number, y: number[]}|null} simulated in SI units
   * @param {Record<string, {x: number, y: number, size: number}[]>} runs of a sweep
   * @param {{toPixel: Function, isInside: Function}} map of the plot
   * @param {[number, number]} factors of both axes
   */
  draw(simulated, runs, map, [fx, fy]) {
    const { x = 0, y = [] } = simulated ?? {};
    const at = (value) => map.toPixel(x * fx, value * fy);
    faded(y).forEach(({ values }, i) => {
      const seen = values.map(at).filter((place) => map.isInside(...place));
      set(this.#dots[i], { d: seen.map(([px, py]) => `M${px.toFixed(1)} ${py.toFixed(1)}h0`).join("") });
    });
    const last = y.length ? at(y.at(-1)) : null;
    const isSeen = Boolean(last && map.isInside(...last));
    this.#last.classList.toggle("absent", !isSeen);
    if (isSeen) set(this.#last, { cx: last[0].toFixed(1), cy: last[1].toFixed(1) });
    for (const run of RUNS) {
      const ahead = run === "up" ? 1 : -1;
      const places = runs[run].map((place) => [place.size, ...map.toPixel(place.x * fx, place.y * fy)])
        .filter(([, ...place]) => map.isInside(...place));
      const arrows = places.map(([size, px, py]) =>
        `M${(px - ahead * size).toFixed(1)} ${(py - size).toFixed(1)}l${2 * ahead * size} ${size}l${-2 * ahead * size} ${size}z`);
      set(this.#runs[run], { d: arrows.join(""), "data-count": places.length });
    }
  }
}

/** The same as traces of plotly, for a file. */
export function motionTraces(simulated, runs, [fx, fy], color) {
  const { x = 0, y = [] } = simulated ?? {};
  const dots = faded(y).filter(({ values }) => values.length).map(({ opacity, values }) => ({
    type: "scatter", mode: "markers", x: values.map(() => x * fx), y: values.map((value) => value * fy),
    marker: { color: color("simulation"), size: 4, opacity },
  }));
  const tints = { up: color("simulation"), down: color("pin-2") };
  return [...dots, ...RUNS.filter((run) => runs[run].length).map((run) => ({
    type: "scatter", mode: "markers", name: `sweep ${run}`, x: runs[run].map((place) => place.x * fx), y: runs[run].map((place) => place.y * fy),
    marker: { color: tints[run], size: runs[run].map(({ size }) => 2 * size), symbol: run === "up" ? "triangle-right" : "triangle-left" },
  }))];
}

/** Directions of texts from their markers, as plotly's `textposition` names them. */
const SIDES = { top: -1, middle: 0, bottom: 1, left: -1, center: 0, right: 1 };
const ANCHORS = { left: "end", center: "middle", right: "start" };

/** How plotly draws markers whose sizes are a list. */
const MARKER_OPACITY = 0.7;

export class LiveLayer {
  /** The element to put on the plot. */
  node = svg("svg", { class: "motion-layer live", "aria-hidden": "true" });
  #frame = svg("rect");
  #lines = svg("g", { fill: "none", "clip-path": "url(#live-frame)" });
  #marks = svg("g");

  constructor() {
    this.node.append(svg("clipPath", { id: "live-frame" }, this.#frame), this.#lines, this.#marks);
  }

  /**
   * Draw what plotly would.
   * @param {object[]} traces lines, and last markers with their names
   * @param {{toPixel: Function, isInside: Function, frame: object}} map of the plot
   * @param {string} family of fonts
   */
  draw(traces, { toPixel, isInside, frame: { left: x0, top: y0, width, height } }, family) {
    set(this.#frame, { x: x0, y: y0, width, height });
    this.#lines.replaceChildren(...traces.slice(0, -1).map((trace) => lineOf(trace, toPixel)));
    const { x, y, marker, text, textposition, textfont, opacity } = traces.at(-1);
    const places = x.map((value, i) => toPixel(value, y[i]));
    set(this.#marks, { opacity, "font-family": family, "font-size": textfont.size });
    this.#marks.replaceChildren(...places.flatMap((place, i) => (isInside(...place) ? [
      svg("path", {
        d: SHAPES[marker.symbol[i]], transform: `translate(${place})`,
        fill: marker.color[i], stroke: marker.line.color, "stroke-width": marker.line.width, opacity: MARKER_OPACITY,
      }),
      textOf(place, text[i], textposition[i], marker.size[i], textfont),
    ] : [])));
  }
}

function lineOf({ x, y, line: { color, dash, width }, opacity }, toPixel) {
  let command = "M";
  const parts = x.map((value, i) => {
    if (value === null) {
      command = "M";
      return "";
    }
    const [px, py] = toPixel(value, y[i]);
    const part = `${command}${px.toFixed(2)} ${py.toFixed(2)}`;
    command = "L";
    return part;
  });
  const dashes = dash === "solid" ? null : dash;
  return svg("path", { d: parts.join(""), stroke: color, "stroke-width": width, "stroke-dasharray": dashes, opacity });
}

/** A name where plotly puts it. */
function textOf([x, y], text, position, size, font) {
  const [vertical, horizontal] = position.split(" ");
  const reach = size / 1.6 + 1;
  const down = SIDES[vertical];
  return svg("text", {
    x: x + SIDES[horizontal] * reach, y: y + 0.75 * font.size + down * reach + ((down - 1) * font.size) / 2,
    fill: font.color, "text-anchor": ANCHORS[horizontal],
  }, text.replaceAll("&lt;", "<").replaceAll("&amp;", "&"));
}
