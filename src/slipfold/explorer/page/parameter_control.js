/** A slider, a number box with its unit, and a way back, for one parameter. */

import { element, icon } from "./dom.js";
import { display, formatted, plain } from "./quantities.js";
import { symbol } from "./symbols.js";

const BACK = "M8 3a5 5 0 1 1-4.6 3M3 2.5V6h3.5";
const DIGITS = 6;

export class ParameterControl {
  /** The row to put on the page. */
  node;
  #slider;
  #box;
  #back;
  #parameter;
  #factor;

  /**
   * @param {object} parameter as the server describes it
   * @param {{preview: (value: number) => void, commit: (value: number) => void}} wishes SI units
   */
  constructor(parameter, { preview, commit }) {
    const { unit, factor } = display(parameter);
    this.#parameter = parameter;
    this.#factor = factor;
    const id = `parameter-${parameter.name}`;
    const name = `${parameter.label ?? parameter.name}: ${parameter.doc}`;
    const label = `${name}${unit ? `, in ${unit}` : ""}`;
    this.#slider = element("input", {
      type: "range", id: `${id}-slider`, "aria-label": label, min: "0", max: "1", step: "any",
      on: {
        input: () => preview(this.#valueOf(this.#slider)),
        change: () => commit(this.#valueOf(this.#slider)),
        keydown: (event) => this.#bigStep(event),
      },
    });
    this.#box = element("input", {
      type: "number", id: `${id}-box`, "aria-label": `${label}, number`, step: "any",
      on: { change: () => this.#box.value !== "" && commit(this.#valueOf(this.#box)) },
    });
    this.#back = element("button", {
      type: "button", class: "quiet back", "aria-label": `${parameter.name} back to its default`,
      title: `Back to ${formatted(parameter.value * factor, DIGITS)}${unit ? ` ${unit}` : ""}`,
      on: { click: () => commit(parameter.value) },
    }, icon(BACK));
    this.node = element("div", { class: "parameter", "data-name": parameter.name },
      element("label", { for: `${id}-slider` }, symbol(parameter)),
      this.#slider, this.#box, element("span", { class: "unit" }, unit), this.#back,
      element("p", { class: "doc unseen" }, parameter.doc));
  }

  /**
   * Show a value.
   * @param {number} value SI
   * @param {[number, number]} bounds of the slider, SI
   * @param {boolean} isVaried whether the diagram is drawn along this parameter
   */
  show(value, bounds, isVaried) {
    const [low, high] = [Math.min(...bounds), Math.max(...bounds)];
    const step = this.#parameter.step ? this.#parameter.step * this.#factor : "any";
    this.#slider.min = low * this.#factor;
    this.#slider.max = high * this.#factor;
    // The first and the last value must be reachable whatever the step.
    this.#slider.step = "any";
    this.#box.step = step === "any" ? "any" : plain(step, 1);
    const shown = value * this.#factor;
    if (document.activeElement !== this.#slider || Number(this.#slider.value) !== shown) {
      this.#slider.value = String(shown);
    }
    this.#slider.setAttribute("aria-valuetext", `${formatted(shown, DIGITS)} ${display(this.#parameter).unit}`);
    const share = (value - low) / (high - low || 1);
    this.#slider.style.setProperty("--share", String(Math.min(Math.max(share, 0), 1)));
    if (Number(this.#box.value) !== Number(plain(shown, DIGITS)) || this.#box.value === "") {
      this.#box.value = plain(shown, DIGITS);
    }
    this.node.classList.toggle("varied", isVaried);
    this.#back.classList.toggle("needed", !isVaried && value !== this.#parameter.value);
    this.#back.tabIndex = !isVaried && value !== this.#parameter.value ? 0 : -1;
  }

  #valueOf(input) {
    return Number(input.value) / this.#factor;
  }

  /** A slider without steps moves by a hundredth of its range, by a tenth with Page Up and Down. */
  #bigStep(event) {
    const shares = {
      ArrowRight: 0.005, ArrowUp: 0.005, ArrowLeft: -0.005, ArrowDown: -0.005,
      PageUp: 0.1, PageDown: -0.1,
    };
    const share = shares[event.key];
    if (share === undefined) return;
    event.preventDefault();
    const { min, max, value } = this.#slider;
    const moved = Number(value) + share * (event.shiftKey ? 5 : 1) * (Number(max) - Number(min));
    this.#slider.value = String(moved);
    this.#slider.dispatchEvent(new Event("input"));
    this.#slider.dispatchEvent(new Event("change"));
  }
}
