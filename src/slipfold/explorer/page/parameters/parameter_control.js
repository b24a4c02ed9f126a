/** A slider, a number box with its unit, and a way back, for one parameter. */

import { element, icon, set } from "../controls/dom.js";
import { display, formatted } from "./quantities.js";
import { QuantityBox } from "./quantity_box.js";
import { roundStep, snapped, stepped } from "../plots/steps.js";
import { symbol } from "./symbols.js";

const BACK = "M8 3a5 5 0 1 1-4.6 3M3 2.5V6h3.5";
const DIGITS = 6;

/** What a slider that is dragged moves by, and one that is moved by keys, over its range. */
const FINE = 0.001;
const COARSE = 0.005;

const COUNTS = {
  ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 20, PageDown: -20,
};

export class ParameterControl {
  /** The row to put on the page. */
  node;
  #slider;
  #box;
  #back;
  #parameter;
  #shown;

  /**
   * @param {object} parameter as the server describes it
   * @param {{preview: (value: number) => void, commit: (value: number) => void,
   *   refuse: (sentence: string|null) => void}} wishes SI units
   */
  constructor(parameter, { preview, commit, refuse }) {
    const { unit, factor } = display(parameter);
    this.#parameter = parameter;
    this.#shown = display(parameter);
    const id = `parameter-${parameter.name}`;
    const name = `${parameter.label ?? parameter.name}: ${parameter.doc}`;
    const label = `${name}${unit ? `, in ${unit}` : ""}`;
    this.#slider = element("input", {
      type: "range", id: `${id}-slider`, "aria-label": label, min: "0", max: "1", step: "any",
      on: {
        input: () => preview(this.#sliderValue()),
        change: () => commit(this.#sliderValue()),
        keydown: (event) => this.#step(event),
      },
    });
    this.#box = new QuantityBox(
      { id: `${id}-box`, "aria-label": `${label}, number` }, { accept: commit, refuse });
    this.#back = element("button", {
      type: "button", class: "quiet back", "aria-label": `${parameter.name} back to its default`,
      title: `Back to ${formatted(parameter.value * factor, DIGITS)}${unit ? ` ${unit}` : ""}`,
      on: { click: () => commit(parameter.value) },
    }, icon(BACK));
    this.node = element("div", { class: "parameter", "data-name": parameter.name },
      element("label", { for: `${id}-slider` }, symbol(parameter)),
      this.#slider, this.#box.node, element("span", { class: "unit" }, unit), this.#back,
      element("p", { class: "doc unseen" }, parameter.doc));
  }

  /**
   * Show a value.
   * @param {number} value SI
   * @param {[number, number]} bounds of the slider, SI
   * @param {boolean} isVaried whether the diagram is drawn along this parameter
   */
  show(value, bounds, isVaried) {
    const { factor, unit } = this.#shown;
    const [low, high] = [Math.min(...bounds), Math.max(...bounds)];
    this.#slider.min = low * factor;
    this.#slider.max = high * factor;
    const shown = value * factor;
    if (document.activeElement !== this.#slider || Number(this.#slider.value) !== shown) {
      this.#slider.value = String(shown);
    }
    this.#slider.setAttribute("aria-valuetext", `${formatted(shown, DIGITS)} ${unit}`);
    const share = (value - low) / (high - low || 1);
    this.#slider.style.setProperty("--share", String(Math.min(Math.max(share, 0), 1)));
    this.#box.show(this.#parameter, value, high - low);
    this.node.classList.toggle("varied", isVaried);
    this.#back.classList.toggle("needed", !isVaried && value !== this.#parameter.value);
    this.#back.tabIndex = !isVaried && value !== this.#parameter.value ? 0 : -1;
  }

  /**
   * Mark the value as one that the model cannot have.
   * @param {string|null} sentence why; null where it can
   */
  refuse(sentence) {
    set(this.#box.node, { "aria-invalid": sentence !== null && "true", title: sentence });
  }

  /** The value of the slider: round, unless it is at an end. */
  #sliderValue() {
    const [low, high, value] = this.#numbers();
    const isEnd = value <= low || value >= high;
    const shown = isEnd ? value : snapped(value, roundStep(high - low, FINE));
    return Math.min(Math.max(shown, low), high) * this.#shown.si;
  }

  #numbers() {
    return [this.#slider.min, this.#slider.max, this.#slider.value].map(Number);
  }

  /** Keys move by round steps, further with Shift and with Page Up and Down. */
  #step(event) {
    const count = COUNTS[event.key];
    if (count === undefined) return;
    event.preventDefault();
    const [low, high, value] = this.#numbers();
    const moved = stepped(value, roundStep(high - low, COARSE), count * (event.shiftKey ? 5 : 1));
    this.#slider.value = String(moved);
    this.#slider.dispatchEvent(new Event("input"));
    this.#slider.dispatchEvent(new Event("change"));
  }
}
