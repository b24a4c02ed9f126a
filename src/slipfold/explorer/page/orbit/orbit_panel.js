/** One orbit in all its pictures, at one moment. */

import { Cursor } from "./cursor.js";
import { element } from "../controls/dom.js";
import { Mechanism } from "./mechanism.js";
import { complexText, orbitPlots } from "./orbit_plots.js";
import { PhaseAnimation } from "./phase_animation.js";
import { Player } from "./player.js";
import { formatted, withUnit } from "../parameters/quantities.js";

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
  #portrait = new PhaseAnimation();
  #stage = element("div", { class: "stage" });
  #grid = element("div", { class: "smalls" }, ...this.#plots.map(({ plot }) => plot.node));
  #player = new Player(this.cursor);

  /** @param {import("../session/session.js").Session} session */
  constructor(session) {
    this.#session = session;
    this.node = element("div", { class: "orbit former" },
      element("div", { class: "stage-column" }, this.#stage, this.#player.node), this.#grid);
    this.cursor.moved.subscribe((phase) => this.#point(phase));
    session.orbitArrived.subscribe((arrived) => (arrived ? this.#show(arrived) : this.#none()));
    for (const signal of [session.orbitAwaited, session.orbitArrived, session.failed]) {
      signal.subscribe(() => this.#tellBusy());
    }
  }

  /** The orbit shown: the server's answer, the view it belongs to and its request. */
  get shown() {
    return this.node.classList.contains("empty") ? null : this.#orbit;
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
    this.#orbit = { answer, quantity, isForced: model.forced, view, request };
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
    this.#point(this.cursor.phase);
    this.#player.adopted(isFirst);
    this.node.dataset.drawn = answer.value;
    this.node.dataset.period = answer.period;
  }

  /** Tell whether the orbit that is meant is still to come. */
  #tellBusy() {
    this.node.setAttribute("aria-busy", String(this.#session.requests.isBusy("orbit")));
  }

  #none() {
    const { view, diagram, hasFailed } = this.#session;
    const parameter = this.#session.quantity(view.vary);
    const value = withUnit(parameter, view.parameters[view.vary]);
    const missing = `No branch of the diagram reaches ${parameter.label ?? parameter.name} = ${value}; move it or widen the span.`;
    const failed = "There is no orbit, since the response could not be computed.";
    this.title.textContent = hasFailed ? failed : diagram ? missing : "Computing the response…";
    this.node.classList.add("empty");
    // A motion of another model has no place beside the name of this one, nor have captions of nothing.
    this.node.classList.toggle("former", !diagram || !this.#orbit);
  }

  #stageOf(answer) {
    return answer.mechanism ? this.#mechanism : this.#portrait;
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
  const kind = place.special ? place.special.words : answer.stable ? "stable" : "unstable";
  if (answer.eigenvalues) {
    const [[re, im]] = answer.eigenvalues;
    const pair = im === 0 ? formatted(re) : `(${complexText([re, Math.abs(im)]).replace("+", "±")})`;
    return `${at}: equilibrium, ${kind}; rightmost eigenvalue ${pair}\u202f1/s`;
  }
  const largest = (values) => formatted(Math.max(0, ...values.map(([re, im]) => Math.hypot(re, im))), 4);
  if (isForced) return `${at}: period ${answer.period}, ${kind}; largest multiplier ${largest(answer.multipliers)}`;
  const cycle = `cycle of ${formatted(answer.t.at(-1) - answer.t[0])}\u202fs`;
  return `${at}: ${cycle}, ${kind}; largest multiplier besides 1: ${largest(withoutOne(answer.multipliers))}`;
}

/** Multipliers of a cycle but that of its own direction, which is one. */
function withoutOne(multipliers) {
  const gaps = multipliers.map(([re, im]) => Math.hypot(re - 1, im));
  return multipliers.toSpliced(gaps.indexOf(Math.min(...gaps)), 1);
}
