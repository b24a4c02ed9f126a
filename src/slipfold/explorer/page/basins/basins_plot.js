/** Basins of attraction: each start in the colour of what its motion comes to. */

import { escaped } from "../diagram/diagram_traces.js";
import { element } from "../controls/dom.js";
import { CONFIG, layout, mapping } from "../plots/plot_frame.js";
import { axisTitle, display } from "../parameters/quantities.js";
import { colours, themeChanged } from "../style/theme.js";

/** Colours of attractors: the first two differ most in lightness. */
const TINTS = ["region-2", "live", ...Array.from({ length: 12 }, (_, i) => `region-other-${i + 1}`)];

/** What starts came to that came to no attractor, from the least label on. */
const NOTHING = [
  { label: -2, name: "not finished", tint: "panel" },
  { label: -1, name: "ended", tint: "axis" },
  { label: 0, name: "undecided", tint: "region-none" },
];

/**
 * Names and colours of all that starts came to, in the order of their labels.
 * @param {{labels: number[][], attractors: {name: string, share: number}[]}} basins
 */
export function keysOf({ labels, attractors }) {
  const seen = new Set(labels.flat());
  const found = attractors.map(({ name, share }, i) => ({
    label: i + 1, name: `${name}, ${(100 * share).toPrecision(3)} %`, tint: TINTS[i % TINTS.length],
  }));
  return [...NOTHING, ...found].map((key) => ({ ...key, isSeen: key.label > 0 || seen.has(key.label) }));
}

export class BasinsPlot {
  /** The element to put on the page. */
  node = element("div", { class: "plot basins-plot", hidden: true });
  #canvas = element("div", { class: "plot-canvas" });
  #basins = null;
  #map = null;
  #frame = 0;

  /** @param {(x: number, y: number) => void} pick hears of a start that is clicked, in SI units */
  constructor(pick) {
    this.node.append(this.#canvas);
    themeChanged.subscribe(() => this.#schedule());
    new ResizeObserver(() => this.#schedule()).observe(this.node);
    this.node.addEventListener("click", (event) => {
      const box = this.node.getBoundingClientRect();
      const at = [event.clientX - box.left, event.clientY - box.top];
      if (!this.#map?.isInside(...at)) return;
      const [x, y] = this.#map.toData(...at);
      pick(x / display(this.#basins.x).factor, y / display(this.#basins.y).factor);
    });
  }

  /** Show a picture in place of the one before; null shows none. */
  show(basins) {
    this.#basins = basins;
    this.node.hidden = !basins;
    this.node.dataset.points = basins ? String(basins.x.values.length) : "";
    this.#schedule();
  }

  #schedule() {
    if (this.#frame) return;
    this.#frame = requestAnimationFrame(() => {
      this.#frame = 0;
      this.#draw();
    });
  }

  #draw() {
    if (!this.#basins || this.node.clientWidth === 0) return;
    const { x, y, labels } = this.#basins;
    const colour = colours();
    const keys = keysOf(this.#basins);
    const [across, up] = [x, y].map((axis) => axis.values.map((value) => value * display(axis).factor));
    const size = [this.node.clientWidth, this.node.clientHeight];
    const range = { x: ends(across), y: ends(up) };
    this.#map = mapping(size, range.x, range.y);
    const sheet = layout(colour, { title: escaped(axisTitle(x)), range: range.x },
      { title: escaped(axisTitle(y)), range: range.y }, size);
    sheet.dragmode = false;
    sheet.xaxis.showgrid = sheet.yaxis.showgrid = false;
    sheet.xaxis.fixedrange = sheet.yaxis.fixedrange = true;
    const colorscale = keys.flatMap(({ tint }, i) =>
      [i, i + 1].map((end) => [end / keys.length, colour(tint)]));
    const trace = {
      type: "heatmap", x: across, y: up, z: labels, colorscale, showscale: false, hoverinfo: "skip",
      zmin: keys[0].label - 0.5, zmax: keys.at(-1).label + 0.5,
    };
    window.Plotly.react(this.#canvas, [trace], sheet, CONFIG);
  }
}

/** Where the outermost cells end. */
function ends(values) {
  const half = (values.at(-1) - values[0]) / (values.length - 1) / 2;
  return [values[0] - half, values.at(-1) + half];
}
