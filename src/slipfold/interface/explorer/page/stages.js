/** The stages on which a trajectory runs: mechanism, belts, phase plane. */

import { pieceAt, valueAt } from "./model/contacts.js";
import { element, set, svg } from "./dom.js";
import { axisTitle, formatted, withUnit } from "./quantities.js";
import { SmallPlot } from "./small_plot.js";

/**
 * The value of a periodic signal at a phase.
 * @param {number[]} samples evenly spaced, the last at the end of the orbit
 * @param {number} phase from 0 to 1
 */
export function sampled(samples, phase) {
  const place = phase * (samples.length - 1);
  const i = Math.min(Math.floor(place), samples.length - 2);
  if (i < 0) return samples[0];
  return samples[i] + (place - i) * (samples[i + 1] - samples[i]);
}

const HATCH = 0.3;
const COILS = 9;

export class Mechanism {
  /** The element to put on the page. */
  node;
  #parts = {};
  #reading = element("p", { class: "reading" });
  #orbit = null;
  #reach = 1;
  #force = 1;

  /** @param {string} [id] distinguishes two on one page */
  constructor(id = "orbit") {
    const [friction, plate, hatch] = ["friction", "plate", "hatch"].map((name) => `${name}-of-${id}`);
    const part = (name, attributes = {}) => {
      this.#parts[name] = svg("path", { class: name, ...attributes });
      return this.#parts[name];
    };
    const tip = svg("g", { class: "tip-group" },
      part("load"), svg("circle", { class: "tip", r: 0.055 }));
    this.#parts.tip = tip;
    this.#parts.drawing = svg("svg", {
      class: "mechanism", role: "img",
      "aria-label": "The mechanism: tip, masses and springs above the moving plate",
    },
    svg("defs", {}, arrowHead("friction-head", friction), arrowHead("plate-head", plate),
      this.#parts.hatch = svg("pattern", { id: hatch, width: HATCH, height: HATCH, patternUnits: "userSpaceOnUse" },
        svg("path", { class: "hatch", d: `M0 0V${HATCH}` }))),
    svg("rect", { class: "plate", x: -3, y: -3, width: 6, height: 6, fill: `url(#${hatch})` }),
    part("rails"), part("path"), part("spring-ext"), part("spring-1"), part("spring-2"),
    part("rods"), part("mass-1"), part("mass-2"), part("ground"),
    part("plate-arrow", { "marker-end": `url(#${plate})` }),
    part("friction-arrow", { "marker-end": `url(#${friction})` }), tip, this.#labels());
    this.node = element("div", { class: "mechanism-frame" }, this.#parts.drawing, this.#reading);
  }

  /** As `SmallPlot.figure`. */
  get figure() {
    return { drawing: this.#parts.drawing, caption: null };
  }

  /**
   * Take another orbit.
   * @param {object} answer the server's
   */
  adopt(answer, parameters, quantity) {
    const { x, y } = answer.states;
    this.#orbit = { answer, parameters, quantity };
    const largest = Math.max(...x.map(Math.abs), ...y.map(Math.abs));
    // The view grows in steps, so that it does not breathe while a slider moves.
    this.#reach = [0.35, 0.6, 1, 1.6, 2.5].find((reach) => reach > largest * 1.05) ?? largest * 1.1;
    const { Fx, Fy } = answer.outputs;
    this.#force = Math.max(...Fx.map((value, i) => Math.hypot(value, Fy[i])), 1e-12);
    this.#still(parameters);
    const points = x.map((value, i) => `${value.toFixed(4)} ${(-y[i]).toFixed(4)}`);
    set(this.#parts.path, { d: `M${points.join("L")}` });
  }

  /**
   * Show a moment.
   * @param {number} phase from 0 to 1 over the orbit
   * @param {string[]} [doing] what each contact does then
   */
  show(phase, [doing] = []) {
    if (!this.#orbit) return;
    this.#parts.tip.classList.toggle("sticks", doing === "stick");
    const { answer, parameters } = this.#orbit;
    const at = (values) => sampled(values, phase);
    const [x, y] = [at(answer.states.x), -at(answer.states.y)];
    const edge = this.#reach + 0.75;
    const rail = -this.#reach - 0.18;
    set(this.#parts.tip, { transform: `translate(${x} ${y})` });
    set(this.#parts["spring-ext"], { d: coil([0, 1], [x, y], 0.09) });
    set(this.#parts["mass-1"], { d: block(rail, y, 0.13) });
    set(this.#parts["mass-2"], { d: block(x, rail, 0.13) });
    set(this.#parts["label-m1"], { x: rail - 0.085, y: y + 0.03 });
    set(this.#parts["label-m2"], { x: x - 0.085, y: rail + 0.03 });
    set(this.#parts["spring-1"], { d: coil([rail, -edge], [rail, y - 0.13], 0.07) });
    set(this.#parts["spring-2"], { d: coil([edge, rail], [x + 0.13, rail], 0.07) });
    set(this.#parts.rods, { d: `M${-this.#reach - 0.05} ${y}H${x}M${x} ${-this.#reach - 0.05}V${y}` });
    const load = at(answer.outputs.N);
    const radius = 0.075 + 0.1 * Math.sqrt(Math.max(load, 0) / (2 * parameters.Ns));
    set(this.#parts.load, { d: `M${radius} 0A${radius} ${radius} 0 1 1 ${-radius} 0A${radius} ${radius} 0 1 1 ${radius} 0Z` });
    const scale = (0.42 * Math.min(this.#reach + 0.4, 1.2)) / this.#force;
    const [fx, fy] = [at(answer.outputs.Fx) * scale, -at(answer.outputs.Fy) * scale];
    set(this.#parts["friction-arrow"], { d: `M${x} ${y}l${fx} ${fy}` });
    this.#movePlate(at(answer.t), parameters);
    this.#read(at(answer.outputs.Fx), at(answer.outputs.Fy), load, doing);
  }

  #still({ alpha, Vd }) {
    const reach = this.#reach;
    const edge = reach + 0.75;
    const far = reach + 0.18;
    set(this.#parts.drawing, { viewBox: `${-edge - 0.12} ${-edge - 0.12} ${2 * edge + 0.24} ${Math.max(2 * edge, edge + 1.35) + 0.24}` });
    set(this.#parts.rails, { d: `M${-far} ${-reach - 0.55}V${reach + 0.3}M${-reach - 0.3} ${-far}H${reach + 0.55}` });
    set(this.#parts.ground, {
      d: ground([-far, -edge], "top") + ground([edge, -far], "right") + ground([0, 1], "bottom"),
    });
    const [cos, sin] = [Math.cos(alpha), -Math.sin(alpha)];
    const corner = [edge - 0.62, edge - 0.42];
    set(this.#parts["plate-arrow"], { d: `M${corner[0] - 0.22 * cos} ${corner[1] - 0.22 * sin}l${0.44 * cos} ${0.44 * sin}` });
    // A wall goes nowhere.
    for (const name of ["plate-arrow", "label-Vd"]) this.#parts[name].classList.toggle("absent", !(Vd > 0));
    this.#placeLabels(edge, far, corner);
  }

  /** The stripes of the plate stand across its way and go with it. */
  #movePlate(time, { alpha, Vd, L }) {
    const shift = ((Vd / L) * time) % HATCH;
    const degrees = (-alpha * 180) / Math.PI;
    set(this.#parts.hatch, {
      patternTransform: `rotate(${degrees.toFixed(3)}) translate(${shift.toFixed(4)} 0)`,
    });
  }

  #read(fx, fy, load, doing) {
    const { quantity } = this.#orbit;
    const force = withUnit(quantity("Fx"), Math.hypot(fx, fy), 3);
    const degrees = formatted((Math.atan2(fy, fx) * 180) / Math.PI, 3);
    this.#reading.textContent = `N = ${withUnit(quantity("N"), load, 3)}   friction ${force} at ${degrees}°${doing ? `   ${doing === "stick" ? "sticks" : "slips"}` : ""}`;
  }

  #labels() {
    const label = (name, letter, below) => {
      this.#parts[`label-${name}`] = svg("text", { class: "part-label" },
        svg("tspan", { "font-style": "italic" }, letter),
        below ? svg("tspan", { dy: "0.03", "font-size": "0.085" }, below) : null);
      return this.#parts[`label-${name}`];
    };
    return svg("g", {}, label("m1", "m", "1"), label("m2", "m", "2"), label("k1", "k", "1"),
      label("k2", "k", "2"), label("kext", "k", "ext"), label("Vd", "V", "d"));
  }

  #placeLabels(edge, far, corner) {
    const put = (name, x, y) => set(this.#parts[`label-${name}`], { x, y });
    put("k1", -far + 0.13, -edge + 0.3);
    put("k2", edge - 0.36, -far + 0.26);
    put("kext", 0.14, 0.95);
    put("Vd", corner[0] + 0.2, corner[1] + 0.32);
  }
}

function arrowHead(kind, id) {
  return svg("marker", {
    id, viewBox: "0 0 10 10", refX: 7, refY: 5, markerWidth: 5, markerHeight: 5, orient: "auto",
  }, svg("path", { class: kind, d: "M0 1L9 5L0 9Z" }));
}

function block(x, y, half) {
  return `M${x - half} ${y - half}h${2 * half}v${2 * half}h${-2 * half}Z`;
}

/** A spring from one point to another. */
export function coil(from, to, width, coils = COILS) {
  const along = [to[0] - from[0], to[1] - from[1]];
  const length = Math.hypot(...along) || 1e-9;
  const across = [(-along[1] / length) * width, (along[0] / length) * width];
  const at = (share, side) =>
    `${(from[0] + share * along[0] + side * across[0]).toFixed(4)} ${(from[1] + share * along[1] + side * across[1]).toFixed(4)}`;
  const zigzag = Array.from({ length: coils * 2 }, (_, i) =>
    at(0.12 + (0.76 * (i + 0.5)) / (coils * 2), i % 2 ? 1 : -1));
  return `M${[at(0, 0), at(0.12, 0), ...zigzag, at(0.88, 0), at(1, 0)].join("L")}`;
}

/** A hatched support at a point. */
function ground([x, y], side) {
  const isLevel = side !== "right";
  const out = side === "top" ? -1 : 1;
  const bar = isLevel ? `M${x - 0.16} ${y}h0.32` : `M${x} ${y - 0.16}v0.32`;
  const strokes = [-0.12, -0.04, 0.04, 0.12].map((place) =>
    isLevel ? `M${x + place} ${y}l-0.05 ${0.07 * out}` : `M${x} ${y + place}l0.07 -0.05`);
  return bar + strokes.join("");
}

const [WIDTH, ROW, BELT] = [320, 92, 64];
const BELT_HATCH = 16;
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
      const gone = ((((this.scale * plate[0] * seconds) % BELT_HATCH) + BELT_HATCH) % BELT_HATCH) - BELT_HATCH;
      const strokes = Array.from({ length: Math.floor(WIDTH / BELT_HATCH) + 2 }, (_, i) => gone + i * BELT_HATCH)
        .filter((place) => place > 12 && place < WIDTH - 6)
        .map((place) => `M${place.toFixed(1)} ${BELT + 1}l-6 9`);
      set(belt, { d: strokes.join("") });
      set(block, { x: (x - BLOCK / 2).toFixed(1), class: `block ${piece.state}` });
      const head = Math.sign(force) * Math.min(6, Math.abs(force));
      set(arrow, { d: `M${x.toFixed(1)} ${BELT - 8}h${force.toFixed(1)}l${-head} -4m${head} 4l${-head} 4` });
    });
  }
}

const TRAIL = 0.12;
const TRAIL_DOTS = 14;

export class PhaseAnimation {
  /** The element to put on the page. */
  node;
  #plot;
  #pair = null;

  /** @param {string} [id] distinguishes two on one page */
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
      dots: [{ x: this.#pair[0][0], y: this.#pair[1][0], tint: "stroboscopic" }],
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
