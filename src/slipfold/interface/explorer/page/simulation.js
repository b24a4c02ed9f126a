/** A simulation, its Lyapunov exponents, and their panel. */

import { ContactPanel } from "./model/contacts.js";
import { valueTitle } from "./diagram_plot.js";
import { button, element } from "./dom.js";
import { MotionPanel } from "./motion.js";
import { asSentence, axisTitle, formatted, withUnit } from "./quantities.js";
import { SmallPlot } from "./small_plot.js";
import { Signal } from "./store.js";
import { SweepControl } from "./sweep.js";
import { exponentsRequest, partsOf, simulationRequest, solutionOf, systemOf } from "./view.js";

const PERIODS = 600;

/** Sections that are drawn of a motion at most, and periods of a request, as the server bounds them. */
const MOST = 2000;
const MOST_PERIODS = 20000;

/** Intervals of an autonomous motion that hold a round of it before its period is known. */
const ROUND = 4;

export class Simulation {
  /** Announces `{isRunning, verdict, max, min, x}` whenever something has come. */
  changed = new Signal();
  state = nothing();
  #session;
  #began = {};

  constructor(session) {
    this.#session = session;
    session.failed.subscribe(({ kind, sentence }) => {
      if (kind === "simulation" && sentence) this.#become({ isRunning: false });
    });
    session.connection.changed.subscribe(({ state }) => {
      if (this.state.isRunning && state !== "open") this.stop("the connection was lost");
    });
    session.store.changed.subscribe(({ view, before }) => {
      if (systemOf(view) !== systemOf(before)) this.clear();
    });
  }

  /** What was simulated and how it ended, in words. */
  get title() {
    const { view, verdict } = this.state;
    const vary = this.#session.quantity(view.vary);
    const at = `${vary.label ?? vary.name} = ${withUnit(vary, view.parameters[view.vary])}`;
    const { start, perturbation } = this.#began;
    const states = Object.entries(start).map(([name, value]) => `${name} = ${formatted(value)}`).join(", ");
    const from = start === "rest" ? "rest" : perturbation ? "a perturbed orbit" : states;
    return `${at}, simulated from ${from}: ${verdict}`;
  }

  /** How the motion began: as it was simulated last, else from rest. */
  get start() {
    if (this.state.view === null) return { start: "rest" };
    const { start, perturbation = {} } = this.request;
    return { start, perturbation };
  }

  /** The last state and the parameter's value of a simulation that has ended, null of others. */
  get shown() {
    const { isRunning, last, view, x } = this.state;
    return isRunning || !last || view.vary !== this.#session.view.vary ? null : { value: x, state: last };
  }

  /** From rest, at the working point. */
  fromRest() {
    this.#run({ start: "rest", periods: PERIODS });
  }

  /** From some states, the others being the model's own. */
  fromStates(start) {
    this.#run({ start, periods: PERIODS });
  }

  /**
   * From a perturbed orbit.
   * @param {object} orbit the server's answer
   * @param {number} share of its own size by which the first state is moved
   */
  fromOrbit(orbit, share) {
    const start = Object.fromEntries(
      Object.entries(orbit.states).map(([name, values]) => [name, values[0]]));
    const [name, values] = Object.entries(orbit.states)[0];
    const size = Math.max(...values.map(Math.abs), 1e-6);
    this.#run({ start, perturbation: { [name]: share * size }, periods: PERIODS });
  }

  /** From where it is, for some more periods or intervals; what was drawn stays. */
  goOn(periods) {
    const { last, view, interval } = this.state;
    const timed = this.#session.model.forced ? {} : { interval };
    this.#ask(view, { start: last, periods, ...timed });
  }

  /** Stop computing. */
  stop(why = null) {
    this.#session.requests.cancel("simulation");
    const { far } = this.state;
    const verdict = `Stopped${far ? ` after ${far}` : ""}${why ? `: ${why}` : ""}.`;
    this.#become({ isRunning: false, verdict });
  }

  /** Forget it. */
  clear() {
    if (this.state.view === null) return;
    this.#session.forget("simulation");
    this.#forgetViews();
    this.state = nothing();
    this.changed.announce(this.state);
  }

