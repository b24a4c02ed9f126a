/** A mechanism drawn from its parts: masses in a row, springs, dashpots, contacts, forces. */

import { element, set, svg } from "../dom.js";
import { coil, sampled } from "../stages.js";

const WIDTH = 320;
const MARGIN = 22;
const CEILING = 14;
const LANE = 15;
const HATCH = 10;

/** Width of a letter of a name that is written below its mass, if it has room there. */
const LETTER = 6.5;

/**
 * @typedef {object} Parts the server's, of a model
 * @property {string[]} bodies displacements by the names of their states
 * @property {number[][]} springs pairs of bodies; -1 is the ground
 * @property {number[][]} dashpots likewise
 * @property {{name: string, bodies: number[], moves: boolean}[]} contacts
 * @property {number[]} forces bodies at which something pulls
 */

export class Schematic {
  /** The element to put on the page. */
  node;
  #drawing = svg("svg", { class: "schematic", role: "img", "aria-label": "The mechanism" });
  #parts = "";
  #masses = [];
  #links = [];
  #contacts = [];
  #answer = null;
  #places = [];

  constructor() {
    this.node = element("div", { class: "mechanism-frame" }, this.#drawing);
  }

  /** As `SmallPlot.figure`. */
  get figure() {
    return { drawing: this.#drawing, caption: null };
  }

  /** As `Mechanism.adopt`. */
  adopt(answer, _parameters, quantity) {
    const labels = answer.mechanism.bodies.map((name) => quantity(name)?.label ?? name);
    const parts = JSON.stringify([answer.mechanism, labels]);
    if (parts !== this.#parts) this.#build(answer.mechanism, labels);
    this.#parts = parts;
    this.#answer = answer;
    const all = answer.mechanism.bodies.flatMap((name) => answer.states[name] ?? [0]);
    this.#places.forEach((place) => { place.scale = this.reach / Math.max(...all.map(Math.abs), 1e-300); });
    this.show(0);
  }

  /** As `Mechanism.show`. */
  show(phase, doing = []) {
    if (!this.#answer) return;
    const { states, mechanism, t } = this.#answer;
    const moved = mechanism.bodies.map((name) => (states[name] ? sampled(states[name], phase) : 0));
    for (const mass of this.#masses) {
      const [x, y] = centerOf(mass, moved);
      mass.at = [x, y];
      set(mass.node, { transform: `translate(${x.toFixed(2)} ${y.toFixed(2)})` });
    }
    for (const link of this.#links) set(link.node, { d: link.path() });
    this.#contacts.forEach(({ belt, mass, width, moves }, i) => {
      set(mass.shape, { class: `block ${doing[i] ?? ""}` });
      const gone = moves ? (phase * (t.at(-1) - t[0])) * 3 * HATCH % HATCH : 0;
      set(belt, { d: strokes(mass.home[0] - width / 2, mass.home[0] + width / 2, mass.home[1] + mass.half, gone) });
    });
  }

  #build(parts, labels) {
    const masses = grouped(parts.bodies, labels);
    const spacing = (WIDTH - 2 * MARGIN) / masses.length;
    const half = Math.min(17, spacing * 0.24);
    this.reach = Math.min(spacing * 0.2, 24);
    const skips = parts.springs.filter(([a, b]) => b >= 0 && Math.abs(massOf(masses, a).index - massOf(masses, b).index) > 1);
    const middle = 66 + LANE * skips.length;
    masses.forEach((mass, i) => {
      mass.home = [MARGIN + spacing * (i + 0.5), middle];
      mass.half = half;
      mass.at = mass.home;
      mass.shape = svg("rect", { class: "block", x: -half, y: -half, width: 2 * half, height: 2 * half });
      mass.node = svg("g", {}, mass.shape, arrows(parts.forces, mass, half));
    });
    this.#masses = masses;
    this.#places = masses;
    this.#links = linked(parts, masses, middle);
    this.#contacts = parts.contacts.filter(({ bodies }) => bodies.length).map(({ bodies, moves }) => {
      const mass = massOf(masses, bodies[0]);
      return { mass, moves, width: spacing * 0.86, belt: svg("path", { class: "belt" }) };
    });
    const edges = this.#contacts.map(({ mass, width }) => svg("path", {
      class: "belt-edge", d: `M${mass.home[0] - width / 2} ${mass.home[1] + half}h${width}`,
    }));
    const titles = masses.map(({ labels: own, home }) => {
      const name = own.join(", ");
      return name.length * LETTER <= spacing && masses.length <= 12
        ? svg("text", { class: "part-name", x: home[0], y: middle + half + 24, "text-anchor": "middle" }, name) : null;
    });
    // No room is kept for a wall or a ceiling that is not there.
    const walls = this.#links.filter(({ wall }) => wall);
    const right = walls.some(({ side }) => side === 1) ? WIDTH
      : Math.max(...masses.map(({ home }) => home[0] + half + this.reach), ...this.#contacts.map(({ mass, width }) => mass.home[0] + width / 2)) + 8;
    const top = walls.some(({ side }) => !side) || masses.some(({ across }) => across >= 0) ? 0 : middle - half - LANE * skips.length - 24;
    set(this.#drawing, {
      viewBox: `0 ${top} ${right} ${middle + half + 34 - top}`,
      "aria-label": `The mechanism: ${masses.length} ${masses.length === 1 ? "mass" : "masses"}, ${parts.springs.length} springs, ${parts.contacts.length} friction contacts`,
    });
    this.#drawing.replaceChildren(...edges, ...this.#contacts.map(({ belt }) => belt),
      ...this.#links.flatMap(({ wall, node }) => (wall ? [wall, node] : [node])), ...masses.map(({ node }) => node),
      ...titles.filter(Boolean));
  }
}

