/** A study: what is drawn of it over what, its colours, and the way from a case to its diagram. */

import { Choice } from "../controls/choice.js";
import { element } from "../controls/dom.js";
import { axisTitle, withUnit } from "../parameters/quantities.js";
import { GRADIENT, colouring } from "./study_colours.js";
import { StudyPlot } from "./study_plot.js";
import { colours, themeChanged } from "../style/theme.js";

export class StudyPanel {
  /** What stands beside the heading, and the elements below it. */
  title;
  nodes;
  #study;
  #picture;
  #plot;
  #quantity;
  #axes;
  #fixed = element("span", { class: "study-fixed" });
  #legend = element("div", { class: "study-legend" });

  /**
   * @param {import("../session/session.js").Session} session
   * @param {import("./study.js").Study} study
   */
  constructor(session, study) {
    this.#study = study;
    const [first, second = null] = study.parameters.map(({ name }) => name);
    const at = Object.fromEntries(study.parameters.map(({ name }) => [name, study.axis(name)[0]]));
    const quantity = study.quantities.find(({ isText }) => !isText) ?? study.quantities[0];
    this.#picture = { x: first, y: second, at, quantity };
    this.title = element("p", { class: "orbit-title", title: study.title }, study.title);
    this.#plot = new StudyPlot(study, (number) =>
      session.store.commit(study.viewOf(number, session.view, session.models)));
    this.#quantity = new Choice("Draw", (name) =>
      this.#become({ quantity: study.quantities.find((item) => item.name === name) }));
    this.#axes = ["x", "y"].map((axis, i) => new Choice(["over", "and"][i], (name) => this.#turn(axis, name)));
    const controls = element("div", { class: "sentence" }, this.#quantity.node,
      ...this.#axes.slice(0, second === null ? 1 : 2).map(({ node }) => node), this.#fixed);
    this.nodes = [controls, this.#plot.node, this.#legend];
    session.store.changed.subscribe(({ view }) => this.#plot.mark(study.shownBy(view)));
    themeChanged.subscribe(() => this.#showLegend());
    this.#become({});
    this.#plot.mark(study.shownBy(session.view));
  }

  /** What is drawn, for a file. */
  figure() {
    return this.#plot.figure();
  }

  #turn(axis, name) {
    const { x, y } = this.#picture;
    const other = axis === "x" ? "y" : "x";
    const isSwap = { x, y }[other] === name;
    this.#become({ [axis]: name, ...(isSwap ? { [other]: { x, y }[axis] } : {}) });
  }

  #become(changes) {
    this.#picture = { ...this.#picture, ...changes };
    const { x, y, quantity } = this.#picture;
    this.#quantity.show(this.#study.quantities.map(option), quantity.name);
    this.#axes.forEach((choice, i) => choice.show(this.#study.parameters.map(option), [x, y][i]));
    this.#showFixed();
    this.#showLegend();
    this.#plot.show(this.#picture);
  }

  /** Values of the parameters of a grid that are on no axis. */
  #showFixed() {
    const { x, y, at } = this.#picture;
    const others = this.#study.isGrid ? this.#study.parameters.filter(({ name }) => name !== x && name !== y) : [];
    this.#fixed.replaceChildren(...others.map((parameter) => {
      const { name, label } = parameter;
      const values = this.#study.axis(name);
      const choice = new Choice(`at ${label} =`, (index) =>
        this.#become({ at: { ...this.#picture.at, [name]: values[Number(index)] } }));
      choice.show(values.map((value, i) => ({ value: String(i), text: withUnit(parameter, value) })),
        String(values.indexOf(at[name])));
      return choice.node;
    }));
  }

  #showLegend() {
    const { x, y, at, quantity } = this.#picture;
    const { words, ends } = colouring(quantity, this.#study.seen(x, y, at), colours());
    const title = element("span", { title: quantity.doc }, axisTitle(quantity));
    if (y === null) this.#legend.replaceChildren(element("span", {}, quantity.doc));
    else if (words) {
      this.#legend.replaceChildren(title, ...words.map(({ text, colour }) => element("span", { class: "word" },
        element("span", { class: "shade", style: `background: ${colour}` }), text)));
    } else if (ends) {
      this.#legend.replaceChildren(title, element("span", {}, ends[0]),
        element("span", { class: "scale", style: `background: ${GRADIENT}` }), element("span", {}, ends[1]),
        element("span", { class: "meaning-of" }, quantity.doc));
    } else this.#legend.replaceChildren(element("span", {}, `There is no ${quantity.name} of these cases.`));
  }
}

function option(item) {
  return { value: item.name, text: axisTitle(item), title: item.doc };
}
