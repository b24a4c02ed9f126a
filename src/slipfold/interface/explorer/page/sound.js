/** Vibrations as sound, through Web Audio. */

import { Choice, button, element } from "./dom.js";
import { formatted, optionOf } from "./quantities.js";

/** Seconds that a motion is heard which repeats, over which sound swells and fades, and its peak. */
const HEARD = 3;
const FADE = 0.03;
const PEAK = 0.8;

/**
 * @typedef {object} Sound
 * @property {Float32Array} values from -1 to 1
 * @property {number} rate samples a second
 * @property {boolean} repeats whether it is to be repeated without a gap
 */

/**
 * 16-bit samples in base 64 as numbers from -1 to 1.
 * @param {string} text
 */
export function decoded(text) {
  const letters = atob(text);
  const values = new Float32Array(letters.length / 2);
  // A loop, since a callback for each of a hundred thousand samples takes a tenth of a second.
  for (let i = 0; i < values.length; i++) {
    const whole = letters.charCodeAt(2 * i) | (letters.charCodeAt(2 * i + 1) << 8);
    values[i] = ((whole << 16) >> 16) / 32767;
  }
  return values;
}

/** How long a sound is heard, in s. */
export function lengthOf({ values, rate, repeats }) {
  return repeats ? HEARD : values.length / rate;
}

/**
 * Let a sound begin in a context, of a loudspeaker or of none.
 * @param {BaseAudioContext} context
 * @param {Sound} sound
 * @returns {{source: AudioBufferSourceNode, gain: GainNode}}
 */
export function begun(context, sound) {
  const buffer = context.createBuffer(1, sound.values.length, sound.rate);
  buffer.copyToChannel(sound.values, 0);
  const source = new AudioBufferSourceNode(context, { buffer, loop: sound.repeats });
  const gain = new GainNode(context, { gain: 0 });
  source.connect(gain).connect(context.destination);
  const now = context.currentTime;
  const length = lengthOf(sound);
  const fade = Math.min(FADE, length / 2);
  gain.gain.setValueAtTime(0, now);
  gain.gain.linearRampToValueAtTime(PEAK, now + fade);
  gain.gain.setValueAtTime(PEAK, now + length - fade);
  gain.gain.linearRampToValueAtTime(0, now + length);
  source.start(now);
  source.stop(now + length);
  return { source, gain };
}

/** One loudspeaker: what is begun ends what was heard before. */
class Loudspeaker {
  #context = null;
  #heard = null;

  /**
   * @param {Sound} sound
   * @param {() => void} ended hears when it has ended, or another begins
   */
  play(sound, ended) {
    this.stop();
    this.#context ??= new AudioContext();
    this.#context.resume();
    const heard = begun(this.#context, sound);
    this.#heard = { ...heard, ended };
    heard.source.onended = () => {
      if (this.#heard?.source === heard.source) this.#end();
      if (!this.#heard) this.#context.suspend(); // silence is computed as well
    };
  }

  /** Fade out at once. */
  stop() {
    if (!this.#heard) return;
    const { source, gain } = this.#heard;
    const now = this.#context.currentTime;
    gain.gain.cancelScheduledValues(now);
    gain.gain.setTargetAtTime(0, now, FADE / 3);
    source.stop(now + FADE);
    this.#end();
  }

  #end() {
    const { ended } = this.#heard;
    this.#heard = null;
    ended();
  }
}

export const loudspeaker = new Loudspeaker();

export class SoundControl {
  /** The element to put on the page. */
  node;
  #session;
  #simulation;
  #output = "";
  #choice = new Choice("Hear", (output) => this.#become(output));
  #listen = button("Listen", () => this.#ask());
  #stop = button("Silence", () => loudspeaker.stop(), { class: "quiet", hidden: true });
  #words = element("span", { role: "status" });

  constructor(session, simulation) {
    this.#session = session;
    this.#simulation = simulation;
    this.node = element("div", { class: "sentence sound" }, this.#choice.node, this.#listen, this.#stop, this.#words);
    simulation.changed.subscribe(() => this.#follow());
  }

  /** Take the output that is heard at first. */
  begin(output) {
    this.#become(output);
  }

  #become(output) {
    this.#output = output;
    const { states, outputs } = this.#session.model;
    this.#choice.show([...states, ...outputs].map(optionOf), output);
    this.#words.textContent = "";
  }

  #follow() {
    this.#listen.disabled = this.#simulation.state.isRunning;
    if (this.#simulation.state.isRunning) this.#words.textContent = "";
  }

  #ask() {
    const request = { ...this.#simulation.request, kind: "sound", output: this.#output };
    this.#session.ask(request, (answer) => answer.done && this.#hear(answer));
  }

  #hear(answer) {
    if (answer.silent) {
      this.#words.textContent = "It stands still.";
      return;
    }
    const { rate, repeats, faster, frequency } = answer;
    loudspeaker.play({ values: decoded(answer.samples), rate, repeats }, () => { this.#stop.hidden = true; });
    this.#stop.hidden = false;
    const pitch = `${formatted(frequency)}\u202fHz`;
    this.#words.textContent = faster === 1
      ? `${pitch}, played at its own speed`
      : `${pitch}, played ${faster} times faster at ${formatted(frequency * faster)}\u202fHz`;
  }
}
