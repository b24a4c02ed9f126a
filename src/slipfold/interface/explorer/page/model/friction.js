/** Friction of the contacts: the coefficient over the slip speed while sliders move, and other laws. */

import { withText } from "../connection.js";
import { valueAt } from "./contacts.js";
import { Choice, element } from "../dom.js";
import { carriedOver, written } from "./editor.js";
import { formatted, withUnit } from "../quantities.js";
import { SmallPlot } from "../small_plot.js";
import { posted } from "../toolbar.js";

const SPEED = { name: "v", label: "v", unit: "m/s" };

/** The model that edited ones come from. */
const baseOf = ({ base, name }) => base ?? name;

export class FrictionPanel {
  /** The element to put on the page; hidden where nothing rubs. */
  node;
  #session;
  #say;
  #answer = null;
  #chosen = 0;
  #model = null;
  #asked = "";
  #exchanged = Promise.resolve();
  #contact = new Choice("Contact", (value) => this.#choose(Number(value)));
  #law = new Choice("Friction", (value) => this.#exchange(value));
  #plot = new SmallPlot("law", "Friction coefficient", { onPoint: (speed) => this.#point(speed) });
  #pointed = element("p", { class: "reading" });

  constructor(session, { say }) {
    this.#session = session;
    this.#say = say;
    this.node = element("div", { class: "friction", hidden: true, role: "group", "aria-label": "Friction laws" },
      element("div", { class: "sentence" }, this.#contact.node, this.#law.node), this.#plot.node, this.#pointed);
    this.#plot.node.addEventListener("pointerleave", () => this.#point(null));
    session.store.changed.subscribe(() => this.ask());
  }

  /** Ask for the coefficients at the values of the view. */
  ask() {
    const { view, model } = this.#session;
    if (model !== this.#model) {
      this.#model = model;
      this.#answer = null;
      this.#chosen = 0;
    }
    if (this.#answer && this.#answer.contacts.length === 0) return;
    const request = { kind: "friction", model: view.model, parameters: view.parameters };
    const key = JSON.stringify(request);
    if (key === this.#asked) return;
    this.#asked = key;
    const onAnswer = (answer) => model === this.#session.model && this.#show(answer);
    this.#session.requests.ask(request, { onAnswer, onError: () => {} });
  }

  #show(answer) {
    if (!answer) return;
    this.#answer = answer;
    const { contacts, laws } = answer;
    this.node.hidden = contacts.length === 0;
    if (this.node.hidden) return;
    const contact = contacts[Math.min(this.#chosen, contacts.length - 1)];
    this.#contact.node.hidden = contacts.length === 1;
    this.#contact.show(contacts.map(({ name }, i) => ({ value: String(i), text: name })), String(this.#chosen));
    const titles = { ...laws, [contact.law]: contact.title };
    this.#law.show(Object.entries(titles).map(([value, text]) => ({ value, text })), contact.law);
    const { speed, coefficient, holding, plate } = contact;
    const top = 1.15 * Math.max(...coefficient, holding ?? 0, 1e-300);
    this.#plot.draw({
      x: { label: "slip speed (m/s)", range: [0, speed.at(-1)] },
      y: { label: "μ", range: [Math.min(0, ...coefficient), top] },
      lines: [{ x: speed, y: coefficient, tint: "tint-1" },
        ...(plate ? [{ x: [plate, plate], y: [0, top], tint: "faint dash" }] : [])],
      dots: holding === null ? [] : [{ x: 0, y: holding, tint: "inside" }],
    }, `Friction coefficient of ${contact.name}: ${formatted(coefficient[0], 3)} at rest, ${formatted(coefficient.at(-1), 3)} at ${withUnit(SPEED, speed.at(-1), 3)}`);
    this.#point(null);
  }

  /** Read the coefficient at a speed; without one that of the moving surface's speed. */
  #point(speed) {
    const contact = this.#answer?.contacts[this.#chosen];
    if (!contact) return;
    const at = speed ?? contact.plate;
    const isIn = at !== null && at >= 0 && at <= contact.speed.at(-1);
    const mu = isIn ? valueAt({ t: contact.speed }, contact.coefficient, at) : 0;
    this.#pointed.textContent = isIn ? `μ = ${formatted(mu, 4)} at ${withUnit(SPEED, at, 3)}${speed === null ? ", the surface's speed" : ""}` : "\u00a0";
    this.#plot.point(isIn ? { x: at, dots: [{ x: at, y: mu, tint: "live" }] } : {});
  }

  #choose(place) {
    this.#chosen = place;
    this.#show(this.#answer);
  }

  /** Exchange the law of the chosen contact once those chosen before are exchanged. */
  #exchange(law) {
    const [contact, base] = [this.#chosen, baseOf(this.#session.model)];
    this.#exchanged = this.#exchanged.then(() => baseOf(this.#session.model) === base && this.#put(law, contact));
  }

  async #put(law, contact) {
    const { model, models, store } = this.#session;
    const body = JSON.stringify(withText({ model: model.name, contact, law }));
    try {
      const { text } = await (await posted("/api/law", body)).json();
      const made = await written(models, text);
      const place = this.#chosen;
      if (model === this.#session.model) store.commit(carriedOver(this.#session.view, model, made));
      this.#chosen = place;
    } catch (error) {
      this.#say(error.message.split("\n")[0]);
      this.#show(this.#answer);
    }
  }
}
