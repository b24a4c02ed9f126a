/** The controls of the parameters: sliders, boxes, and their panel. */

import { element, icon, set } from "./dom.js";
import { roundStep, snapped, stepped } from "./plot_tools.js";
import { display, formatted, parsed, parsedRange, plain, symbol } from "./quantities.js";
import { rangeOf, withParameter, withRange } from "./view.js";

const DIGITS = 6;

/** Steps from one end of the range to the other. */
const STEPS = 0.001;

const COUNTS = { ArrowUp: 1, ArrowDown: -1, PageUp: 10, PageDown: -10 };

/** Why the text of a box is refused, beside it. */
const reason = element("p", { class: "notice reason", role: "alert", hidden: true });
let refusedBox = null;
document.body.append(reason);
window.addEventListener("scroll", placeReason, { capture: true, passive: true });

/** Put the reason beside the box that it is about, wherever that has moved. */
function placeReason() {
  if (reason.hidden) return;
  const { right, top } = refusedBox.getBoundingClientRect();
  reason.style.left = `${Math.max(Math.min(right + 8, innerWidth - reason.offsetWidth - 8), 0)}px`;
  reason.style.top = `${top}px`;
}

export class QuantityBox {
  /** The element to put on the page. */
  node;
  #accept;
  #acceptRange;
  #isRefused = false;
  #quantity = null;
  #value = 0;
  #range = 0;
  #isEdited = false;

  /**
   * @param {Record<string, string>} attributes of the element
   * @param {(value: number) => (string|void)} accept takes a value in SI units, and may return why it
   * cannot be used
   * @param {((range: [number, number]) => void)|null} [acceptRange] takes a range where one is typed
   */
  constructor(attributes, accept, acceptRange = null) {
    this.#accept = accept;
    this.#acceptRange = acceptRange;
    this.node = element("input", {
      ...attributes, type: "text", class: `number ${attributes.class ?? ""}`, autocomplete: "off",
      spellcheck: "false",
      on: {
        input: () => {
          this.#isEdited = true;
          this.#showReason(null);
        },
        change: () => this.#take(),
        blur: () => this.#isRefused || this.#restore(),
        keydown: (event) => this.#key(event),
      },
    });
  }

