/** What a simulation settled on, followed as a branch of the diagram. */

import { button } from "./dom.js";
import { withStart } from "./view.js";

export class FollowMotion {
  /** The element to put on the page. */
  node;
  #session;
  #simulation;

  constructor(session, simulation) {
    this.#session = session;
    this.#simulation = simulation;
    this.node = button("Follow this motion", () => this.#follow(), {
      hidden: true, title: "Adds the branch of this motion to the diagram",
    });
    simulation.changed.subscribe(({ isRunning, settled, last }) => {
      this.node.hidden = isRunning || !settled || last === null;
    });
  }

  #follow() {
    const { store, view, model } = this.#session;
    const { last: state, period, cycle: duration, x: value } = this.#simulation.state;
    const orbit = model.forced ? { period } : duration ? { period: 1, duration } : {};
    const y = this.#simulation.values(view.show, view.statistic).at(-1) ?? null;
    store.commit(withStart(view, { value, state, ...orbit }, y));
  }
}
