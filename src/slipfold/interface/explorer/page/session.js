/** The state of the page: the view, its answers, and values that are refused. */

import { Requests, withText } from "./connection.js";
import { asSpecial, chosenPlace, crossings } from "./diagram_data.js";
import { Signal, Store } from "./store.js";
import { ANY, diagramRequest, orbitRequest, planeRequest } from "./view.js";

export class Refusals {
  /** Announces sentences by the parameter whose value is refused. */
  changed = new Signal();
  #session;
  #asked = "";
  #sentences = {};

  constructor(session) {
    this.#session = session;
    session.store.changed.subscribe(({ live }) => live || this.ask());
  }

  /** Ask about the values of the view. */
  async ask() {
    const { model, parameters } = this.#session.view;
    const body = JSON.stringify(withText({ model, parameters }));
    if (body === this.#asked) {
      if (this.isAny) this.#session.store.refuse();
      return;
    }
    this.#asked = body;
    try {
      const headers = { "Content-Type": "application/json" };
      const response = await fetch("/api/values", { method: "POST", headers, body });
      if (response.ok && body === this.#asked) this.#take(await response.json());
    } catch {
      this.#asked = ""; // there is no server, which is said elsewhere
    }
  }

  /** Whether the model cannot have the values of the view, as far as that is known. */
  get isAny() {
    return Object.keys(this.#sentences).length > 0;
  }

  #take(sentences) {
    for (const name of Object.keys({ ...this.#sentences, ...sentences })) {
      this.#session.failed.announce({ kind: `value of ${name}`, sentence: sentences[name] ?? null });
    }
    this.#sentences = sentences;
    if (this.isAny) this.#session.store.refuse();
    this.changed.announce(sentences);
  }
}

const KEPT_ORBITS = 60;

/** Milliseconds after its last move from which a slider rests: the whole response is followed then. */
const REST = 100;

export class Session {
  /** The live diagram: `{answer, view}`. */
  diagramArrived = new Signal();
  /** How far the live diagram has come: `{progress, value}`, or null when another is requested. */
  progressed = new Signal();
  /** Pinned diagrams: a map from pin id to answer. */
  pinsChanged = new Signal();
  /** The place of the orbit shown, or null where there is none. */
  placeChanged = new Signal();
  /** Nothing: an orbit is requested. */
  orbitAwaited = new Signal();
  /** An orbit: `{answer, place, view}`. */
  orbitArrived = new Signal();
  /**
   * The plane: `{answer}` or `{progress}` with what has come, and `stale` if it is of other values;
   * `{isSame}` where the values are those that were requested.
   */
  planeChanged = new Signal();
  /**
   * Sentences of refusal: `{kind, sentence, again}`; the sentence is null when all is well again, `again`
   * asks once more where that may help.
   */
  failed = new Signal();

  diagram = null;
  /** Whether the diagram is exact, and branches may be added to it. */
  isMore = false;
  place = null;
  pins = new Map();
  #keys = { diagram: "", plane: "", orbit: "" };
  #settled = null;
  #hasFailed = false;
  #pinKeys = new Map();
  #orbits = new Map();
  #followed = null;
  #hovered = null;
  #rest = 0;

  /** @param {object[]} models as the server describes them */
  constructor(models, view, connection) {
    this.models = models;
    this.connection = connection;
    this.requests = new Requests(connection);
    this.store = new Store(view);
    this.store.changed.subscribe((change) => this.#follow(change));
  }

  get view() {
    return this.store.view;
  }

  /** Whether there is no diagram of the view: what was drawn last is of other values. */
  get hasFailed() {
    return this.#hasFailed;
  }

  /** Whether nothing more is to come for the diagram of the view. */
  get isSettled() {
    return this.#settled === this.#keys.diagram;
  }

  /** Whether the diagram that came last is along the parameter of the view: its places mean nothing else. */
  get #isAlong() {
    return this.diagram?.x.name === this.view.vary;
  }

  /** The model of the view, as the server describes it. */
  get model() {
    return this.models.find((item) => item.name === this.view.model);
  }

  /** A parameter, state or output of the model by name. */
  quantity(name) {
    const { parameters, states, outputs } = this.model;
    return [...parameters, ...states, ...outputs].find((item) => item.name === name);
  }

  /** Ask for everything the view shows. */
  start() {
    this.#follow({ view: this.view, before: this.view, live: false });
  }

  /** Show the orbit at a place, and make it the working point. */
  choose(place) {
    if (!this.#isAlong) return;
    this.#hovered = null;
    this.#followed = { branch: place.branch, y: place.y };
    const parameters = { ...this.view.parameters, [this.view.vary]: place.x };
    this.store.commit({ ...this.view, parameters, at: this.#followed });
  }

  /** Show the orbit at a place for as long as the pointer is there; null ends it. */
  hover(place) {
    if (!this.#isAlong) return;
    this.#hovered = place;
    this.#askOrbit(place ?? this.place);
  }

  /**
   * Where the branch of the orbit that is shown begins, along a parameter with this value.
   * @returns {import("./view.js").Start|null} null while there is no orbit
   */
  startOfOrbit(value) {
    const answer = this.place && this.#orbits.get(JSON.stringify(orbitRequest(this.view, this.place)));
    return answer ? { ...answer.through, value } : null;
  }

  /** Compute the plane that the view shows, even if it is the same as before. */
  computePlane() {
    this.#keys.plane = "";
    this.#followPlane(false);
  }

  /**
   * Ask for what is computed on request, in place of what was asked of its kind before.
   * @param {(() => void)|null} [again] asks once more where the answer fails
   */
  ask(request, onAnswer, again = null) {
    const { kind } = request;
    this.#fail(kind, null);
    const onError = (sentence, mayAgain) => this.#fail(kind, sentence, mayAgain && again);
    this.requests.ask(request, { onAnswer, onError }, { supersede: true });
  }

  /** Compute nothing more of a kind; what went wrong with it is forgotten. */
  forget(kind) {
    this.requests.cancel(kind);
    this.#fail(kind, null);
  }

  #follow({ view, before, live }) {
    if (view.model !== before.model) {
      this.#followed = null;
      this.diagram = null;
      this.#hasFailed = false;
      this.#askOrbit(null);
    }
    if (view.model !== before.model || view.vary !== before.vary) {
      this.#hovered = null;
      this.place = null;
      // Answers about the model before, or along another parameter, could not be drawn with the quantities of this view.
      this.requests.cancel("diagram");
      this.requests.cancel("orbit");
    }
    if (view.at !== before.at) this.#followed = view.at;
    this.#followDiagram();
    if (view.pins !== before.pins || view.pins.length > 0) this.#followPins();
    this.#followPlane(live);
    if (view.parameters[view.vary] !== before.parameters[view.vary] || view.at !== before.at) {
      this.#choosePlace();
    }
  }

  #followDiagram() {
    const { view } = this;
    const request = diagramRequest(view);
    const key = JSON.stringify(request);
    if (key === this.#keys.diagram) return;
    this.#keys.diagram = key;
    this.isMore = false;
    this.progressed.announce(null);
    clearTimeout(this.#rest);
    const rested = new Promise((resolve) => { this.#rest = setTimeout(resolve, REST); });
    const ask = (rests) => this.requests.ask({ ...request, rests }, { onAnswer, onError });
    const onAnswer = (answer) => {
      if (answer.progress) {
        this.progressed.announce(answer);
        return;
      }
      if (answer.done && answer.more) rested.then(() => key === this.#keys.diagram && ask(true));
      this.diagram = answer;
      this.#hasFailed = false;
      this.#settled = answer.done && !answer.more ? key : null;
      this.isMore = Boolean(answer.more);
      this.#fail("diagram", null);
      this.diagramArrived.announce({ answer, view, request });
      this.#choosePlace();
      if (!this.store.isLive && this.view.at && this.#followed && this.#followed.y !== this.view.at.y) {
        this.store.amend({ at: this.#followed });
      }
    };
    const onError = (sentence, again) => {
      this.#settled = key;
      if (!this.isMore) { // else what is drawn is exact, and lacks branches
        this.#hasFailed = true;
        this.place = null;
        this.placeChanged.announce(null);
        this.#askOrbit(null);
      }
      this.isMore = false;
      this.#fail("diagram", sentence, again && (() => {
        this.#keys.diagram = "";
        this.#followDiagram();
      }));
    };
    ask(!this.store.isLive);
  }

  #followPins() {
    const { view } = this;
    const kept = new Set(view.pins.map((pin) => pin.id));
    for (const id of [...this.#pinKeys.keys()].filter((pinned) => !kept.has(pinned))) {
      this.#pinKeys.delete(id);
      this.pins.delete(id);
      this.requests.cancel("diagram", `pin:${id}`);
      this.#fail(`pin:${id}`, null);
    }
    for (const pin of view.pins) {
      const request = { ...diagramRequest(view, pin.parameters), slot: `pin:${pin.id}` };
      const key = JSON.stringify(request);
      if (key === this.#pinKeys.get(pin.id) && this.pins.has(pin.id)) continue;
      if (key === this.#pinKeys.get(pin.id) && this.requests.isBusy("diagram", request.slot)) continue;
      this.#pinKeys.set(pin.id, key);
      const onAnswer = (answer) => {
        if (answer.progress) return;
        this.pins.set(pin.id, answer);
        this.#fail(request.slot, null);
        this.pinsChanged.announce(this.pins);
      };
      const onError = (sentence, again) => this.#fail(request.slot, sentence, again && (() => {
        this.#pinKeys.delete(pin.id);
        this.#followPins();
      }));
      this.requests.ask(request, { onAnswer, onError });
    }
    this.pinsChanged.announce(this.pins);
  }

  #followPlane(live) {
    if (!this.view.plane) {
      if (this.#keys.plane) this.requests.cancel("plane");
      this.#fail("plane", null);
      this.#keys.plane = "";
      return;
    }
    const request = planeRequest(this.view);
    const key = JSON.stringify(request);
    if (key === this.#keys.plane) {
      this.planeChanged.announce({ isSame: true });
      return;
    }
    this.planeChanged.announce({ stale: true });
    if (live) return;
    this.#keys.plane = key;
    const onAnswer = (answer) => {
      this.#fail("plane", null);
      const { plane } = this.view;
      const stale = !plane || key !== JSON.stringify(planeRequest(this.view));
      this.planeChanged.announce({ ...(answer.progress ? answer : { answer, request }), stale });
    };
    const onError = (sentence, again) =>
      this.#fail("plane", sentence, again && (() => this.computePlane()));
    this.requests.ask(request, { onAnswer, onError }, { supersede: true });
  }

  #choosePlace() {
    if (!this.#isAlong || this.#hasFailed) return;
    const { view } = this;
    const value = view.parameters[view.vary];
    const place = chosenPlace(crossings(this.diagram, value), this.#followed ?? view.at);
    this.place = asSpecial(this.diagram, place);
    // A branch that is known by its height alone may still be missing.
    if (this.place && this.#followed && (this.#followed.branch !== ANY || this.isSettled)) {
      this.#followed = { branch: this.place.branch, y: this.place.y };
    }
    this.placeChanged.announce(this.place);
    if (!this.#hovered) this.#askOrbit(this.place);
  }

  #askOrbit(place) {
    if (!place) {
      this.requests.cancel("orbit");
      this.#fail("orbit", null);
      this.orbitArrived.announce(null);
      return;
    }
    const { view } = this;
    const request = orbitRequest(view, place);
    const key = JSON.stringify(request);
    if (key === this.#keys.orbit && this.requests.isBusy("orbit")) return;
    this.#keys.orbit = key;
    const kept = this.#orbits.get(key);
    if (kept) {
      this.requests.cancel("orbit");
      this.#fail("orbit", null);
      this.orbitArrived.announce({ answer: kept, place, view, request });
      return;
    }
    const onAnswer = (answer) => {
      this.#orbits.set(key, answer);
      if (this.#orbits.size > KEPT_ORBITS) this.#orbits.delete(this.#orbits.keys().next().value);
      this.#fail("orbit", null);
      this.orbitArrived.announce({ answer, place, view, request });
    };
    const onError = (sentence, again) =>
      this.#fail("orbit", sentence, again && (() => this.#askOrbit(this.#hovered ?? this.place)));
    this.requests.ask(request, { onAnswer, onError });
    this.orbitAwaited.announce();
  }

  #fail(kind, sentence, again = null) {
    this.failed.announce({ kind, sentence, again: again || null });
  }
}
