/** What motions do in the plane, on request: asked for, kept as long as it is of the view, and told. */

import { element } from "../controls/dom.js";
import { Signal } from "../session/signal.js";
import { planeRequest } from "../session/view.js";

export class Regimes {
  /** The element to put on the page. */
  node;
  /** The picture that has come last, or null. */
  picture = null;
  /** Announces that the picture has changed. */
  changed = new Signal();
  #session;
  #of = "";
  #words = element("span", { role: "status" });
  #ask = element("button", {
    type: "button", title: "Simulate what motions do all over the plane: periods, tori, chaos",
    on: { click: () => this.#begin() },
  }, "What do motions do?");
  #stop = element("button", { type: "button", class: "quiet", hidden: true, on: { click: () => this.#halt() } }, "Stop simulating");
  #away = element("button", { type: "button", class: "quiet", hidden: true, on: { click: () => this.#clear() } }, "Take away");

  /** @param {import("../session/session.js").Session} session */
  constructor(session) {
    this.#session = session;
    this.node = element("div", { class: "sentence regimes" }, this.#ask, this.#words, this.#stop, this.#away);
    session.store.changed.subscribe(() => this.#follow());
    session.failed.subscribe(({ kind, sentence }) => kind === "regimes" && sentence && this.#clear(sentence));
    this.#follow();
  }

  #key() {
    const { view } = this.#session;
    return view.plane ? JSON.stringify(planeRequest(view)) : "";
  }

  #follow() {
    // There is a phase at which to look at motions where something forces them.
    this.node.hidden = !this.#session.model.forced;
    if (this.#of && this.#of !== this.#key()) this.#clear();
  }

  #begin() {
    const { requests, failed, view } = this.#session;
    this.#clear();
    this.#of = this.#key();
    this.#tell("Simulating…", true);
    const onError = (sentence, again) => failed.announce(
      { kind: "regimes", sentence, again: again ? () => this.#begin() : null });
    requests.ask({ ...planeRequest(view), kind: "regimes" },
      { onAnswer: (answer) => this.#take(answer), onError }, { supersede: true });
  }

  #take({ far, done, ...picture }) {
    if (far) {
      this.#tell(`Simulating: ${Math.floor((100 * far[0]) / far[1])} % of this picture…`, true);
      return;
    }
    this.#show(picture);
    const size = `${picture.x.values.length} × ${picture.y.values.length} motions from the model's start`;
    this.#tell(done ? `${size}.` : `${size}; simulating more…`, !done);
  }

  #halt() {
    this.#session.requests.cancel("regimes");
    this.#tell("Stopped.", false);
  }

  #clear(failure = null) {
    this.#session.requests.cancel("regimes");
    if (!failure) this.#session.failed.announce({ kind: "regimes", sentence: null });
    this.#of = "";
    this.#show(null);
    this.#tell("", false);
  }

  #show(picture) {
    if (picture === this.picture) return;
    this.picture = picture;
    this.node.dataset.cells = picture ? String(picture.x.values.length) : "";
    this.#away.hidden = !picture;
    this.changed.announce(picture);
  }

  #tell(text, isRunning) {
    this.#words.textContent = text;
    this.#stop.hidden = !isRunning;
  }
}
