/** The WebSocket: opens, says when it is lost, and opens again by itself. */

import { Signal } from "./signal.js";

const DELAYS = [300, 700, 1500, 3000, 5000];

/**
 * States: `"connecting"`, `"open"`, `"lost"` (trying again), `"refused"` (another address is needed).
 */
export class Connection {
  /** Announces `{state, sentence}`. */
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

  /** Open the socket, now and whenever it is lost. */
  open() {
    clearTimeout(this.#timer);
    const socket = new WebSocket(this.address);
    this.#socket = socket;
    socket.onopen = () => {
      this.#attempts = 0;
      this.#become("open", "Connected");
    };
    socket.onmessage = (event) => this.received.announce(JSON.parse(event.data));
    socket.onclose = () => this.#lost();
  }

  /**
   * Send a message if the socket is open.
   * @param {object} message
   * @returns {boolean} whether it went out
   */
  send(message) {
    if (this.#socket?.readyState !== WebSocket.OPEN) return false;
    this.#socket.send(JSON.stringify(message));
    return true;
  }

  #become(state, sentence) {
    this.state = state;
    this.changed.announce({ state, sentence });
  }

  async #lost() {
    const delay = DELAYS[Math.min(this.#attempts, DELAYS.length - 1)];
    this.#attempts += 1;
    this.#become("lost", "Connection lost; trying again");
    if (this.#attempts > 1 && (await refused())) {
      this.#become("refused", "Open the address that slipfold explore printed, with its token");
      return;
    }
    this.#timer = setTimeout(() => this.open(), delay);
  }
}

/** Whether a server answers but does not let this page in: it was started anew. */
async function refused() {
  try {
    return (await fetch("/api/models")).status === 401;
  } catch {
    return false;
  }
}