  /** What the diagram draws of each period; where nothing forces, of the round that ends there. */
  values(show, statistic) {
    if (!(show in this.state.max)) return [];
    const max = { [show]: latest(this.state.max[show], this.#inRound, Math.max) };
    const min = { [show]: latest(this.state.min[show], this.#inRound, Math.min) };
    const of = {
      max: (i) => max[show][i],
      min: (i) => min[show][i],
      peak_to_peak: (i) => max[show][i] - min[show][i],
      modulus: (i) => Math.max(Math.abs(max[show][i]), Math.abs(min[show][i])),
    };
    return max[show].flatMap((_, i) => partsOf(statistic).map((part) => of[part](i)));
  }

  #run(how) {
    const { view } = this.#session;
    this.state = { ...nothing(), view, x: view.parameters[view.vary] };
    this.#began = how;
    this.#ask(view, how);
  }

  /** What is asked about a motion ends with it. */
  #forgetViews() {
    for (const kind of ["motion", "sound"]) this.#session.forget(kind);
  }

  #ask(view, how) {
    this.#forgetViews();
    this.#become({ isRunning: true, far: "", longer: null });
    this.request = simulationRequest(view, how);
    this.#session.ask(this.request, (answer) => this.#take(answer), () => this.#ask(view, how));
  }

  #take({ far, sections, done, verdict, last = null, longer = null, duration = null, contacts = null, settled = false, period = null }) {
    if (far) {
      this.#become({ far, verdict: `After ${far}…` });
    } else if (done) {
      const sentence = contacts?.words ? `${this.state.verdict}. ${contacts.words}` : this.state.verdict;
      this.#become({ isRunning: false, contacts, verdict: sentence });
    } else {
      this.#become({ ...this.#joined(sections), cycle: duration ?? this.state.cycle, last, longer, settled, period, verdict });
    }
  }

  /** What was known with what is new behind it. */
  #joined(sections) {
    if (!sections) return {};
    const { ends, max, min } = this.state;
    const { count, periods, duration, max: high, min: low } = sections;
    const step = this.#session.model.forced ? periods : duration;
    const begin = ends.at(-1) ?? 0;
    const names = Object.keys(high).filter((name) => ends.length === 0 || name in max);
    const joined = (before, after) =>
      Object.fromEntries(names.map((name) => [name, [...(before[name] ?? []), ...after[name]]]));
    const all = {
      ends: [...ends, ...Array.from({ length: count }, (_, i) => begin + (i + 1) * step)],
      max: joined(max, high), min: joined(min, low),
    };
    return { ...thinned(all), interval: duration / periods };
  }

  /** Periods, or intervals, over which the motion passes wherever it does. */
  get #inRound() {
    const { cycle, ends } = this.state;
    if (this.#session.model.forced) return 1;
    return cycle ? Math.ceil(cycle / (ends.at(-1) - ends.at(-2))) + 1 : ROUND;
  }

  #become(changes) {
    this.state = { ...this.state, ...changes };
    this.changed.announce(this.state);
  }
}

function nothing() {
  return {
    isRunning: false, verdict: "", far: "", ends: [], max: {}, min: {}, x: 0, view: null, interval: 0, cycle: null, last: null, longer: null, settled: false, period: null,
    contacts: null,
  };
}

/** Half as many sections, of the extremes of two each, while there are more than are drawn. */
function thinned({ ends, max, min }) {
  if (ends.length <= MOST) return { ends, max, min };
  const every = (values, extreme) => values.filter((_, i) => i % 2 === 0).map((value, k) => extreme(value, values[2 * k + 1] ?? value));
  const of = (columns, extreme) =>
    Object.fromEntries(Object.entries(columns).map(([name, values]) => [name, every(values, extreme)]));
  return thinned({ ends: every(ends, Math.max), max: of(max, Math.max), min: of(min, Math.min) });
}

/** Of each value and so many before it, the extreme one. */
function latest(values, count, extreme) {
  if (count === 1) return values;
  return values.map((_, i) => extreme(...values.slice(Math.max(i + 1 - count, 0), i + 1)));
}

/** Errors by which an exponent differs from zero if it is said to, as the server judges it. */
const SURE = 3;

/** What rounding may leave of zero. */
const ROUNDING = 1e-9;

