/** Views of the end of a simulation: over time, in phase space, as a section, as a spectrum. */

import { Choice, element } from "./dom.js";
import { areSame } from "./plot_tools.js";
import { axisTitle, display, formatted, optionOf } from "./quantities.js";
import { SmallPlot } from "./small_plot.js";
import { SoundControl } from "./sound.js";

/** Lines of a spectrum below the largest by so many decades are not drawn. */
const DECADES = 6;

/** References of levels by unit (ISO 1683), with their names. */
const REFERENCES = {
  m: [1e-12, "1 pm"], "m/s": [1e-9, "1 nm/s"], "m/s^2": [1e-6, "1 µm/s²"], N: [1e-6, "1 µN"], W: [1e-12, "1 pW"], J: [1e-12, "1 pJ"],
};

/** Periods that may be chosen; as many as suit the motion by default. */
const WINDOWS = [4, 16, 64, 256];

const ALL = "all";

/**
 * @typedef {object} Motion what the server sends
 * @property {number} periods shown, and their `duration` in s
 * @property {Record<string, number[]>} columns over time
 * @property {{level: number|null, columns: Record<string, number[]>}} section
 * @property {{frequency: number[], amplitude: Record<string, number[]>}} spectrum
 * @property {number|null} forcing frequency, and that of the response where it repeats: `frequency`
 * @typedef {{motion: Motion, across: object, up: object, scale: string, isForced: boolean}} Shown
 *   quantities that are drawn
 */

const VIEWS = {
  time: { plot: new SmallPlot("motion-time", "Time series"), draw: drawTime },
  portrait: { plot: new SmallPlot("motion-portrait", "Phase portrait"), draw: drawPortrait },
  section: { plot: new SmallPlot("motion-section", "Poincaré section"), draw: drawSection },
  spectrum: { plot: new SmallPlot("motion-spectrum", "Spectrum"), draw: drawSpectrum },
};

const NAMES = { [ALL]: "all views", time: "time series", portrait: "phase portrait", section: "Poincaré section", spectrum: "spectrum" };

/** What is drawn of a quantity, in its unit; nothing where it has no value in places. */
function valuesOf(columns, quantity) {
  const { factor } = display(quantity);
  return (columns[quantity.name] ?? []).map((value) => value * factor);
}

function drawTime(plot, { motion, across, up, isForced }) {
  // Two quantities share an axis if they share a unit.
  const drawn = across.unit === up.unit && across !== up ? [across, up] : [across];
  const end = isForced ? motion.periods : motion.duration;
  plot.draw({
    x: { label: isForced ? "time (forcing periods)" : "time (s)", range: [0, end] },
    y: { label: axisTitle(...drawn) },
    lines: drawn.map((quantity, i) => {
      const y = valuesOf(motion.columns, quantity);
      return {
        x: y.map((_, k) => (k * end) / y.length), y, tint: `tint-${i + 1}`,
        name: drawn.length > 1 ? quantity.label ?? quantity.name : undefined,
      };
    }),
  });
}

function drawPortrait(plot, { motion, across, up, isForced }) {
  const [x, y] = [across, up].map((quantity) => valuesOf(motion.columns, quantity));
  const each = x.length / motion.periods;
  // What stands still is a dot, not a line without length.
  const isAtRest = isStill(x) && isStill(y);
  const starts = isAtRest ? [0] : isForced ? x.map((_, i) => i).filter((i) => i % each === 0) : [];
  plot.draw({
    x: { label: axisTitle(across) }, y: { label: axisTitle(up) },
    lines: x.length && y.length && !isAtRest ? [{ x, y, tint: "tint-1" }] : [],
    dots: y.length ? starts.map((i) => ({ x: x[i], y: y[i], tint: "stroboscopic" })) : [],
  });
}

/** Whether values differ by no more than rounding does. */
function isStill(values) {
  return values.length > 0 && areSame(Math.min(...values), Math.max(...values));
}