  /**
   * Show a value; what is just being typed stays, and so does what was refused.
   * @param {object} quantity a parameter as the server describes it
   * @param {number} value SI
   * @param {number} range what is a long way for it, SI
   */
  show(quantity, value, range) {
    const isOther = quantity !== this.#quantity || (this.#isRefused && value !== this.#value);
    if (isOther) this.#isEdited = false;
    this.#quantity = quantity;
    this.#value = value;
    this.#range = range;
    if (!this.#isEdited) this.#restore();
  }

  #restore() {
    this.#isEdited = false;
    if (this.#isRefused) this.#showReason(null);
    const text = plain(this.#value * display(this.#quantity).factor, DIGITS);
    if (this.node.value !== text) this.node.value = text;
  }

  #take() {
    const text = this.node.value;
    let refused = null;
    this.#isEdited = false;
    if (text.trim() !== "") refused = this.#read(text);
    this.#isEdited = refused !== null;
    this.#showReason(refused);
    if (!refused) this.#restore();
  }

  /** Take what a text says; return why it cannot be used, or null. */
  #read(text) {
    const { si } = display(this.#quantity);
    const { range, sentence } = (this.#acceptRange && parsedRange(text, this.#quantity, si)) ?? {};
    if (range) this.#acceptRange(range);
    if (range || sentence) return sentence ?? null;
    const { value, sentence: wrong } = parsed(text, this.#quantity, si);
    return wrong ?? this.#accept(value) ?? null;
  }

  /** Show beside the box why its text is refused; null removes the reason. */
  #showReason(sentence) {
    this.#isRefused = sentence !== null;
    set(this.node, { "data-refused": this.#isRefused && "", title: sentence });
    reason.hidden = !this.#isRefused;
    reason.textContent = sentence ?? "";
    refusedBox = this.node;
    placeReason();
  }

  #key(event) {
    const count = COUNTS[event.key];
    if (event.key === "Escape" && this.#isEdited) {
      this.#restore();
      event.stopPropagation();
    } else if (count !== undefined && !event.ctrlKey && !event.altKey && !event.metaKey) {
      event.preventDefault();
      if (this.#isEdited) this.#take();
      const { factor, si } = display(this.#quantity);
      const step = roundStep(this.#range * factor, STEPS);
      const refused = this.#accept(stepped(this.#value * factor, step, count) * si) ?? null;
      this.#showReason(refused);
      if (!refused) this.#restore();
    }
  }
}

const BACK = "M8 3a5 5 0 1 1-4.6 3M3 2.5V6h3.5";

/** What a slider moves by where keys move it, over its range; where it is dragged, a pixel's worth. */
const COARSE = 0.005;

const SLIDER_COUNTS = {
  ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 20, PageDown: -20,
};

class ParameterControl {
  /** The row to put on the page. */
  node;
  #slider;
  #box;
  #back;
  #parameter;
  #shown;
  #commit;
  #width = 0;

  /**
   * @param {object} parameter as the server describes it
   * @param {{preview: (value: number) => void, commit: (value: number) => void,
   *   widen: (range: [number, number]) => void}} wishes SI units
   */
  constructor(parameter, { preview, commit, widen }) {
    const { unit, factor } = display(parameter);
    this.#parameter = parameter;
    this.#commit = commit;
    this.#shown = display(parameter);
    const id = `parameter-${parameter.name}`;
    const name = `${parameter.label ?? parameter.name}: ${parameter.doc}`;
    const label = `${name}${unit ? `, in ${unit}` : ""}`;
    this.#slider = element("input", {
      // The box takes the same keys, so that one stop of the tabulator is enough.
      type: "range", id: `${id}-slider`, "aria-label": label, min: "0", max: "1", step: "any", tabindex: "-1",
      on: {
        input: () => preview(this.#sliderValue()),
        change: () => commit(this.#sliderValue()),
        keydown: (event) => this.#step(event),
      },
    });
    new ResizeObserver(() => { this.#width = this.#slider.clientWidth; }).observe(this.#slider);
    this.#box = new QuantityBox(
      { id: `${id}-box`, "aria-label": `${label}, number` }, commit, widen);
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
    const shown = isEnd ? value : snapped(value, roundStep(high - low, 1 / Math.max(this.#width || this.#slider.clientWidth, 1)));
    return Math.min(Math.max(shown, low), high) * this.#shown.si;
  }

  #numbers() {
    return [this.#slider.min, this.#slider.max, this.#slider.value].map(Number);
  }

  /** Keys move by round steps, further with Shift and with Page Up and Down. */
  #step(event) {
    const count = SLIDER_COUNTS[event.key];
    if (count === undefined) return;
    event.preventDefault();
    const [low, high, value] = this.#numbers();
    const moved = stepped(value, roundStep(high - low, COARSE), count * (event.shiftKey ? 5 : 1));
    this.#commit(Math.min(Math.max(moved, low), high) * this.#shown.si);
  }
}

export class ParameterPanel {
  /** The element to put on the page. */
  node;
  #rows = element("div", { class: "parameters", role: "group", "aria-label": "Parameters" });
  // It has a place of its own: were it in the rows, they would move under the pointer.
  #meaning = element("span");
  #session;
  #controls = new Map();
  #model = null;

  /** @param {Node} below what stands below the parameters */
  constructor(session, refusals, below) {
    this.#session = session;
    this.node = element("div", { class: "parameter-panel" }, this.#rows, below,
      element("p", { class: "meaning", "aria-hidden": "true" }, this.#meaning));
    const explain = () => this.#explain();
    for (const event of ["pointerover", "pointerleave", "focusin", "focusout"]) {
      this.#rows.addEventListener(event, explain);
    }
    session.store.changed.subscribe(() => this.#show());
    refusals.changed.subscribe((sentences) => {
      for (const [name, control] of this.#controls) control.refuse(sentences[name] ?? null);
    });
    this.#show();
  }

  #show() {
    const { model, view } = this.#session;
    if (model !== this.#model) this.#build(model);
    for (const parameter of model.parameters) {
      const isVaried = parameter.name === view.vary;
      const bounds = isVaried ? view.span : rangeOf(view, parameter);
      const value = view.parameters[parameter.name];
      this.#controls.get(parameter.name).show(value, bounds, isVaried);
    }
    this.#explain();
  }

  #build(model) {
    const { store } = this.#session;
    this.#model = model;
    this.#controls = new Map(model.parameters.map((parameter) => {
      const changed = (value) => withParameter(this.#session.view, parameter.name, value);
      const control = new ParameterControl(parameter, {
        preview: (value) => store.preview(changed(value)),
        commit: (value) => store.commit(changed(value)),
        widen: (range) => store.commit(withRange(this.#session.view, parameter.name, range)),
      });
      return [parameter.name, control];
    }));
    this.#rows.replaceChildren(...[...this.#controls.values()].map(({ node }) => node));
  }

  /** Say what the parameter under the pointer is, else that which has the focus. */
  #explain() {
    const row = this.#rows.querySelector(".parameter:hover") ?? this.#rows.querySelector(".parameter:focus-within");
    const parameter = this.#model.parameters.find(({ name }) => name === row?.dataset.name);
    this.#meaning.textContent = parameter ? `${parameter.label ?? parameter.name}: ${parameter.doc}. ${this.#rangeText(parameter)}` : "";
  }

  #rangeText(parameter) {
    const { view } = this.#session;
    const ends = parameter.name === view.vary ? view.span : rangeOf(view, parameter);
    const [low, high] = ends.map((end) => plain(end * display(parameter).factor));
    return `Slider ${low} .. ${high}; type another range like this.`;
  }
}
