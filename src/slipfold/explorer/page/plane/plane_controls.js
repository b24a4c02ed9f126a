/** Which two parameters the plane has, and from where to where. */

import { spanOf } from "../session/address.js";
import { Choice } from "../controls/choice.js";
import { element } from "../controls/dom.js";
import { display } from "../parameters/quantities.js";
import { QuantityBox } from "../parameters/quantity_box.js";

const COMPUTING = "Computing the bifurcation set…";
const AXES = { x: "Across", y: "Up" };

export class PlaneControls {
  /** The element to put on the page. */
  node = element("div", { class: "sentence" });
  /** What the server is doing, in words. */
  progress = element("div", { class: "progress" });
  #session;
  #rows;
  #words = element("span", { role: "status" });
  #stop = element("button", {
    type: "button", class: "quiet", hidden: true, on: { click: () => this.#cancel() },
  }, "Stop");
  #again = element("button", {
    type: "button", class: "quiet", hidden: true, on: { click: () => this.#session.computePlane() },
  }, "Compute");

  /** @param {import("../session/session.js").Session} session */
  constructor(session) {
    this.#session = session;
    this.#rows = Object.entries(AXES).map(([axis, label]) => this.#row(axis, label));
    this.node.append(...this.#rows.flatMap(({ nodes }) => nodes));
    this.progress.append(this.#words, this.#stop, this.#again);
    session.store.changed.subscribe(() => this.#refresh());
    session.planeChanged.subscribe((change) => this.#changed(change));
    session.failed.subscribe(({ kind, sentence }) =>
      kind === "plane" && sentence && this.#idle("The bifurcation set was not computed."));
    session.connection.changed.subscribe(() => this.#connected());
    this.#refresh();
  }

  #row(axis, label) {
    const choice = new Choice(label, (name) => this.#choose(axis, name));
    const bounds = [0, 1].map((i) => new QuantityBox(
      { class: "bound", "aria-label": `${label} ${i === 0 ? "from" : "to"}` }, {
        accept: (value) => this.#bounded(axis, i, value),
        refuse: (sentence) => this.#session.failed.announce({ kind: "input", sentence }),
      }));
    const unit = element("span", { class: "unit" });
    const group = element("span", { class: "axis-choice" }, choice.node, bounds[0].node,
      element("span", {}, "to"), bounds[1].node, unit);
    return { axis, choice, bounds, unit, nodes: [group] };
  }

  #refresh() {
    const { view, model } = this.#session;
    if (!view.plane) return;
    const options = model.parameters.map(({ name, label, doc }) =>
      ({ value: name, text: label ?? name, title: doc }));
    for (const { axis, choice, bounds, unit } of this.#rows) {
      const { name, span } = view.plane[axis];
      const quantity = this.#session.quantity(name);
      choice.show(options, name);
      bounds.forEach((box, i) => box.show(quantity, span[i], span[1] - span[0]));
      unit.textContent = display(quantity).unit;
    }
  }

  #choose(axis, name) {
    const { view, model } = this.#session;
    const other = axis === "x" ? "y" : "x";
    const next = { ...view.plane, [axis]: { name, span: spanOf(model, name) } };
    if (view.plane[other].name === name) next[other] = view.plane[axis];
    this.#commit(next);
  }

  #bounded(axis, index, end) {
    const { plane } = this.#session.view;
    const span = [...plane[axis].span];
    span[index] = end;
    if (!(span[0] < span[1])) return `${plane[axis].name} has to grow from the first value to the last; give others`;
    this.#commit({ ...plane, [axis]: { ...plane[axis], span } });
  }

  #commit(plane) {
    this.#session.store.commit({ ...this.#session.view, plane });
  }

  #changed({ answer, progress, stale }) {
    if (answer) this.#idle("");
    else if (progress) this.#working(progress);
    else if (stale && !this.#session.store.isLive) this.#working(COMPUTING);
  }

  /** Nothing is computed without a server; with one, what was asked for is asked for again. */
  #connected() {
    const { connection, requests } = this.#session;
    if (!requests.isBusy("plane")) return;
    if (connection.isAlive) this.#working(COMPUTING);
    else {
      this.#words.textContent = "Not computed: there is no connection.";
      this.#stop.hidden = true;
    }
  }

  #working(text) {
    this.#words.textContent = text;
    this.#stop.hidden = false;
    this.#again.hidden = true;
  }

  #idle(text) {
    this.#words.textContent = text;
    this.#stop.hidden = true;
    this.#again.hidden = text === "";
  }

  #cancel() {
    this.#session.requests.cancel("plane");
    this.#idle("Stopped; the bifurcation set belongs to other values.");
  }
}
