/** Motions above the curves of a diagram: the periods of a simulation, the places of a sweep. All places are in a few paths, so that plotly need not draw again. */

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
