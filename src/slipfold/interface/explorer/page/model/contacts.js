/** What contacts do at the end of a simulation: pictures and panel. */

import { element } from "../dom.js";
import { Cursor, Player } from "../player.js";
import { Schematic } from "./schematic.js";
import { SmallPlot } from "../small_plot.js";
import { Belts, Mechanism, PhaseAnimation } from "../stages.js";

/** What a contact does, in words, in the order of the legend. */
const WORDS = { stick: "sticks", forth: "slips forth", back: "slips back", open: "open" };

const AXES = ["x", "y"];

/**
 * @typedef {object} Piece a time in which a contact does one thing
 * @property {keyof WORDS} state
 * @property {number[]} t
 * @property {number[][]} slip by direction
 * @property {number[][]} friction by direction
 * @property {number[][]|null} displacement by direction; null where the equations have none
 * @typedef {{name: string, plate: number[], units: string[], pieces: Piece[]}} Contact
 *   units of displacement, slip and force
 * @typedef {{contacts: Contact[], isForced: boolean}} Shown
 */

/**
 * All pictures.
 * @param {(time: number) => void} onTime hears where the pointer is in time
 */
function contactPlots(onTime) {
  return [
    timeline(onTime),
    loop("hysteresis", "Hysteresis", "displacement", 0, "displacement"),
    loop("friction", "Friction over slip", "slip velocity", 1, "slip"),
    path(),
  ];
}

/** What each contact does at a time. */
function doingAt(contacts, time) {
  return contacts.map(({ pieces }) => pieceAt(pieces, time).state);
}

function timeline(onTime) {
  const plot = new SmallPlot("timeline", "Stick and slip", { onPoint: onTime });
  return {
    plot,
    fits: () => true,
    draw: ({ contacts, isForced }) => {
      const seen = new Set(contacts.flatMap(({ pieces }) => pieces.map(({ state }) => state)));
      const isPlanar = contacts.every(({ plate }) => plate.length > 1);
      const { t } = contacts[0].pieces.at(-1);
      plot.draw({
        x: { label: isForced ? "time (forcing periods)" : "time (s)", range: [0, t.at(-1)] },
        y: { label: "", range: [contacts.length - 0.5, -0.5], rows: contacts.map(({ name }) => name) },
        lines: Object.keys(WORDS).filter((state) => seen.has(state)).map((state) => ({
          x: [], y: [], tint: `doing ${state}`,
          name: isPlanar && state === "forth" ? "slips" : WORDS[state],
        })),
        bands: contacts.flatMap(({ pieces }, row) => pieces.map((piece) =>
          ({ x: [piece.t[0], piece.t.at(-1)], row, tint: `doing ${piece.state}` }))),
      }, `When contacts stick: ${contacts.map(described).join("; ")}`);
    },
    point: (_shown, time) => plot.point({ x: time }),
  };
}

/** How often a contact sticks, for those who hear the page. */
function described({ name, pieces }) {
  const spans = pieces.filter(({ state }) => state === "stick")
    .map(({ t }) => `from ${t[0].toPrecision(4)} to ${t.at(-1).toPrecision(4)}`);
  return `${name} ${spans.length ? `sticks ${spans.join(", ")}` : "never sticks"}`;
}

/** A label with the unit, if there is one. */
function labeled(word, unit) {
  return unit ? `${word} (${unit})` : word;
}

function loop(id, title, word, unit, over) {
  const plot = new SmallPlot(id, title);
  return {
    plot,
    fits: ({ contacts }) => contacts.every(({ pieces }) => pieces[0][over] !== null),
    draw: ({ contacts }) => {
      const names = components(contacts).map(({ name }) => name);
      const lines = components(contacts).flatMap(({ pieces, axis }, i) =>
        pieces.map((piece) => ({
          x: piece[over][axis], y: piece.friction[axis], tint: tintOf(i, piece),
        })));
      plot.draw({
        x: { label: labeled(word, contacts[0].units[unit]) },
        y: { label: labeled("friction", contacts[0].units[2]) },
        lines: [...inFront(lines), ...legendOf(names, contacts)],
      });
    },
    point: ({ contacts }, time) => plot.point({
      dots: components(contacts).map(({ pieces, axis }) => {
        const piece = pieceAt(pieces, time);
        return { x: valueAt(piece, piece[over][axis], time), y: valueAt(piece, piece.friction[axis], time), tint: "live" };
      }),
    }),
  };
}

function path() {
  const plot = new SmallPlot("contact-path", "Path of the contact", { isEqual: true });
  return {
    plot,
    fits: ({ contacts }) =>
      contacts.every(({ plate, pieces }) => plate.length > 1 && pieces[0].displacement !== null),
    draw: ({ contacts }) => {
      const lines = contacts.flatMap(({ pieces }, i) => pieces.map((piece) => ({
        x: piece.displacement[0], y: piece.displacement[1], tint: tintOf(i, piece),
      })));
      plot.draw({
        x: { label: labeled("x", contacts[0].units[0]) },
        y: { label: labeled("y", contacts[0].units[0]) },
        lines: [...inFront(lines), ...legendOf(contacts.map(({ name }) => name), contacts)],
      });
    },
    point: ({ contacts }, time) => plot.point({
      dots: contacts.map(({ pieces }) => {
        const piece = pieceAt(pieces, time);
        const [x, y] = piece.displacement.map((values) => valueAt(piece, values, time));
        return { x, y, tint: "live" };
      }),
    }),
  };
}