const NAMES = {
  equilibrium: "Equilibrium", periodic: "Periodic", torus: "Torus", chaos: "Chaos", undecided: "Undecided",
};

/** A kind of motion with which a message begins, which is named before it. */
const NAMED = /^(periodic|chaotic|undecided): /;

export class Exponents {
  /** The element to put on the page. */
  node;
  #session;
  #simulation;
  #result = element("p", { role: "status", id: "exponents" });
  #stop;
  #simulated;

  constructor(session, simulation) {
    this.#session = session;
    this.#simulation = simulation;
    this.#stop = button("Stop classifying", () => this.#clear(), { class: "quiet", hidden: true });
    this.node = element("div", { class: "exponents" },
      element("div", { class: "sentence" },
        button("Torus or chaos?", () => this.#ask(), { title: "Classify this motion by its Lyapunov exponents" }), this.#stop),
      this.#result);
    session.store.changed.subscribe(({ view, before }) => {
      if (solutionOf(view) !== solutionOf(before)) this.#clear();
    });
    simulation.changed.subscribe(() => simulation.request !== this.#simulated && this.#clear());
    session.failed.subscribe(({ kind, sentence }) => kind === "exponents" && sentence && this.#show([], false));
  }

  #ask() {
    this.#simulated = this.#simulation.request;
    const request = exponentsRequest(this.#session.view, this.#simulation.start);
    const onAnswer = (answer) => this.#show(answer.done ? this.#verdict(answer) : this.#progress(answer), !answer.done);
    this.#show(["Following the motion and its perturbations…"], true);
    this.#session.ask(request, onAnswer, () => this.#ask());
  }

  #clear() {
    this.#session.forget("exponents");
    this.#show([], false);
  }

  #show(parts, isRunning) {
    this.#result.replaceChildren(...parts);
    this.#stop.hidden = !isRunning;
  }

  #progress({ periods, total, exponents }) {
    const isForced = this.#session.model.forced;
    const far = isForced ? `${periods} of at most ${total} periods` : `${Math.round((100 * periods) / total)} % of the longest time`;
    const known = exponents.length ? `; exponents ${listed(exponents)} so far` : "";
    return [`After ${far}${known}…`];
  }

  #verdict({ kind_of_motion: kind, period, message, exponents, errors, per, dimension }) {
    const name = period ? `Period ${period}` : NAMES[kind];
    const broken = kind === "chaos" ? ` Dimension, by the conjecture of Kaplan and Yorke: ${formatted(dimension, 3)}.` : "";
    return [element("strong", {}, name), `: ${message.replace(NAMED, "")}. Exponents per ${per}: ${listed(exponents, errors)}.${broken}`];
  }
}

/** Exponents as text: 0 for what cannot be distinguished from zero, minus infinity for null; without an error, a bound. */
function listed(exponents, errors = exponents.map(() => 0)) {
  const texts = exponents.map((value, i) => {
    if (value === null) return "−∞";
    const error = errors[i];
    if (error === null) return `below ${formatted(value, 2)}`;
    return Math.abs(value) <= SURE * error + ROUNDING ? "0" : formatted(value, digitsOf(value, error));
  });
  return texts.join(", ");
}

/** Digits that an error leaves, four at most. */
function digitsOf(value, error) {
  if (error === 0) return 4;
  return Math.min(Math.max(Math.floor(Math.log10(Math.abs(value) / error)) + 1, 1), 4);
}

const NUDGES = { "0.001": "0.1 %", "0.01": "1 %", "0.1": "10 %" };

export class SimulationPanel {
  /** The element to put on the page. */
  node;
  #simulation;
  #session;
  #verdict = element("p", { class: "verdict", role: "status" });
  #plot = new SmallPlot("settling", "Settling");
  #perturbation = element("select", { "aria-label": "Perturbation" },
    ...Object.entries(NUDGES).map(([value, text]) => element("option", { value }, text)));
  #contacts;
  #motion;
  #more = element("div", { class: "sentence" });
  #periods = element("input", {
    type: "number", class: "number", min: 1, max: MOST_PERIODS, step: 1, required: true, "aria-label": "Periods to go on for",
  });
  #unit = element("span");
  #stop;
  #clear;
  #fromOrbit;
  #drawn = [];
  #longer;

  constructor(session, simulation, sweep, diagram, orbits, page) {
    this.#session = session;
    this.#simulation = simulation;
    this.#perturbation.value = "0.01";
    this.#fromOrbit = button("From this orbit", () =>
      simulation.fromOrbit(orbits.shown.answer, Number(this.#perturbation.value)));
    this.#fromOrbit.disabled = true;
    this.#periods.addEventListener("keydown", ({ key }) => key === "Enter" && this.#goOn());
    this.#more.append(button("Go on", () => this.#goOn()), element("span", {}, "for"), this.#periods, this.#unit);
    this.#stop = button("Stop", () => simulation.stop(), { class: "quiet" });
    this.#clear = button("Clear", () => simulation.clear(), { class: "quiet" });
    this.#contacts = new ContactPanel(session, simulation);
    this.#motion = new MotionPanel(session, simulation);
    this.node = element("div", { class: "simulation" },
      element("div", { class: "sentence" },
        button("From rest", () => simulation.fromRest()), this.#fromOrbit,
        element("label", { class: "choice" }, element("span", {}, "perturbed by"), this.#perturbation),
        this.#stop, this.#clear),
      element("div", { class: "ending" }, this.#verdict, this.#more), new Exponents(session, simulation).node,
      new SweepControl(sweep, () => simulation.shown ?? session.startOfOrbit(session.view.parameters[session.view.vary]), page).node, this.#plot.node, this.#motion.node,
      this.#contacts.node);
    simulation.changed.subscribe(() => this.#show(diagram));
    session.store.changed.subscribe(({ view, before }) => {
      if (view.model !== before.model || view.show !== before.show || view.statistic !== before.statistic) this.#show(diagram);
    });
    session.orbitArrived.subscribe((arrived) => { this.#fromOrbit.disabled = !arrived; });
    this.#show(diagram);
  }

  /** All drawings with their captions, for a file. */
  get figures() {
    return [this.#plot.figure, ...this.#motion.figures, ...this.#contacts.figures];
  }

  #goOn() {
    if (this.#periods.reportValidity()) this.#simulation.goOn(Number(this.#periods.value));
  }

  #show(diagram) {
    const { isRunning, verdict, ends, last, longer, interval, x } = this.#simulation.state;
    const count = ends.length;
    const { forced: isForced } = this.#session.model;
    this.#more.hidden = isRunning || last === null;
    if (longer !== this.#longer) this.#periods.value = longer ?? PERIODS;
    this.#longer = longer;
    this.#unit.textContent = isForced ? "periods" : `intervals of ${formatted(interval)}\u202fs`;
    this.#stop.hidden = !isRunning;
    this.#clear.hidden = isRunning || count === 0;
    this.#verdict.textContent = asSentence(verdict);
    this.#plot.node.hidden = count === 0 && !isRunning;
    const { show, statistic, vary } = this.#session.view;
    const { max, cycle } = this.#simulation.state;
    const drawn = [max, cycle, show, statistic, vary, Boolean(this.#session.diagram)];
    if (drawn.every((item, i) => item === this.#drawn[i])) return;
    this.#drawn = drawn;
    const y = this.#simulation.values(show, statistic);
    const isSame = this.#simulation.state.view?.vary === vary;
    if (this.#session.diagram) diagram.simulated(y.length && isSame ? { x, y } : null);
    if (y.length === 0) return;
    const quantity = { ...this.#session.quantity(show), statistic };
    const [first, other = { max: "min", min: "max" }[first]] = partsOf(statistic);
    const clouds = [first, ...(other ? [other] : [])].map((name, i) => ({
      x: ends, y: this.#simulation.values(show, name), tint: `settling ${i ? "other" : ""}`, name,
    }));
    this.#plot.draw({
      x: { label: isForced ? "forcing period" : "time (s)", range: [0, ends.at(-1)] },
      y: { label: other ? axisTitle(quantity) : valueTitle({ ...quantity, label: quantity.label ?? show }) },
      lines: other ? clouds.map(({ tint, name }) => ({ x: [], y: [], tint, name })) : [],
      clouds,
    }, `Simulation: ${verdict}`);
  }
}
