/** Lets a motion run on the screen: play and pause, the moment, how slow. */

import { element, icon } from "../controls/dom.js";
import { formatted } from "../parameters/quantities.js";

const PLAY = "M4 2.5v11l9-5.5z";
const PAUSE = "M4 3h3v10H4zM9 3h3v10H9z";
const calm = window.matchMedia("(prefers-reduced-motion: reduce)");

export class Player {
  /** The element to put on the page. */
  node;
  #cursor;
  #motion;
  #play = element("button", { type: "button", class: "round", on: { click: () => this.#toggle() } });
  #phase = element("input", {
    type: "range", min: "0", max: "1", step: "0.001", class: "phase",
    on: { input: () => this.#cursor.scrub(Number(this.#phase.value)) },
  });
  #speed = element("input", {
    type: "range", min: "-1.5", max: "2.6", step: "0.05", class: "speed", "aria-label": "Slow motion",
    on: { input: () => this.#slow() },
  });
  #factor = element("output", { class: "factor" });

  /**
   * @param {import("./cursor.js").Cursor} cursor
   * @param {{moment?: string, motion?: string}} [words] what runs, where two stand on one page
   */
  constructor(cursor, { moment = "Moment in the orbit", motion = "the motion" } = {}) {
    this.#cursor = cursor;
    this.#motion = motion;
    this.#phase.setAttribute("aria-label", moment);
    this.node = element("div", { class: "player" }, this.#play, this.#phase,
      element("label", {}, element("span", {}, "slow motion"), this.#speed), this.#factor);
    cursor.moved.subscribe((phase) => { this.#phase.value = String(phase); });
    cursor.toggled.subscribe((plays) => this.#playing(plays));
    this.#playing(false);
    calm.addEventListener("change", () => calm.matches && cursor.pause());
  }

  /**
   * Show how slow it is now that the cursor has another motion.
   * @param {boolean} isFirst whether it runs by itself, unless less motion is wished for
   */
  adopted(isFirst) {
    this.#slowness();
    if (isFirst && !calm.matches) this.#cursor.play();
  }

  #toggle() {
    if (this.#cursor.isPlaying) this.#cursor.pause();
    else this.#cursor.play();
  }

  #playing(plays) {
    this.#play.replaceChildren(icon(plays ? PAUSE : PLAY));
    this.#play.setAttribute("aria-label", `${plays ? "Pause" : "Play"} ${this.#motion}`);
    this.#play.setAttribute("aria-pressed", String(plays));
  }

  #slow() {
    this.#cursor.slowness = 10 ** Number(this.#speed.value);
    this.#slowness();
  }

  #slowness() {
    this.#speed.value = String(Math.log10(this.#cursor.slowness));
    this.#factor.textContent = `1 : ${formatted(this.#cursor.slowness, 2)}`;
    this.#speed.setAttribute("aria-valuetext", `${formatted(this.#cursor.slowness, 2)} times slower`);
  }
}
