/** Blocks on their belts, one for each contact along a line: they stand still on it where they stick. */

import { element, set, svg } from "../controls/dom.js";
import { pieceAt, valueAt } from "./contact_plots.js";

const [WIDTH, ROW, BELT] = [320, 92, 64];
const HATCH = 16;
const BLOCK = 34;

/** Pixels from the middle that the largest displacement takes, and the largest friction. */
const REACH = 105;
const ARROW = 52;

export class Belts {
  /** The element to put on the page. */
  node;
  #drawing = svg("svg", { class: "belts", role: "img", "aria-label": "Blocks on belts" });
  #rows = [];
  #contacts = [];

  constructor() {
    this.node = element("div", { class: "mechanism-frame" }, this.#drawing);
  }

  /** As `SmallPlot.figure`. */
  get figure() {
    return { drawing: this.#drawing, caption: null };
  }

  /** As `Mechanism.adopt`. */
  adopt({ contacts }) {
    this.#contacts = contacts;
    const places = contacts.flatMap(({ pieces }) => pieces.flatMap(({ displacement }) => displacement[0]));
    const forces = contacts.flatMap(({ pieces }) => pieces.flatMap(({ friction }) => friction[0]));
    const largest = Math.max(...places.map(Math.abs), 1e-12);
    this.scale = REACH / largest;
    this.force = ARROW / Math.max(...forces.map(Math.abs), 1e-12);
    set(this.#drawing, { viewBox: `0 0 ${WIDTH} ${ROW * contacts.length + 10}` });
    this.#rows = contacts.map(({ name }, row) => {
      const belt = svg("path", { class: "belt" });
      const block = svg("rect", { class: "block", width: BLOCK, height: BLOCK, y: BELT - BLOCK });
      const arrow = svg("path", { class: "friction-arrow" });
      const node = svg("g", { transform: `translate(0 ${ROW * row})` },
        svg("path", { class: "zero", d: `M${WIDTH / 2} ${BELT - BLOCK - 6}V${BELT}` }),
        svg("path", { class: "belt-edge", d: `M6 ${BELT}H${WIDTH - 6}` }), belt, block, arrow,
        svg("text", { class: "part-name", x: 8, y: BELT - BLOCK + 4 }, name));
      return { node, belt, block, arrow };
    });
    this.#drawing.replaceChildren(...this.#rows.map(({ node }) => node));
  }

  /**
   * Show a time.
   * @param {number} time as the pieces have it
   * @param {number} seconds the same in s, in which belts move
   */
  at(time, seconds) {
    this.#contacts.forEach(({ pieces, plate }, row) => {
      const { belt, block, arrow } = this.#rows[row];
      const piece = pieceAt(pieces, time);
      const x = WIDTH / 2 + this.scale * valueAt(piece, piece.displacement[0], time);
      const force = this.force * valueAt(piece, piece.friction[0], time);
      const gone = ((((this.scale * plate[0] * seconds) % HATCH) + HATCH) % HATCH) - HATCH;
      const strokes = Array.from({ length: Math.floor(WIDTH / HATCH) + 2 }, (_, i) => gone + i * HATCH)
        .filter((place) => place > 12 && place < WIDTH - 6)
        .map((place) => `M${place.toFixed(1)} ${BELT + 1}l-6 9`);
      set(belt, { d: strokes.join("") });
      set(block, { x: (x - BLOCK / 2).toFixed(1), class: `block ${piece.state}` });
      const head = Math.sign(force) * Math.min(6, Math.abs(force));
      set(arrow, { d: `M${x.toFixed(1)} ${BELT - 8}h${force.toFixed(1)}l${-head} -4m${head} 4l${-head} 4` });
    });
  }
}
