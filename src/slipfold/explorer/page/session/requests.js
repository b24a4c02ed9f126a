/**
 * Requests to the server. Of each kind and slot one is computed at a time; of those that come
 * meanwhile only the newest is kept. So a curve is redrawn as often as it can be computed, and the
 * last position of a slider is always drawn. What takes long is given up for what is newer.
 */

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

  /** @param {import("./connection.js").Connection} connection */
  constructor(connection) {
    this.#connection = connection;
    connection.received.subscribe((message) => this.#deliver(message));
    connection.changed.subscribe(({ state }) => state === "open" && this.#sendAgain());
  }

  /**
   * Ask for something.
   * @param {object} request with `kind`, and `slot` unless it is live
   * @param {Receiver} receiver
   * @param {{supersede?: boolean}} [how] supersede: cancel what is being computed instead of waiting
   */
  ask(request, receiver, { supersede = false } = {}) {
    const key = lineOf(request);
    const line = this.#lines.get(key) ?? { sent: null, waiting: null };
    this.#lines.set(key, line);
    line.waiting = { request, receiver };
    const isOld = line.sent !== null && performance.now() - line.sent.at > SLOW;
    if (supersede || line.sent === null || line.sent.drafted || isOld) this.#send(line);
  }

  /**
   * Stop what is being computed and forget what waits.
   * @param {string} kind
   * @param {string} [slot]
   */
  cancel(kind, slot = "live") {
    const line = this.#lines.get(`${kind} ${slot}`);
    if (!line) return;
    if (line.sent) this.#connection.send({ kind: "cancel", id: this.#nextId++, slot, of: kind });
    line.sent = line.waiting = null;
  }

  /**
   * Whether an answer is still to come.
   * @param {string} kind
   * @param {string} [slot]
   */
  isBusy(kind, slot = "live") {
    return Boolean(this.#lines.get(`${kind} ${slot}`)?.sent);
  }

  #send(line) {
    const { request, receiver } = line.waiting;
    const id = this.#nextId++;
    line.sent = { id, request, receiver, at: performance.now() };
    line.waiting = null;
    this.#connection.send({ ...request, id });
  }

  #deliver(message) {
    const line = this.#lines.get(lineOf(message));
    const sent = line?.sent;
    if (!sent || message.id !== sent.id) return;
    if ("error" in message || message.done) line.sent = null;
    // A draft is enough where the slider has moved on: refining it would keep the newest waiting.
    if (message.draft) sent.drafted = true;
    if (line.waiting && (line.sent === null || sent.drafted)) this.#send(line);
    if ("error" in message) sent.receiver.onError(message.error, Boolean(message.again));
    else sent.receiver.onAnswer(message);
  }

  /** What was under way when the connection was lost is asked for once more. */
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