/** The masses: x and y of one name are one mass that moves in the plane. */
function grouped(bodies, labels) {
  const masses = new Map();
  bodies.forEach((name, i) => {
    const isPlanar = /^[xy]/.test(name) && bodies.includes((name[0] === "x" ? "y" : "x") + name.slice(1));
    const key = isPlanar ? name.slice(1) : `${i} ${name}`;
    const mass = masses.get(key) ?? { index: masses.size, along: -1, across: -1, labels: [] };
    mass[isPlanar && name[0] === "y" ? "across" : "along"] = i;
    mass.labels.push(labels[i]);
    masses.set(key, mass);
  });
  return [...masses.values()];
}

function massOf(masses, body) {
  return masses.find(({ along, across }) => along === body || across === body);
}

function centerOf({ home, along, across, scale }, moved) {
  const of = (body) => (body < 0 ? 0 : scale * moved[body]);
  return [home[0] + of(along), home[1] - of(across)];
}

/** Springs and dashpots between where things are. */
function linked(parts, masses, middle) {
  const last = masses.length - 1;
  let lane = 0;
  const key = ([a, b]) => `${a} ${b}`;
  const both = new Set(parts.springs.map(key).filter((text) => parts.dashpots.map(key).includes(text)));
  const one = (kind, draw) => ([a, b]) => {
    const from = massOf(masses, a);
    const offset = both.has(key([a, b])) ? (kind === "spring" ? -0.45 : 0.45) * from.half : 0;
    const node = svg("path", { class: kind });
    const to = b < 0 ? null : massOf(masses, b);
    if (to === from) return { node, ...cornered(from, draw, offset) };
    if (to) {
      const [left, right] = from.index < to.index ? [from, to] : [to, from];
      if (right.index - left.index === 1) {
        return { node, path: () => draw([left.at[0] + left.half, left.at[1] + offset], [right.at[0] - right.half, right.at[1] + offset]) };
      }
      lane += 1;
      const y = middle - left.half - LANE * lane;
      return { node, path: () => `M${left.at[0]} ${left.at[1] - left.half}V${y}M${right.at[0]} ${right.at[1] - right.half}V${y}${draw([left.at[0], y], [right.at[0], y])}` };
    }
    const isAcross = from.across === a;
    const side = isAcross ? 0 : from.index === 0 ? -1 : from.index === last ? 1 : 0;
    return { node, ...(side ? walled(from, side, draw, offset) : hung(from, draw, offset)) };
  };
  const coils = masses.length > 5 ? 3 : 7;
  const spring = (from, to) => coil(from, to, 5, coils);
  return [...parts.springs.map(one("spring", spring)), ...parts.dashpots.map(one("dashpot", dashpot))];
}

function walled(mass, side, draw, offset) {
  const x = side < 0 ? 8 : WIDTH - 8;
  const wall = svg("path", { class: "wall", d: hatched([x, mass.home[1]], mass.half + 6, side) });
  return { wall, side, path: () => draw([x, mass.home[1] + offset], [mass.at[0] + side * mass.half, mass.at[1] + offset]) };
}

function hung(mass, draw, offset) {
  const [x] = mass.home;
  const size = mass.half * 0.8;
  const ticks = [-0.6, 0, 0.6].map((place) => `M${x + place * size} ${CEILING}l4 -5`).join("");
  const wall = svg("path", { class: "wall", d: `M${x - size} ${CEILING}h${2 * size}${ticks}` });
  return { wall, path: () => draw([x + offset, CEILING], [mass.at[0] + offset, mass.at[1] - mass.half]) };
}

/** A spring that couples both directions of a mass lies across. */
function cornered(mass, draw, offset) {
  const [x, y] = [mass.home[0] - 46, mass.home[1] - 44];
  const wall = svg("path", { class: "wall", d: `M${x - 9} ${y + 9}l18 -18M${x - 6} ${y + 6}h-6M${x} ${y}h-6M${x + 6} ${y - 6}h-6` });
  return { wall, path: () => draw([x + offset, y], [mass.at[0] - mass.half + offset, mass.at[1] - mass.half]) };
}

function hatched([x, y], half, side) {
  const ticks = [-0.8, -0.3, 0.2, 0.7].map((place) => `M${x} ${y + place * half}l${side * 5} 4`).join("");
  return `M${x} ${y - half}v${2 * half}${ticks}`;
}

function strokes(from, to, y, gone) {
  const count = Math.floor((to - from) / HATCH);
  return Array.from({ length: count }, (_, i) => `M${(from + i * HATCH + gone + 5).toFixed(1)} ${(y + 1).toFixed(1)}l-5 7`).join("");
}

/** A dashpot from one point to another. */
function dashpot(from, to) {
  const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
  const length = Math.hypot(dx, dy) || 1e-9;
  const at = (share, side) => `${(from[0] + share * dx - (side * dy) / length).toFixed(2)} ${(from[1] + share * dy + (side * dx) / length).toFixed(2)}`;
  return `M${at(0, 0)}L${at(0.38, 0)}M${at(0.66, -4)}L${at(0.38, -4)}L${at(0.38, 4)}L${at(0.66, 4)}M${at(0.54, -3)}L${at(0.54, 3)}M${at(0.54, 0)}L${at(1, 0)}`;
}

function arrows(pulled, { along, across }, half) {
  const pulls = [along, across].filter((body) => pulled.includes(body));
  return svg("g", {}, ...pulls.map((body) => svg("path", {
    class: "force-arrow",
    d: body === across ? `M0 ${-half - 20}v14m-3 -4l3 4l3 -4` : `M${half * 0.2} ${-half - 7}h16m-4 -3l4 3l-4 3`,
  })));
}