/** Each direction of each contact, with its name. */
function components(contacts) {
  return contacts.flatMap(({ name, plate, pieces }) => plate.map((_, axis) => {
    const along = plate.length > 1 ? [AXES[axis]] : [];
    const words = [...(contacts.length > 1 ? [name] : []), ...along];
    return { name: words.join(", ") || name, pieces, axis };
  }));
}

function tintOf(i, { state }) {
  return `tint-${(i % 3) + 1}${state === "stick" ? " stuck" : ""}`;
}

/** What sticks lies on top of what slips. */
function inFront(lines) {
  const isStuck = ({ tint }) => tint.endsWith("stuck");
  return [...lines.filter((line) => !isStuck(line)), ...lines.filter(isStuck)];
}

/** What lines mean: their colors if there are several, and the thick ones if any contact sticks. */
function legendOf(names, contacts) {
  const several = names.length > 1 ? names.map((name, i) => ({ x: [], y: [], tint: `tint-${(i % 3) + 1}`, name })) : [];
  const isStuck = contacts.some(({ pieces }) => pieces.some(({ state }) => state === "stick"));
  return isStuck ? [...several, { x: [], y: [], tint: `${names.length > 1 ? "" : "tint-1 "}stuck`, name: "sticks" }] : several;
}

/** What a contact does at a time. */
export function pieceAt(pieces, time) {
  return pieces.find(({ t }) => t.at(-1) >= time) ?? pieces.at(-1);
}

/** A value between the samples of a piece. */
export function valueAt({ t }, values, time) {
  const after = Math.max(t.findIndex((value) => value >= time), 1);
  const length = t[after] - t[after - 1];
  const share = length > 0 ? Math.min(Math.max((time - t[after - 1]) / length, 0), 1) : 0;
  return values[after - 1] + share * (values[after] - values[after - 1]);
}

export class ContactPanel {
  cursor = new Cursor();
  /** The element to put on the page. */
  node;
  #session;
  #shown = null;
  #isFirst = true;
  #plots = contactPlots((time) => this.#scrub(time));
  #player = new Player(this.cursor, { moment: "Moment at the end", motion: "the end of the motion" });
  #stages = { sliding: new Mechanism("contacts"), row: new Schematic(), belts: new Belts(), phase: new PhaseAnimation("contact-motion") };
  #stage = element("div", { class: "stage" });

  constructor(session, simulation) {
    this.#session = session;
    this.node = element("div", { class: "contacts", "aria-label": "The end of the motion", role: "group" },
      element("div", { class: "stage-column" }, this.#stage, this.#player.node),
      element("div", { class: "smalls" }, ...this.#plots.map(({ plot }) => plot.node)));
    this.cursor.moved.subscribe((phase) => this.#point(phase));
    simulation.changed.subscribe(({ contacts, view, isRunning }) => {
      // While another motion is computed the one before keeps its place.
      this.node.classList.toggle("former-motion", isRunning);
      if (contacts || !isRunning) this.#show(contacts, view);
    });
    this.#show(null, null);
  }

  /** All pictures that are seen, for a file. */
  get figures() {
    if (!this.#shown) return [];
    const seen = this.#plots.filter(({ plot }) => !plot.node.hidden).map(({ plot }) => plot);
    return [this.#stageOf(this.#shown), ...seen].map(({ figure }) => figure);
  }

  #show(answer, view) {
    if (answer === this.#shown?.answer) return;
    this.#shown = answer && { answer, contacts: answer.contacts, mechanism: answer.mechanism, isForced: this.#session.model.forced };
    this.node.hidden = answer === null;
    if (!answer) {
      this.cursor.pause();
      delete this.node.dataset.drawn;
      return;
    }
    this.cursor.adopt(answer.t.at(-1), this.#shown.isForced ? answer.period : 1);
    const stage = this.#stageOf(this.#shown);
    if (stage.node.parentNode !== this.#stage) this.#stage.replaceChildren(stage.node);
    stage.adopt(answer, view.parameters, (name) => this.#session.quantity(name));
    for (const { plot, fits, draw } of this.#plots) {
      plot.node.hidden = !fits(this.#shown);
      if (!plot.node.hidden) draw(this.#shown);
    }
    this.#player.adopted(this.#isFirst);
    this.#isFirst = false;
    this.node.dataset.drawn = answer.words;
    this.#point(this.cursor.phase);
  }

  #stageOf({ mechanism, contacts }) {
    if (mechanism) return this.#stages[mechanism.kind];
    const isLine = contacts.every(({ plate, pieces }) => plate.length === 1 && pieces[0].displacement);
    return isLine ? this.#stages.belts : this.#stages.phase;
  }

  #point(phase) {
    if (!this.#shown) return;
    const time = phase * this.#length;
    const stage = this.#stageOf(this.#shown);
    const doing = doingAt(this.#shown.contacts, time);
    if (stage.at) stage.at(time, phase * this.#shown.answer.t.at(-1));
    else stage.show(phase, doing);
    this.node.dataset.doing = doing.join(" ");
    for (const { plot, point } of this.#plots) if (!plot.node.hidden) point(this.#shown, time);
  }

  #scrub(time) {
    if (this.#shown) this.cursor.scrub(time / this.#length);
  }

  /** How long what is shown lasts, as its pieces have it: in forcing periods, or in s. */
  get #length() {
    return this.#shown.contacts[0].pieces.at(-1).t.at(-1);
  }
}
