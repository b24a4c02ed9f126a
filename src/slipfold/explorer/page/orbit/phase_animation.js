/** The motion of any model as a point that runs through its phase plane. */

import { element } from "../controls/dom.js";
import { axisTitle } from "../parameters/quantities.js";
import { sampled } from "./sampled.js";
import { SmallPlot } from "../plots/small_plot.js";

const TRAIL = 0.12;
const TRAIL_DOTS = 14;

export class PhaseAnimation {
  /** The element to put on the page. */
  node;
  #plot;
  #pair = null;

  /** @param {string} [id] tells two on one page apart */
  constructor(id = "motion") {
    this.#plot = new SmallPlot(id, "Motion in the phase plane");
    this.node = element("div", { class: "mechanism-frame" }, this.#plot.node);
  }

  /** As `SmallPlot.figure`. */
  get figure() {
    return this.#plot.figure;
  }

  /** As `Mechanism.adopt`. */
  adopt(answer, _parameters, quantity) {
    const [a, b = a] = Object.keys(answer.states);
    this.#pair = [answer.states[a], answer.states[b]];
    this.#plot.draw({
      x: { label: axisTitle(quantity(a)) },
      y: { label: axisTitle(quantity(b)) },
      lines: [{ x: this.#pair[0], y: this.#pair[1], tint: "faint" }],
      dots: [{ x: this.#pair[0][0], y: this.#pair[1][0], tint: "strobe" }],
    });
  }

  /** As `Mechanism.show`. */
  show(phase) {
    if (!this.#pair) return;
    const at = (moment) => {
      const inOrbit = moment - Math.floor(moment);
      return { x: sampled(this.#pair[0], inOrbit), y: sampled(this.#pair[1], inOrbit) };
    };
    const trail = Array.from({ length: TRAIL_DOTS }, (_, i) =>
      ({ ...at(phase - TRAIL * (1 - i / TRAIL_DOTS)), tint: "trail" }));
    this.#plot.point({ dots: [...trail, { ...at(phase), tint: "live" }] });
  }
}