function drawSection(plot, { motion: { columns, section, frequency }, across, up }) {
  const [first, second] = [across, up].map((quantity) => valuesOf(section.columns, quantity));
  // At a passage of the first quantity it has one value: the second one is drawn over that before.
  const isPassing = section.level !== null;
  const [isConstant, isAtRest] = [[across], [across, up]].map((all) => all.every((one) => isStill(valuesOf(columns, one))));
  // What is constant passes its mean by rounding alone.
  const [x, y] = !isPassing ? [first, second] : isConstant ? [[], []] : [second.slice(0, -1), second.slice(1)];
  const where = isAtRest ? "It stands still." : isPassing
    ? !x.length ? `${across.label ?? across.name} never passes its mean` : `when ${across.label ?? across.name} passes ${formatted(section.level * display(across).factor, 3)} upward`
    : "at phase zero of the forcing";
  plot.draw({
    x: { label: isPassing ? `${axisTitle(up)}, one passage before` : axisTitle(across) },
    y: { label: axisTitle(up) }, lines: [],
    clouds: x.length && y.length && !isAtRest ? [{ x, y, tint: frequency === null ? "section" : "stroboscopic" }] : [],
    notes: [where],
  }, isAtRest ? `Poincaré section: ${where}` : `Poincaré section ${where}, ${x.length} points`);
}

function drawSpectrum(plot, { motion, across, scale }) {
  const { frequency, amplitude } = motion.spectrum;
  const values = valuesOf(amplitude, across);
  if (isStill(valuesOf(motion.columns, across))) {
    plot.draw({ x: { label: "frequency (Hz)", ticks: [] }, y: { label: axisTitle(across), rows: [] }, lines: [], notes: ["It is constant."] }, "Spectrum: It is constant.");
    return;
  }
  const largest = Math.max(...values.slice(1), 1e-300);
  const { level, label } = leveled(scale, across, largest);
  const floor = largest * 10 ** -DECADES;
  const all = values.map((_, i) => i);
  const high = all.filter((i) => values[i] > floor);
  // Lines of a motion that does not repeat are as close as a curve, which runs along the floor between them.
  const isCurve = motion.frequency === null;
  const kept = isCurve ? all.slice(high[0], high.at(-1) + 1) : high;
  const [x, y] = [kept.map((i) => frequency[i]), kept.map((i) => level(Math.max(values[i], floor)))];
  const marked = linesOf(motion);
  const top = 1.04 * Math.max(x.at(-1) ?? 0, 1.2 * (marked.at(-1)?.at ?? 0)) || 1;
  const ends = [level(floor), level(largest * 2)];
  const isLog = scale === "unit";
  plot.draw({
    x: { label: "frequency (Hz)", range: [-0.01 * top, top] },
    y: { label, isLog, range: isLog ? ends.map(Math.log10) : ends },
    lines: [
      ...marked.map(({ at }) => ({ x: [at, at], y: ends, tint: "faint dash" })),
      ...(isCurve ? [{ x, y, tint: "tint-1" }] : []),
    ],
    stems: isCurve ? [] : [{ x, y, tint: "tint-1" }],
    above: marked.map(({ at, name, order }) => ({ x: at, text: name, isBefore: order < 1 })),
  }, `Spectrum: largest line ${formatted(largest)} at ${formatted(frequency[values.indexOf(largest)])} Hz`);
}

/** Frequencies that are marked, with their names. */
function linesOf({ forcing, frequency }) {
  const first = forcing ?? frequency;
  if (!first) return [];
  return [["f", 1], ["f/2", 0.5], ["2f", 2]].map(([name, order]) => ({ name, order, at: order * first }));
}

/** How amplitudes are drawn: in their unit, or as levels of root mean squares. */
function leveled(scale, quantity, largest) {
  const { factor } = display(quantity);
  const name = quantity.label ?? quantity.name;
  if (scale === "unit") return { level: (value) => value, label: axisTitle(quantity) };
  const [reference, words] = scale === "largest"
    ? [largest / factor / Math.SQRT2, "largest line"] : REFERENCES[quantity.unit];
  const level = (value) => 20 * Math.log10(value / factor / Math.SQRT2 / reference);
  return { level, label: `${name} (dB re ${words})` };
}

