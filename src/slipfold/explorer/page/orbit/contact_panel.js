/** What contacts do at the end of a simulated motion: the mechanism at work, and its pictures. */

import { Belts } from "./belts.js";
import { contactPlots, doingAt } from "./contact_plots.js";
import { Cursor } from "./cursor.js";
import { element } from "../controls/dom.js";
import { Mechanism } from "./mechanism.js";
import { PhaseAnimation } from "./phase_animation.js";
import { Player } from "./player.js";

export class ContactPanel {
  cursor = new Cursor();
  /** The element to put on the page; where the model has contacts its place is kept free. */
  node;
  #session;
  #shown = null;
  #isFirst = true;
  #plots = contactPlots((time) => this.#scrub(time));
  #player = new Player(this.cursor, { moment: "Moment in the last round", motion: "the last round" });
  #stages = { sliding: new Mechanism("contacts"), belts: new Belts(), phase: new PhaseAnimation("contact-motion") };
  #stage = element("div", { class: "stage" });

  /**
   * @param {import("../session/session.js").Session} session
   * @param {import("./simulation.js").Simulation} simulation
   */
  constructor(session, simulation) {
    this.#session = session;
    this.node = element("div", { class: "contacts", "aria-label": "The last round", role: "group" },
      element("div", { class: "stage-column" }, this.#stage, this.#player.node),
      element("div", { class: "smalls" }, ...this.#plots.map(({ plot }) => plot.node)));
    this.cursor.moved.subscribe((phase) => this.#point(phase));
    simulation.changed.subscribe(({ contacts, view }) => this.#show(contacts, view));
    session.store.changed.subscribe(() => this.#makeRoom());
    this.#show(null, null);
  }

  /** All pictures that are seen, for a file. */
  get figures() {
    if (!this.#shown) return [];
    const seen = this.#plots.filter(({ plot }) => !plot.node.hidden).map(({ plot }) => plot);
    return [this.#stageOf(this.#shown), ...seen].map(({ figure }) => figure);
  }

  /** Keep the place of what is to come, so that nothing moves when it does. */
  #makeRoom() {
    const contacts = this.#session.model.contacts;
    this.node.hidden = contacts.length === 0;
    this.node.classList.toggle("former", this.#shown === null);
    if (this.#shown || !contacts.length) return;
    // Which pictures there will be follows from the contacts.
    const isPlanar = contacts.every(({ directions }) => directions > 1);
    this.#plots.at(-1).plot.node.hidden = !isPlanar;
    const { node } = this.#stageOf({
      mechanism: this.#session.model.name === "sliding" ? {} : null,
      contacts: contacts.map(({ directions }) => ({ plate: Array(directions), pieces: [{ displacement: [] }] })),
    });
    if (node.parentNode !== this.#stage) this.#stage.replaceChildren(node);
  }

  #show(answer, view) {
    if (answer === this.#shown?.answer) return;
    this.#shown = answer && { answer, contacts: answer.contacts, mechanism: answer.mechanism, isForced: this.#session.model.forced };
    this.#makeRoom();
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
    if (mechanism) return this.#stages.sliding;
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
