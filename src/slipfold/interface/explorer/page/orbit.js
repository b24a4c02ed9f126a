/** One orbit in all its pictures, at one moment. */

import { afterFrame, element } from "./dom.js";
import { Cursor, Player } from "./player.js";
import { axisTitle, display, formatted, modeOf, modeText, withUnit } from "./quantities.js";
import { SmallPlot } from "./small_plot.js";
import { Schematic } from "./model/schematic.js";
import { Mechanism, PhaseAnimation, sampled } from "./stages.js";

const FLOOR = 1e-6;
const CIRCLE = Array.from({ length: 121 }, (_, i) => (i * Math.PI) / 60);

/**
 * @typedef {object} Orbit
 * @property {object} answer the server's
 * @property {(name: string) => object} quantity describes a state or output
 * @property {boolean} isForced
 * @property {Record<string, string>} rates states that are rates of others, by the names of these
 * @property {{force: string, along: Record<string, number>}[]} loops friction forces that are outputs, and
 *   the displacements along them as sums of states
 */

/**
 * All pictures. What an orbit has no picture of leaves its place blank, so that nothing moves where
 * an equilibrium is looked at between two cycles.
 * @param {(phase: number) => void} onPhase hears where the pointer is in time
 * @returns {{plot: SmallPlot, fits: (orbit: Orbit) => boolean, isBlank?: (orbit: Orbit) => boolean, draw: (orbit: Orbit) => void,
 * point: (orbit: Orbit, phase: number) => void}[]}
 */
function orbitPlots(onPhase) {
  return [
    timeSeries(onPhase), phasePortrait(), path(), frictionLoop(), spectrum(), multipliers(), eigenvalues(),
    forces(onPhase),
  ];
}

function timeSeries(onPhase) {
  return overTime("time", "Time series", onPhase, displacements, ({ states }) => states);
}

function forces(onPhase) {
  return overTime("forces", "Forces", onPhase, () => ["N", "Fx", "Fy"], ({ outputs }) => outputs);
}

/**
 * Quantities over time.
 * @param {(orbit: Orbit) => string[]} names
 * @param {(answer: object) => Record<string, number[]>} values
 */
function overTime(id, title, onPhase, names, values) {
  const plot = new SmallPlot(id, title, { onPoint: (time) => onPhase(time / plot.length) });
  return {
    plot,
    fits: (orbit) => names(orbit).every((name) => name in values(orbit.answer)),
    isBlank: isEquilibrium,
    draw: (orbit) => drawOverTime(plot, orbit, names(orbit), values(orbit.answer)),
    point: (_orbit, phase) => plot.point({ x: phase * plot.length }),
  };
}

/** Draw quantities over time: in forcing periods, or in seconds where nothing forces. */
function drawOverTime(plot, { answer, quantity, isForced }, names, values) {
  const duration = answer.t.at(-1) - answer.t[0];
  plot.length = isForced ? answer.period : duration;
  const time = answer.t.map((t) => ((t - answer.t[0]) / (duration || 1)) * plot.length);
  const drawn = names.map((name) => quantity(name) ?? { name });
  const units = new Set(drawn.map((item) => display(item).unit));
  // Quantities with different units share an axis only as fractions of their largest values.
  const sizeOf = (name) => (units.size === 1 ? 1 : Math.max(...values[name].map(Math.abs)) || 1);
  plot.draw({
    x: { label: isForced ? "time (forcing periods)" : "time (s)", range: [0, plot.length] },
    y: { label: units.size > 1 ? "over largest" : axisTitle(...drawn) },
    lines: names.map((name, i) => ({
      x: time, y: values[name].map((value) => value / sizeOf(name)), tint: `tint-${i + 1}`, name: drawn[i].label ?? name,
    })),
  });
}

function phasePortrait() {
  const pair = ({ answer: { states }, rates }) => {
    const [first, second = first] = Object.keys(states);
    return [first, rates[first] ?? second];
  };
  // Without a mechanism the phase plane is the stage itself.
  return portrait(new SmallPlot("phase", "Phase portrait"), pair, ({ mechanism }) => mechanism !== null);
}

function path() {
  const isPlanar = ({ states, mechanism }) => "x" in states && "y" in states && mechanism?.kind === "sliding";
  return portrait(new SmallPlot("path", "Path of the tip", { isEqual: true }), () => ["x", "y"], isPlanar);
}

