/** The moment that all pictures show, and the controls that let it run. */

import { element, icon } from "./dom.js";
import { formatted } from "./quantities.js";
import { Signal } from "./store.js";

/** Seconds that a forcing period takes on the screen, until the user changes it. */
const UNHURRIED = 2.5;

export class Cursor {
  /** Announces the phase, from 0 to 1 over the whole orbit. */
  moved = new Signal();
  /** Announces whether it runs. */
  toggled = new Signal();
  phase = 0;
  isPlaying = false;
  /** How much slower than in truth a period takes those seconds, and the user's factor on it. */
  #unhurried = 1;
  #factor = 1;
  #duration = 1;
  #last = 0;

  /**
   * Take the duration of another orbit.
   * @param {number} duration in seconds
   * @param {number} period in forcing periods
   */
  adopt(duration, period) {
    this.#duration = duration || 1;
    this.#unhurried = Math.max(UNHURRIED / (this.#duration / period), 0.05);
  }

  /** How much slower than in truth it runs: of another model as fast on the screen as of this. */
  get slowness() {
    return this.#unhurried * this.#factor;
  }

  set slowness(value) {
    this.#factor = value / this.#unhurried;
  }

  /** Show another moment. */
  set(phase) {
    this.phase = phase - Math.floor(phase);
    this.moved.announce(this.phase);
  }

  /** Show the moment under the pointer, and stay there. */
  scrub(phase) {
    this.pause();
    this.set(Math.min(Math.max(phase, 0), 0.9999));
  }

  /** Let it run. */
  play() {
    if (this.isPlaying) return;
    this.isPlaying = true;
    this.#last = performance.now();
    requestAnimationFrame((now) => this.#step(now));
    this.toggled.announce(true);
  }

  /** Let it stand. */
  pause() {
    this.isPlaying = false;
    this.toggled.announce(false);
  }

  #step(now) {
    if (!this.isPlaying) return;
    const elapsed = Math.min((now - this.#last) / 1000, 0.1);
    this.#last = now;
    this.set(this.phase + elapsed / (this.#duration * this.slowness));
    requestAnimationFrame((next) => this.#step(next));
  }
}

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
    type: "range", min: "-1.5", max: "2.6", step: "0.05", class: "speed", "aria-label": "Speed of the motion",
    on: { input: () => this.#slow() },
  });
  #factor = element("output", { class: "factor" });
  #name = element("span");

  /** @param {{moment?: string, motion?: string}} [words] what runs, where two stand on one page */
  constructor(cursor, { moment = "Moment in the orbit", motion = "the motion" } = {}) {
    this.#cursor = cursor;
    this.#motion = motion;
    this.#phase.setAttribute("aria-label", moment);
    this.node = element("div", { class: "player" }, this.#play, this.#phase,
      element("label", {}, this.#name, this.#speed), this.#factor);
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
    const { slowness } = this.#cursor;
    const isSlow = slowness >= 1;
    const times = formatted(isSlow ? slowness : 1 / slowness, 2);
    this.#name.textContent = isSlow ? "slow motion" : "fast motion";
    this.#factor.textContent = isSlow ? `1 : ${times}` : `${times} : 1`;
    this.#speed.setAttribute("aria-valuetext", `${times} times ${isSlow ? "slower" : "faster"}`);
  }
}
