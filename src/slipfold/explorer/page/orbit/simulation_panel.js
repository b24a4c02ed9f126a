/** Starting and stopping a simulation, and how it goes, period by period. */

import { ContactPanel } from "./contact_panel.js";
import { Exponents } from "./exponents.js";
import { element } from "../controls/dom.js";
import { valueTitle } from "../diagram/diagram_plot.js";
import { SmallPlot } from "../plots/small_plot.js";

const NUDGES = { "0.001": "0.1 %", "0.01": "1 %", "0.1": "10 %" };

export class SimulationPanel {
  /** The element to put on the page. */
  node;
  #simulation;
  #session;
  #verdict = element("p", { class: "verdict", role: "status" });
  #plot = new SmallPlot("settling", "Settling");
  #nudge = element("select", { "aria-label": "Nudge" },
    ...Object.entries(NUDGES).map(([value, text]) => element("option", { value }, text)));
  #contacts;
  #stop;
  #clear;
  #fromOrbit;

  /**
   * @param {import("../session/session.js").Session} session
   * @param {import("./simulation.js").Simulation} simulation
   * @param {import("../diagram/diagram_plot.js").DiagramPlot} diagram
   * @param {import("./orbit_panel.js").OrbitPanel} orbits
   */
  constructor(session, simulation, diagram, orbits) {
    this.#session = session;
    this.#simulation = simulation;
    this.#nudge.value = "0.01";
    const button = (text, click, kind = "") =>
      element("button", { type: "button", class: kind, on: { click } }, text);
    this.#fromOrbit = button("From this orbit", () =>
      simulation.fromOrbit(orbits.shown.answer, Number(this.#nudge.value)));
    this.#fromOrbit.disabled = true;
    this.#stop = button("Stop", () => simulation.stop(), "quiet");
    this.#clear = button("Clear", () => simulation.clear(), "quiet");
    this.#contacts = new ContactPanel(session, simulation);
    this.node = element("div", { class: "simulation" },
      element("div", { class: "sentence" },
        button("From rest", () => simulation.fromRest()), this.#fromOrbit,
        element("label", { class: "choice" }, element("span", {}, "nudged by"), this.#nudge),
        this.#stop, this.#clear),
      this.#verdict, new Exponents(session, simulation).node, this.#plot.node, this.#contacts.node);
    simulation.changed.subscribe(() => this.#show(diagram));
    session.store.changed.subscribe(({ view, before }) => {
      if (view.model !== before.model || view.show !== before.show || view.statistic !== before.statistic) this.#show(diagram);
    });
    session.orbitArrived.subscribe((arrived) => { this.#fromOrbit.disabled = !arrived; });
    this.#show(diagram);
  }

  /** All drawings with their captions, for a file. */
  get figures() {
    return [this.#plot.figure, ...this.#contacts.figures];
  }

  #show(diagram) {
    const { isRunning, verdict, count, x } = this.#simulation.state;
    const at = (i) => this.#simulation.timeAt(i);
    this.#stop.hidden = !isRunning;
    this.#clear.hidden = isRunning || count === 0;
    this.#verdict.textContent = verdict;
    // Contacts stand below: their place must not move when the motion begins.
    this.#plot.node.hidden = count === 0 && this.#session.model.contacts.length === 0;
    this.#plot.node.classList.toggle("absent", count === 0);
    const { show, statistic, vary } = this.#session.view;
    const y = this.#simulation.values(show, statistic);
    const isSame = this.#simulation.state.view?.vary === vary;
    if (this.#session.diagram) diagram.simulated(y.length && isSame ? { x, y } : null);
    if (y.length === 0) return;
    const quantity = { ...this.#session.quantity(show), statistic };
    this.#plot.draw({
      x: { label: this.#session.model.forced ? "forcing period" : "time (s)", range: [0, at(Math.max(y.length, 10))] },
      y: { label: valueTitle({ ...quantity, label: quantity.label ?? show }) },
      lines: [],
      dots: y.map((value, i) => ({ x: at(i + 1), y: value, tint: "settling" })),
    }, `Simulation: ${verdict}`);
  }
}