/** Friction forces over the displacements of their contacts: what no simulation shows of contacts that never stick. */
function frictionLoop() {
  const plot = new SmallPlot("loop", "Friction loop");
  const seen = ({ answer, loops }) => loops.filter(({ force }) => force in answer.outputs);
  const displaced = ({ states }, { along }) => {
    const parts = Object.entries(along);
    return states[parts[0][0]].map((_, i) => parts.reduce((sum, [name, weight]) => sum + weight * states[name][i], 0));
  };
  return {
    plot,
    fits: (orbit) => seen(orbit).length > 0,
    isBlank: isEquilibrium,
    draw: (orbit) => {
      const all = seen(orbit);
      const alone = all.length === 1 && Object.values(all[0].along).join() === "1";
      const [moved] = Object.keys(all[0].along).map(orbit.quantity);
      plot.draw({
        x: { label: alone ? axisTitle(moved) : axisTitle({ ...moved, label: "displacement" }) },
        y: { label: axisTitle({ ...orbit.quantity(all[0].force), label: "friction" }) },
        lines: all.map((loop, i) => ({
          x: displaced(orbit.answer, loop), y: orbit.answer.outputs[loop.force], tint: `tint-${(i % 3) + 1}`,
          name: all.length > 1 ? orbit.quantity(loop.force).label ?? loop.force : undefined,
        })),
      });
    },
    point: (orbit, phase) => plot.point({
      dots: seen(orbit).map((loop) => ({
        x: sampled(displaced(orbit.answer, loop), phase), y: sampled(orbit.answer.outputs[loop.force], phase), tint: "live",
      })),
    }),
  };
}

/** One state over another, with a dot at the start of each forcing period. */
function portrait(plot, pair, fits) {
  return {
    plot,
    fits: ({ answer }) => fits(answer),
    draw: (orbit) => {
      const { answer, quantity } = orbit;
      const [a, b] = pair(orbit);
      const [x, y] = [answer.states[a], answer.states[b]];
      plot.draw({
        x: { label: axisTitle(quantity(a)) },
        y: { label: axisTitle(quantity(b)) },
        lines: [{ x, y, tint: "tint-1" }],
        dots: stroboscopic(answer).map((i) => ({ x: x[i], y: y[i], tint: "stroboscopic" })),
      });
    },
    point: (orbit, phase) => plot.point({ dots: [dotAt(orbit.answer.states, pair(orbit), phase)] }),
  };
}

function spectrum() {
  const plot = new SmallPlot("spectrum", "Spectrum");
  return {
    plot,
    fits: () => true,
    isBlank: ({ answer }) => answer.spectrum.frequency.length <= 1 || isEquilibrium({ answer }),
    draw: (orbit) => {
      const { answer: { spectrum: { frequency, amplitude } }, quantity } = orbit;
      const names = displacements(orbit).filter((name) => name in amplitude);
      const largest = Math.max(...names.flatMap((name) => amplitude[name]));
      if (!(largest > 0)) {
        plot.draw({ x: { label: "frequency (Hz)", ticks: [] }, y: { label: "amplitude", rows: [] }, lines: [], notes: ["It stands still."] });
        return;
      }
      const seen = names.map((name) => {
        const kept = frequency.map((_, i) => i).filter((i) => amplitude[name][i] > FLOOR * largest);
        return { kept, name };
      });
      const top = Math.max(...seen.flatMap(({ kept }) => kept.map((i) => frequency[i])), 0);
      const decade = Math.ceil(Math.log10(largest));
      // Lines of two states at one frequency stand beside each other.
      const step = top * 0.006;
      const all = seen.map(({ kept, name }, i) => ({
        x: kept.map((k) => frequency[k] + (i - (names.length - 1) / 2) * step),
        y: kept.map((k) => amplitude[name][k]),
        tint: `tint-${i + 1}`,
      }));
      plot.draw({
        x: { label: "frequency (Hz)", range: [-0.02 * top, 1.04 * top || 1] },
        y: { label: "amplitude", isLog: true, range: [decade + Math.log10(FLOOR), decade + 0.2] },
        lines: seen.map(({ name }, i) => ({
          x: [], y: [], tint: `tint-${i + 1}`, name: quantity(name)?.label ?? name,
        })),
        stems: all,
        dots: all.flatMap(({ x, y, tint }) => x.map((value, k) => ({ x: value, y: y[k], tint: `head ${tint}` }))),
      });
    },
    point: () => {},
  };
}

function multipliers() {
  const plot = new SmallPlot("multipliers", "Floquet multipliers", { isEqual: true });
  return {
    plot,
    fits: (orbit) => !isEquilibrium(orbit),
    draw: ({ answer }) => {
      const far = Math.max(1.25, ...answer.multipliers.map(([re, im]) => 1.12 * Math.hypot(re, im)));
      const outside = answer.multipliers.filter(([re, im]) => Math.hypot(re, im) > 1);
      plot.draw({
        x: { label: "real part", range: [-far, far] },
        y: { label: "imaginary part", range: [-far, far] },
        lines: [
          { x: CIRCLE.map(Math.cos), y: CIRCLE.map(Math.sin), tint: "faint" },
          { x: [-far, far], y: [0, 0], tint: "faint dash" },
          { x: [0, 0], y: [-far, far], tint: "faint dash" },
        ],
        dots: answer.multipliers.map(([x, y]) =>
          ({ x, y, tint: Math.hypot(x, y) > 1 ? "outside" : "inside" })),
      }, `Floquet multipliers: moduli ${answer.multipliers.map(([re, im]) =>
        formatted(Math.hypot(re, im), 3)).join(", ")}; ${outside.length} outside the unit circle`);
    },
    point: () => {},
  };
}

