/** A motion that is followed up and down the diagram, and what is drawn of it. */

import { button, element } from "./dom.js";
import { withUnit } from "./quantities.js";
import { decoded, loudspeaker } from "./sound.js";
import { Signal } from "./store.js";
import { copy, exported } from "./toolbar.js";
import { sweepRequest } from "./view.js";

const RUNS = ["up", "down"];

/** Half the size of an arrow in pixels, and where one value has more than some. */
const ARROW = { size: 3.2, small: 1.7, few: 3 };

export class Sweep {
  /** Announces nothing: something has come, or all is gone. */
  changed = new Signal();
  /** Places by run, in SI units: one value of the parameter may have several. */
  runs = nothing();
  isRunning = false;
  words = "";
  /** The request for the last sweep. */
  request = null;
  #session;
  #key = "";
  #clips = [];

  constructor(session) {
    this.#session = session;
    session.store.changed.subscribe(({ view }) => {
      if (this.#key && keyOf(view) !== this.#key) this.clear();
    });
    session.failed.subscribe(({ kind, sentence }) => kind === "sweep" && sentence && this.#rest(sentence));
    session.connection.changed.subscribe(({ state }) => {
      if (this.isRunning && state !== "open") this.stop();
    });
  }

  /** All places, in the order in which they came. */
  get places() {
    return RUNS.flatMap((run) => this.runs[run]);
  }

  /**
   * Follow the motion of the model's start up, then down; or another one both ways from its own value.
   * @param {import("./view.js").Start|null} from
   */
  start(from = null) {
    const { view } = this.#session;
    this.runs = nothing();
    this.#clips = [];
    this.#key = keyOf(view);
    this.isRunning = true;
    this.request = sweepRequest(view, from);
    this.#report("Sweeping up…");
    this.#session.ask(this.request, (answer) => this.#take(answer), () => this.start(from));
  }

  /** Stop; what has come stays. */
  stop() {
    this.#session.requests.cancel("sweep");
    this.#rest("Stopped.");
  }

  /** Forget it. */
  clear() {
    this.#session.forget("sweep");
    this.runs = nothing();
    this.#clips = [];
    this.#key = "";
    this.#rest("");
  }

  /** What has come as one sound, as loud as its values are large; null if all of it stands still. */
  get sound() {
    const largest = Math.max(...this.#clips.map(({ size }) => size), 0);
    if (largest === 0) return null;
    const parts = this.#clips.map(({ samples, size }) => decoded(samples).map((value) => (value * size) / largest));
    const values = new Float32Array(parts.reduce((sum, part) => sum + part.length, 0));
    parts.reduce((begin, part) => {
      values.set(part, begin);
      return begin + part.length;
    }, 0);
    const [{ rate, faster }] = this.#clips;
    return { values, rate, faster, repeats: false };
  }

  #take({ run, x, y, sound, done, ends }) {
    if (done) {
      const sentences = Object.entries(ends).map(([name, reason]) => `The sweep ${name} ended: ${reason}.`);
      this.#rest(sentences.join(" ") || "Swept up and down.");
      return;
    }
    this.#clips.push(sound);
    const size = y.length > ARROW.few ? ARROW.small : ARROW.size;
    this.runs[run].push(...y.map((value) => ({ x, y: value, size })));
    const vary = this.#session.quantity(this.#session.view.vary);
    this.#report(`Sweeping ${run}: ${vary.label ?? vary.name} = ${withUnit(vary, x)}…`);
  }

  #rest(words) {
    this.isRunning = false;
    this.#report(words);
  }

  #report(words) {
    this.words = words;
    this.changed.announce();
  }
}

function nothing() {
  return { up: [], down: [] };
}

/** What the places of a sweep belong to. */
function keyOf(view) {
  return JSON.stringify(sweepRequest(view));
}

export class SweepControl {
  /** The element to put on the page. */
  node;
  #sweep;
  #start;
  #stop;
  #clear;
  #listen;
  #silence;
  #words = element("p", { role: "status" });
  #here;
  #copied;

  /**
   * @param {() => import("./view.js").Start|null} motionShown
   * @param {{dialog: object, say: (sentence: string) => void}} page
   */
  constructor(sweep, motionShown, { dialog, say }) {
    this.#sweep = sweep;
    this.#start = button("Sweep up and down", () => sweep.start(), {
      title: "Follow the motion along the diagram, each value from the last state of the one before",
    });
    this.#here = button("Sweep from this motion", () => {
      const from = motionShown();
      if (from) sweep.start(from);
      else say("There is no motion to sweep from yet; wait for the orbit, or simulate.");
    }, { title: "Follow the motion of the simulation, or else the orbit, up and down from its own value" });
    this.#copied = button("Copy the sweep as Python", () => this.#copy(dialog, say), { class: "quiet" });
    this.#stop = button("Stop the sweep", () => sweep.stop(), { class: "quiet" });
    this.#clear = button("Clear the sweep", () => sweep.clear(), { class: "quiet" });
    this.#listen = button("Hear the sweep", () => this.#hear());
    this.#silence = button("Silence", () => loudspeaker.stop(), { class: "quiet", hidden: true });
    const keys = RUNS.map((run) => element("span", { class: `key sweep ${run}` }, run));
    this.node = element("div", { class: "sweep-control" },
      element("div", { class: "sentence" }, this.#start, this.#here, ...keys, this.#stop, this.#listen, this.#silence, this.#copied, this.#clear), this.#words);
    sweep.changed.subscribe(() => this.#show());
    this.#show();
  }

  async #copy(dialog, say) {
    try {
      const text = await (await exported(this.#sweep.request, "python")).text();
      dialog.show("The sweep in Python", text, await copy(text));
    } catch (error) {
      say(error.message);
    }
  }

  #hear() {
    const sound = this.#sweep.sound;
    if (!sound) {
      this.#words.textContent = "It stands still.";
      return;
    }
    loudspeaker.play(sound, () => { this.#silence.hidden = true; });
    this.#silence.hidden = false;
    this.#words.textContent = `Played ${sound.faster === 1 ? "at its own speed" : `${sound.faster} times faster`}: up, then down.`;
  }

  #show() {
    const { isRunning, words, places } = this.#sweep;
    const isAny = places.length > 0;
    this.#stop.hidden = !isRunning;
    this.#clear.hidden = this.#copied.hidden = this.#listen.hidden = isRunning || !isAny;
    for (const key of this.node.querySelectorAll(".key")) key.hidden = !isAny;
    this.#words.textContent = words;
    this.node.dataset.state = isRunning ? "running" : isAny ? "done" : "none";
  }
}
