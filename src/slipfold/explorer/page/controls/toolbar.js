/** The head of the page: model, undo and redo, link, tour, theme. */

import { Choice } from "./choice.js";
import { element, icon } from "./dom.js";
import { copy } from "./files.js";
import { apply, choice, nextChoice } from "../style/theme.js";
import { initialView } from "../session/view.js";

const UNDO = "M6.5 3.5L3 7l3.5 3.5M3.5 7H10a3 3 0 0 1 0 6H8";
const REDO = "M9.5 3.5L13 7l-3.5 3.5M12.5 7H6a3 3 0 0 0 0 6h2";
const LINK = "M6.5 9.5l3-3M7 5l1.5-1.5a2.5 2.5 0 0 1 4 3.5L11 8.5M9 11l-1.5 1.5a2.5 2.5 0 0 1-4-3.5L5 7.5";
const THEMES = { auto: "Theme: as the system", light: "Theme: light", dark: "Theme: dark" };
const SUNS = {
  auto: "M8 2.5a5.5 5.5 0 1 0 0 11zM8 2.5a5.5 5.5 0 0 1 0 11",
  light: "M8 5a3 3 0 1 1 0 6a3 3 0 1 1 0-6M8 1v2M8 13v2M1 8h2M13 8h2M3 3l1.4 1.4M11.6 11.6L13 13M13 3l-1.4 1.4M4.4 11.6L3 13",
  dark: "M12.8 10A5.5 5.5 0 1 1 6 3.2A4.5 4.5 0 0 0 12.8 10z",
};

export class Toolbar {
  /** The element to put on the page. */
  node;
  #session;
  #model;
  #undo;
  #redo;
  #theme;

  /**
   * @param {import("../session/session.js").Session} session
   * @param {{status: HTMLElement, say: (sentence: string) => void, tour: import("./tour.js").Tour}} page
   */
  constructor(session, { status, say, tour }) {
    this.#session = session;
    const { store } = session;
    this.#model = new Choice("Model", (name) => this.#pick(name));
    this.#undo = tool("Undo (Ctrl+Z)", UNDO, () => store.undo());
    this.#redo = tool("Redo (Ctrl+Shift+Z)", REDO, () => store.redo());
    const link = tool("Copy the link to this view", LINK, async () =>
      say((await copy(location.href)) ? "Link copied." : "The link is this page's address."));
    this.#theme = tool("", "", () => {
      apply(nextChoice());
      this.#showTheme();
    });
    const tourButton = element("button", {
      type: "button", class: "quiet", on: { click: () => tour.start() },
    }, "Tour");
    this.node = element("header", { class: "masthead" },
      element("h1", {}, "slipfold ", element("span", {}, "explore")), this.#model.node,
      element("span", { class: "tools" }, this.#undo, this.#redo, link),
      element("span", { class: "tools end" }, status, tourButton, this.#theme));
    store.changed.subscribe(() => this.#show());
    document.addEventListener("keydown", (event) => this.#key(event));
    this.#showTheme();
    this.#show();
  }

  #show() {
    const { models, view, store } = this.#session;
    this.#model.show(models.map(({ name, title }) => ({ value: name, text: title ? `${name}: ${title}` : name })), view.model);
    this.#undo.disabled = !store.canUndo;
    this.#redo.disabled = !store.canRedo;
  }

  #pick(name) {
    const model = this.#session.models.find((item) => item.name === name);
    this.#session.store.commit(initialView(model));
  }

  #showTheme() {
    this.#theme.setAttribute("aria-label", THEMES[choice()]);
    this.#theme.title = THEMES[choice()];
    this.#theme.replaceChildren(icon(SUNS[choice()]));
  }

  #key(event) {
    const isTyping = event.target.matches("input[type=text], textarea");
    if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z" || isTyping) return;
    event.preventDefault();
    if (event.shiftKey) this.#session.store.redo();
    else this.#session.store.undo();
  }
}

function tool(name, path, click) {
  return element("button", {
    type: "button", class: "tool", "aria-label": name, title: name, on: { click },
  }, icon(path));
}