function isEquilibrium({ answer }) {
  return Boolean(answer.eigenvalues);
}

/** Of an equilibrium: it has no period over which multipliers could be taken. */
function eigenvalues() {
  const plot = new SmallPlot("eigenvalues", "Eigenvalues");
  return {
    plot,
    fits: isEquilibrium,
    draw: ({ answer }) => {
      const modes = answer.eigenvalues.filter(([, im]) => im >= 0).map(modeOf);
      const far = 1.2 * Math.max(...modes.map(({ damping }) => Math.abs(damping))) || 1;
      const top = 1.2 * Math.max(...modes.map(({ frequency }) => frequency)) || 1;
      const right = answer.eigenvalues.filter(([re]) => re > 0).length;
      plot.draw({
        x: { label: "damping ratio (%)", range: [-far, far] },
        y: { label: "frequency (Hz)", range: [-0.05 * top, top] },
        lines: [
          { x: [-far, far], y: [0, 0], tint: "faint dash" },
          { x: [0, 0], y: [-0.05 * top, top], tint: "faint" },
        ],
        dots: modes.map(({ damping, frequency }) =>
          ({ x: damping, y: frequency, tint: damping < 0 ? "outside" : "inside" })),
      }, `Eigenvalues: ${answer.eigenvalues.filter(([, im]) => im >= 0).map(modeText).join("; ")}; ${right} with a positive real part`);
    },
    point: () => {},
  };
}

/** The states that are no rates of others, or have a rate themselves; three at most. */
function displacements({ answer: { states }, rates }) {
  const speeds = new Set(Object.values(rates));
  return Object.keys(states).filter((name) => !speeds.has(name) || name in rates).slice(0, 3);
}

/** The samples at phase zero of each forcing period. */
function stroboscopic({ t, period }) {
  const each = (t.length - 1) / period;
  return Number.isInteger(each) ? Array.from({ length: period }, (_, i) => i * each) : [0];
}

function dotAt(states, [a, b], phase) {
  return { x: sampled(states[a], phase), y: sampled(states[b], phase), tint: "live" };
}

export class OrbitPanel {
  cursor = new Cursor();
  /** Which orbit it is, in words. */
  title = element("p", { class: "orbit-title", id: "orbit-title" });
  /** The element to put on the page. */
  node;
  #session;
  #orbit = null;
  #plots = orbitPlots((phase) => this.cursor.scrub(phase));
  #mechanism = new Mechanism();
  #schematic = new Schematic();
  #portrait = new PhaseAnimation();
  #stage = element("div", { class: "stage" });
  #grid = element("div", { class: "smalls", tabindex: "0", role: "group", "aria-label": "Pictures of the orbit" }, ...this.#plots.map(({ plot }) => plot.node));
  #player = new Player(this.cursor);
  /** What arrived last, and whether it is still to be shown. */
  #arrived = null;
  #isDue = false;
  #takeSoon = afterFrame(() => this.#isDue && this.#take());

