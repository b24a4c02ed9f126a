/** The moment of the orbit that all its pictures show: it runs in slow motion, or follows the pointer. */

import { Signal } from "../session/signal.js";

/** Seconds that a forcing period takes on the screen at first. */
const UNHURRIED = 2.5;

export class Cursor {
  /** Announces the phase, from 0 to 1 over the whole orbit. */
  moved = new Signal();
  /** Announces whether it runs. */
  toggled = new Signal();
  phase = 0;
  isPlaying = false;
  /** How much slower than in truth; null until the first orbit says how long a period is. */
  slowness = null;
  #duration = 1;
  #last = 0;

  /**
   * Take the duration of another orbit.
   * @param {number} duration in seconds
   * @param {number} period in forcing periods
   */
  adopt(duration, period) {
    this.#duration = duration || 1;
    this.slowness ??= Math.max(UNHURRIED / (this.#duration / period), 0.05);
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
