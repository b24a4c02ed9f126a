/** A motion as it is computed, period by period. */

import { formatted, withUnit } from "../parameters/quantities.js";
import { Signal } from "../session/signal.js";
import { diagramRequest, simulationRequest } from "../session/view.js";

const PERIODS = 600;

/** Intervals of an autonomous motion that hold a round of it before its period is known. */
const ROUND = 4;

export class Simulation {
  /** Announces `{isRunning, verdict, sections, x}` whenever something has come. */
  changed = new Signal();
  state = nothing();
  #session;

  /** @param {import("../session/session.js").Session} session */
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
    const { start, nudge } = this.request;
    const states = Object.entries(start).map(([name, value]) => `${name} = ${formatted(value)}`).join(", ");
    const from = start === "rest" ? "rest" : nudge ? "an orbit, nudged off it" : states;
    return `${at}, simulated from ${from}: ${verdict}`;
  }

  /** How the motion began: as it was simulated last, else from rest. */
  get start() {
    if (this.state.view === null) return { start: "rest" };
    const { start, nudge = {} } = this.request;
    return { start, nudge };
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
   * From an orbit, nudged off it.
   * @param {object} orbit the server's answer
   * @param {number} share of its own size by which the first state is moved
   */
  fromOrbit(orbit, share) {
    const start = Object.fromEntries(
      Object.entries(orbit.states).map(([name, values]) => [name, values[0]]));
    const [name, values] = Object.entries(orbit.states)[0];
    const size = Math.max(...values.map(Math.abs), 1e-6);
    this.#run({ start, nudge: { [name]: share * size }, periods: PERIODS });
  }

  /** Stop computing; what has come stays. */
  stop(why = null) {
    this.#session.requests.cancel("simulation");
    const verdict = `Stopped after ${this.#progress}${why ? `: ${why}` : ""}.`;
    this.#become({ isRunning: false, verdict });
  }

  /** Forget it. */
  clear() {
    if (this.state.view === null) return;
    this.#session.requests.cancel("simulation");
    this.state = nothing();
    this.changed.announce(this.state);
  }

  /** Where it stands after so many periods: in forcing periods, or in seconds where nothing forces. */
  timeAt(count) {
    return this.#session.model.forced ? count : count * this.state.interval;
  }

  /**
   * What the diagram draws of each period; where nothing forces, of the round that ends there.
   * @param {string} show
   * @param {string} statistic
   * @returns {number[]}
   */
  values(show, statistic) {
    if (!(show in this.state.max)) return [];
    const max = { [show]: latest(this.state.max[show], this.#inRound, Math.max) };
    const min = { [show]: latest(this.state.min[show], this.#inRound, Math.min) };
    const of = {
      max: (i) => max[show][i],
      min: (i) => min[show][i],
      peak_to_peak: (i) => max[show][i] - min[show][i],
      modulus: (i) => Math.max(Math.abs(max[show][i]), Math.abs(min[show][i])),
    }[statistic];
    return max[show].map((_, i) => of(i));
  }

  #run(how) {
    const { view } = this.#session;
    this.state = { ...nothing(), isRunning: true, view, x: view.parameters[view.vary] };
    this.changed.announce(this.state);
    this.request = simulationRequest(view, how);
    const onAnswer = (answer) => this.#take(answer);
    const onError = (sentence, again) => this.#session.failed.announce(
      { kind: "simulation", sentence, again: again ? () => this.#run(how) : null });
    this.#session.failed.announce({ kind: "simulation", sentence: null });
    this.#session.requests.ask(this.request, { onAnswer, onError }, { supersede: true });
  }

  #take({ again, sections, done, verdict, duration = null, contacts = null }) {
    // A motion that comes to rest in a contact is told anew, with its stick.
    if (again) this.#become({ count: 0, max: {}, min: {} });
    const { max, min } = this.state;
    const count = this.state.count + (sections?.period.length ?? 0);
    this.#become({
      count,
      cycle: duration,
      interval: sections?.duration ?? this.state.interval,
      max: sections ? joined(max, sections.max) : max,
      min: sections ? joined(min, sections.min) : min,
      isRunning: !done,
      contacts,
    });
    const told = contacts?.words ? `${verdict}. ${contacts.words}` : verdict;
    this.#become({ verdict: done ? told : `After ${this.#progress}…` });
  }

  get #progress() {
    const { count } = this.state;
    const isForced = this.#session.model.forced;
    return isForced ? `${count} of ${PERIODS} periods` : `${formatted(this.timeAt(count), 3)}\u202fs`;
  }

  /** Periods, or intervals, over which the motion passes wherever it does. */
  get #inRound() {
    const { cycle, interval } = this.state;
    if (this.#session.model.forced) return 1;
    return cycle ? Math.ceil(cycle / interval) + 1 : ROUND;
  }

  #become(changes) {
    this.state = { ...this.state, ...changes };
    this.changed.announce(this.state);
  }
}

/** What a motion shown on the diagram belongs to: everything but the value at which it was started. */
function systemOf(view) {
  const { model, parameters, vary } = diagramRequest(view);
  return JSON.stringify([model, parameters, vary]);
}

function nothing() {
  return {
    isRunning: false, verdict: "", count: 0, max: {}, min: {}, x: 0, view: null, interval: 0, cycle: null, contacts: null,
  };
}

/** Of each value and so many before it, the extreme one. */
function latest(values, count, extreme) {
  return values.map((_, i) => extreme(...values.slice(Math.max(i + 1 - count, 0), i + 1)));
}

function joined(before, more) {
  return Object.fromEntries(
    Object.entries(more).map(([name, values]) => [name, [...(before[name] ?? []), ...values]]));
}