export class MotionPanel {
  /** The element to put on the page. */
  node;
  #session;
  #simulation;
  #motion = null;
  #asked = "";
  #picked = {};
  #sound;
  #pictures = element("div", { class: "smalls" }, ...Object.values(VIEWS).map(({ plot }) => plot.node));
  #choices = {
    view: new Choice("View", (view) => this.#turn({ view })),
    across: new Choice("of output", (across) => this.#turn({ across })),
    up: new Choice("against", (up) => this.#turn({ up })),
    window: new Choice("in the last", (window) => this.#turn({ window })),
    scale: new Choice("spectrum in", (scale) => this.#turn({ scale })),
  };

  constructor(session, simulation) {
    this.#session = session;
    this.#simulation = simulation;
    this.#sound = new SoundControl(session, simulation);
    this.#choices.up.node.title = "Any two outputs: the phase portrait of a force against a displacement is its loop";
    this.node = element("div", { class: "motion", role: "group", "aria-label": "Views of the motion" },
      element("div", { class: "sentence" }, ...Object.values(this.#choices).map(({ node }) => node)),
      this.#sound.node, this.#pictures);
    simulation.changed.subscribe(() => this.#follow());
    session.store.changed.subscribe(({ view, before }) => {
      if (view.model !== before.model) this.#begin();
      else if (view.show !== before.show) this.#turn({ across: view.show });
    });
    this.#begin();
  }

  /** All drawings that are seen, for a file. */
  get figures() {
    if (this.node.hidden) return [];
    return this.#motion ? Object.values(VIEWS).filter(({ plot }) => !plot.node.hidden).map(({ plot }) => plot.figure) : [];
  }

  #begin() {
    const { show } = this.#session.view;
    this.#picked = { view: ALL, across: show, up: this.#rateOf(show), window: "", scale: "unit" };
    this.#motion = null;
    this.#draw(); // pictures of the model before are taken away
    this.#sound.begin(this.#picked.up);
    this.#follow();
  }

  /** The rate of an output, or else another output. */
  #rateOf(name) {
    const { states, rates } = this.#session.model;
    return rates[name] ?? states.find((other) => other.name !== name)?.name ?? name;
  }

  #turn(changes) {
    this.#picked = { ...this.#picked, ...changes };
    if (changes.across && this.#picked.up === changes.across) this.#picked.up = this.#rateOf(changes.across);
    if (!(this.#quantity("across").unit in REFERENCES) && this.#picked.scale === "reference") this.#picked.scale = "unit";
    this.#follow();
    this.#draw();
  }

  #quantity(axis) {
    return this.#session.quantity(this.#picked[axis]);
  }

  /** Ask for views of a simulation that has ended, once for each choice. */
  #follow() {
    const { isRunning, ends: { length: count } } = this.#simulation.state;
    // While another motion is computed the one before keeps its place.
    this.node.hidden = count === 0 && !(isRunning && this.#motion);
    this.node.classList.toggle("former-motion", isRunning);
    if (count === 0 || isRunning) {
      this.#asked = "";
      return;
    }
    const { across, up, window } = this.#picked;
    const request = {
      ...this.#simulation.request, kind: "motion", outputs: [across, up], ...(window ? { window: Number(window) } : {}),
    };
    const key = JSON.stringify(request);
    if (key === this.#asked) return;
    this.#asked = key;
    this.#session.ask(request, (answer) => this.#take(answer));
  }

  #take(answer) {
    if (!answer.done) return;
    this.#motion = answer.empty ? null : answer;
    this.#draw();
    this.#pictures.hidden = Boolean(answer.empty);
    this.node.dataset.drawn = this.#asked;
  }

  #draw() {
    this.#showChoices();
    const { view, scale } = this.#picked;
    this.#pictures.hidden = false;
    this.#pictures.classList.toggle("absent", this.#motion === null); // their place is kept
    for (const [name, { plot, draw }] of Object.entries(VIEWS)) {
      plot.node.hidden = view !== ALL && view !== name;
      if (plot.node.hidden || !this.#motion) continue;
      const { forced: isForced } = this.#session.model;
      const [across, up] = [this.#quantity("across"), this.#quantity("up")];
      draw(plot, { motion: this.#motion, across, up, scale, isForced });
    }
    this.node.classList.toggle("single", view !== ALL);
  }

  #showChoices() {
    const { states, outputs, forced } = this.#session.model;
    const options = [...states, ...outputs].map(optionOf);
    const each = forced ? "periods" : this.#motion?.frequency ? "cycles" : "intervals";
    const lasts = WINDOWS.map((count) => ({ value: String(count), text: `${count} ${each}` }));
    const unit = display(this.#quantity("across")).unit || "its unit";
    const [, reference] = REFERENCES[this.#quantity("across").unit] ?? [];
    const all = {
      view: Object.entries(NAMES).map(([value, text]) => ({ value, text })),
      across: options, up: options,
      window: [{ value: "", text: this.#motion ? `${this.#motion.periods} ${each}` : `usual number of ${each}` }, ...lasts],
      scale: [
        { value: "unit", text: unit }, { value: "largest", text: "dB re the largest line" },
        ...(reference ? [{ value: "reference", text: `dB re ${reference}`, title: "Root mean square over the reference of ISO 1683" }] : []),
      ],
    };
    for (const [name, choice] of Object.entries(this.#choices)) choice.show(all[name], this.#picked[name]);
  }
}
