/** The connection to the server, and the requests over it. */

import { Signal } from "./store.js";

/** Milliseconds between attempts; the last is kept for ever. */
const DELAYS = [300, 700, 1500, 3000, 5000];

/** Attempts after which it is no longer a matter of moments. */
const PATIENCE = 3;

/** Codes with which the server says why it closes: too many pages, too many requests. */
const WITH_REASON = [1008, 1013];

const SENTENCES = {
  lost: "Connection lost; trying again.",
  stopped: "slipfold explore does not answer: it was stopped, or its machine is not reached. Start it again and open the address that it prints; what follows the # in this page's address, put behind that one, shows this view again.",
  refused: "slipfold explore was started anew and does not know this page. Open the address that it printed, with its token; this page then goes on by itself.",
};

/**
 * States: `"connecting"`, `"open"`, `"lost"` (trying again), and, while it still tries now and then,
 * `"stopped"` (nobody answers) and `"refused"` (this page is not let in).
 */
export class Connection {
  /** Announces `{state, sentence}`; the sentence is null where all is well. */
  changed = new Signal();
  /** Announces each message, parsed. */
  received = new Signal();
  state = "connecting";
  #socket = null;
  #attempts = 0;
  #timer = 0;

  /** @param {string} address of the WebSocket */
  constructor(address) {
    this.address = address;
  }

  /** Whether answers come, or will in a moment. */
  get isAlive() {
    return this.state !== "stopped" && this.state !== "refused";
  }

  /** Open the socket, now and whenever it is lost. */
  open() {
    clearTimeout(this.#timer);
    const socket = new WebSocket(this.address);
    this.#socket = socket;
    socket.onopen = () => {
      this.#attempts = 0;
      this.#become("open");
    };
    socket.onmessage = (event) => this.received.announce(JSON.parse(event.data));
    socket.onclose = ({ code, reason }) => this.#lost(WITH_REASON.includes(code) ? reason : "");
  }

  /**
   * Send a message if the socket is open.
   * @returns {boolean} whether it went out
   */
  send(message) {
    if (this.#socket?.readyState !== WebSocket.OPEN) return false;
    this.#socket.send(JSON.stringify(message));
    return true;
  }

  #become(state, sentence = SENTENCES[state] ?? null) {
    this.state = state;
    this.changed.announce({ state, sentence });
  }

  async #lost(reason) {
    const delay = DELAYS[Math.min(this.#attempts, DELAYS.length - 1)];
    this.#attempts += 1;
    if (reason) this.#become("stopped", `slipfold explore closed the connection: ${reason}.`);
    else if (this.#attempts > 1 && (await isRefused())) this.#become("refused");
    else if (this.#attempts > PATIENCE) this.#become("stopped");
    else this.#become("lost");
    this.#timer = setTimeout(() => this.open(), delay);
  }
}

/** Whether a server answers but does not let this page in: it was started anew. */
async function isRefused() {
  try {
    return (await fetch("/api/models")).status === 401;
  } catch {
    return false;
  }
}

/** Texts of the models that were written on the page, by the names that the page gave them. */
export const texts = new Map();

/** A request with the text of its model, if the model was written on the page. */
export function withText(request) {
  const text = texts.get(request.model);
  return text === undefined ? request : { ...request, text };
}

/** Milliseconds after which what is computed gives way to what is newer: it is not soon there. */
const SLOW = 1500;

/**
 * @typedef {object} Receiver
 * @property {(answer: any) => void} onAnswer
 * @property {(sentence: string, again: boolean) => void} onError again: whether asking again may help
 */

export class Requests {
  #connection;
  #lines = new Map();
  #nextId = 1;

  constructor(connection) {
    this.#connection = connection;
    connection.received.subscribe((message) => this.#deliver(message));
    connection.changed.subscribe(({ state }) => state === "open" && this.#sendAgain());
  }

  /**
   * Ask for something.
   * @param {object} request with `kind`, and `slot` unless it is live
   * @param {{supersede?: boolean}} [how] supersede: cancel what is being computed instead of waiting
   */
  ask(request, receiver, { supersede = false } = {}) {
    const key = lineOf(request);
    const line = this.#lines.get(key) ?? { sent: null, waiting: null };
    this.#lines.set(key, line);
    line.waiting = { request, receiver };
    const isOld = line.sent !== null && performance.now() - line.sent.at > SLOW;
    if (supersede || line.sent === null || line.sent.isDrawn || isOld) this.#send(line);
  }

  /** Stop what is being computed and forget what waits. */
  cancel(kind, slot = "live") {
    const line = this.#lines.get(`${kind} ${slot}`);
    if (!line) return;
    if (line.sent) this.#connection.send({ kind: "cancel", id: this.#nextId++, slot, of: kind });
    line.sent = line.waiting = null;
  }

  /** Whether an answer is still to come. */
  isBusy(kind, slot = "live") {
    return Boolean(this.#lines.get(`${kind} ${slot}`)?.sent);
  }

  /** What is being computed besides one kind, in words; empty if nothing is. */
  meanwhile(besides = "") {
    const kinds = new Set([...this.#lines.values()].flatMap(({ sent }) => sent?.request.kind ?? []));
    kinds.delete(besides);
    return new Intl.ListFormat("en").format([...kinds].map((kind) => `the ${kind}`));
  }

  #send(line) {
    const { request, receiver } = line.waiting;
    const id = this.#nextId++;
    line.sent = { id, request, receiver, at: performance.now() };
    line.waiting = null;
    this.#connection.send(withText({ ...request, id }));
  }

  #deliver(message) {
    const line = this.#lines.get(lineOf(message));
    const sent = line?.sent;
    if (!sent || message.id !== sent.id) return;
    if ("error" in message || message.done) line.sent = null;
    // Once the slider has moved on, the drawn part is enough: the newest request does not wait for the rest.
    if (message.more) sent.isDrawn = true;
    if (line.waiting && (line.sent === null || sent.isDrawn)) this.#send(line);
    if ("error" in message) sent.receiver.onError(message.error, Boolean(message.again));
    else sent.receiver.onAnswer(message);
  }

  /** What was under way when the connection was lost is requested once more. */
  #sendAgain() {
    for (const line of this.#lines.values()) {
      if (line.waiting === null && line.sent !== null) line.waiting = line.sent;
      if (line.waiting !== null) this.#send(line);
    }
  }
}

function lineOf({ kind, slot = "live" }) {
  return `${kind} ${slot}`;
}