  constructor(session) {
    this.#session = session;
    this.node = element("div", { class: "orbit former" },
      element("div", { class: "stage-column" }, this.#stage, this.#player.node), this.#grid);
    this.cursor.moved.subscribe((phase) => this.#point(phase));
    session.orbitArrived.subscribe((arrived) => {
      this.#arrived = arrived;
      this.#isDue = true;
      // While a slider moves the curve comes first.
      if (session.store.isLive) this.#takeSoon();
      else this.#take();
    });
    session.orbitAwaited.subscribe(() => this.shown || this.#none());
    session.failed.subscribe(({ kind, sentence }) => {
      if (kind === "orbit" && sentence && !this.shown) this.title.textContent = `There is no orbit: ${sentence}`;
    });
    this.#none();
    for (const signal of [session.orbitAwaited, session.failed]) {
      signal.subscribe(() => this.#markBusy());
    }
  }

  #take() {
    if (this.#arrived) this.#show(this.#arrived);
    else this.#none();
    this.#isDue = false;
    this.#markBusy();
  }

  /** The orbit shown: the server's answer, the view it belongs to and its request. */
  get shown() {
    return this.node.classList.contains("empty") ? null : this.#orbit;
  }

  /** What the server makes a file of: a script that finds the orbit again needs no branch, and waits for none. */
  requestFor(format) {
    const { answer, request } = this.#orbit;
    return format === "python" && answer.again ? { ...request, at: answer.through } : request;
  }

  /** All pictures that are seen with their captions, for a file. */
  get figures() {
    const seen = this.#plots.filter(isSeen).map(({ plot }) => plot);
    return [this.#stageOf(this.#orbit.answer), ...seen].map(({ figure }) => figure);
  }

  #show({ answer, place, view, request }) {
    const isFirst = this.#orbit === null;
    const { model } = this.#session;
    // The motion runs on while another model is computed: its quantities are those of its own model.
    const described = [...model.parameters, ...model.states, ...model.outputs];
    const quantity = (name) => described.find((item) => item.name === name);
    this.#orbit = { answer, quantity, isForced: model.forced, rates: model.rates, loops: model.loops, view, request };
    this.cursor.adopt(answer.t.at(-1) - answer.t[0], model.forced ? answer.period : 1);
    const stage = this.#stageOf(answer);
    if (stage.node.parentNode !== this.#stage) this.#stage.replaceChildren(stage.node);
    stage.adopt(answer, parametersOf(view, answer), quantity);
    for (const picture of this.#plots) {
      const { node } = picture.plot;
      node.hidden = !picture.fits(this.#orbit);
      node.classList.toggle("absent", Boolean(picture.isBlank?.(this.#orbit)));
      if (isSeen(picture)) picture.draw(this.#orbit);
    }
    this.node.classList.remove("empty", "former");
    this.#player.node.classList.toggle("absent", Boolean(answer.eigenvalues));
    this.title.textContent = titleOf(answer, place, this.#session.quantity(view.vary), model.forced);
    this.title.title = this.title.textContent; // two lines may be too few
    this.#point(this.cursor.phase);
    this.#player.adopted(isFirst);
    this.node.dataset.drawn = answer.value;
    this.node.dataset.period = answer.period;
  }

  /** Mark the panel as busy while its orbit is computed. */
  #markBusy() {
    this.node.setAttribute("aria-busy", String(this.#isDue || this.#session.requests.isBusy("orbit")));
  }

  #none() {
    const { view, diagram, hasFailed, isMore, place } = this.#session;
    const parameter = this.#session.quantity(view.vary);
    const value = withUnit(parameter, view.parameters[view.vary]);
    const way = isMore ? " yet" : "; move it, widen the span, or simulate and follow that motion";
    const missing = `No branch of the diagram reaches ${parameter.label ?? parameter.name} = ${value}${way}.`;
    const failed = "There is no orbit, since the response could not be computed.";
    const absent = place ? "Computing the orbit…" : missing;
    this.title.textContent = hasFailed ? failed : diagram ? absent : "Computing the response…";
    this.node.classList.add("empty");
    // A motion of another model has no place beside the name of this one, nor have captions of nothing.
    this.node.classList.toggle("former", !diagram || !this.#orbit);
  }

  #stageOf(answer) {
    const stages = { sliding: this.#mechanism, row: this.#schematic };
    return stages[answer.mechanism?.kind] ?? this.#portrait;
  }

  #point(phase) {
    if (!this.#orbit) return;
    this.#stageOf(this.#orbit.answer).show(phase);
    for (const picture of this.#plots) {
      if (isSeen(picture)) picture.point(this.#orbit, phase);
    }
  }
}

function isSeen({ plot: { node } }) {
  return !node.hidden && !node.classList.contains("absent");
}

function parametersOf(view, answer) {
  return { ...view.parameters, [view.vary]: answer.value ?? view.parameters[view.vary] };
}

function titleOf(answer, place, vary, isForced) {
  const at = `${vary.label ?? vary.name} = ${withUnit(vary, place.special ? place.x : answer.value ?? place.x)}`;
  // On a special point it is rounding that says on which side of stability it is.
  const kind = place.special ? place.special.words : answer.stability;
  if (answer.eigenvalues) {
    return `${at}: equilibrium, ${kind}; rightmost eigenvalue: ${modeText(answer.eigenvalues[0])}`;
  }
  const largest = (values) => formatted(Math.max(0, ...values.map(([re, im]) => Math.hypot(re, im))), 4);
  if (isForced) return `${at}: period ${answer.period}, ${kind}; largest multiplier ${largest(answer.multipliers)}`;
  const duration = answer.t.at(-1) - answer.t[0];
  const cycle = `cycle of ${formatted(duration)}\u202fs (${formatted(1 / duration)}\u202fHz)`;
  return `${at}: ${cycle}, ${kind}; largest other multiplier ${largest(withoutOne(answer.multipliers))}`;
}

/** Multipliers of a cycle but that of its own direction, which is one. */
function withoutOne(multipliers) {
  const gaps = multipliers.map(([re, im]) => Math.hypot(re - 1, im));
  return multipliers.toSpliced(gaps.indexOf(Math.min(...gaps)), 1);
}
