/** The bar at the top: models, files to save, the tour. */

import { withText } from "./connection.js";
import { Choice, button, element, icon, roving, set } from "./dom.js";
import { offered } from "./model/editor.js";
import { apply, choice, isPresented, nextChoice, present } from "./theme.js";
import { initialView, isShort } from "./view.js";

/** Save something as a file. */
export function download(blob, name) {
  const address = URL.createObjectURL(blob);
  const link = document.createElement("a");
  link.href = address;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

/**
 * Put text on the clipboard.
 * @returns {Promise<boolean>} whether it is there
 */
export async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return false;
  }
}

/**
 * Ask the server for a view in another form.
 * @param {object} view the request that made it
 * @param {{measurements?: object|null, pins?: object[]}} [more] the file whose measurements are drawn on it,
 *   and curves beside it
 * @throws {Error} with the server's sentence
 */
export async function exported(view, format, { measurements = null, pins = [] } = {}) {
  const { name = null, text = null } = measurements ?? {};
  return posted("/api/export", JSON.stringify(
    { view: withText({ id: 0, ...view }), format, measurements: name, measured: text, pins }));
}

/**
 * Send JSON to the server.
 * @throws {Error} with the server's sentence
 */
export async function posted(address, body) {
  const response = await fetch(address, { method: "POST", headers: { "Content-Type": "application/json" }, body });
  if (!response.ok) throw new Error(await sentenceOf(response));
  return response;
}

async function sentenceOf(response) {
  const text = await response.text();
  try {
    const { error, detail } = JSON.parse(text);
    return [error, detail].find((part) => typeof part === "string") ?? text;
  } catch {
    return text;
  }
}

const SHARE = "M8 10V2.5M5 5l3-3 3 3M3 9v4.5h10V9";
const TYPES = { csv: "CSV", nc: "netCDF", pdf: "PDF", svg: "SVG", png: "PNG" };

/** Formats of figures in the style of the package, which the server draws. */
const FIGURES = ["pdf", "svg", "png"];

/**
 * @typedef {object} Source
 * @property {(format?: string) => object|null} [request] what made the view; null if there is nothing yet
 * @property {boolean} [isCommand] whether a command of the command line computes it and draws its figure
 * @property {() => string} [table] the rows of a spreadsheet, of what the server cannot make again
 * @property {(format: "png"|"svg") => Promise<Blob>} picture
 * @property {() => object[]} [pins] curves beside it: names and parameters
 * @property {() => object|null} [measurements] name and text of the file whose measurements are drawn
 */

export class ExportMenu {
  /** The element to put on the page. */
  node;
  #source;
  #name;
  #say;
  #dialog;
  #meanwhile;

  /** @param {string} name of the files, e.g. `"diagram"` */
  constructor(name, source, { dialog, say, meanwhile }) {
    this.#source = source;
    this.#name = name;
    this.#dialog = dialog;
    this.#say = say;
    this.#meanwhile = meanwhile;
    // What distinguishes figures from pictures is said where there are both.
    const item = (text, act, use = null) => button(text, () => this.#act(act), { role: "menuitem", "data-use": use });
    const menu = element("div", { class: "menu", role: "menu", "aria-label": `Export the ${name}` },
      ...(source.table ? [] : [item("Copy as Python", () => this.#text("python", "Python"))]),
      ...(source.isCommand ? [
        item("Copy as TOML", () => this.#text("toml", "TOML")),
        ...FIGURES.map((format) => item(`Figure, ${format.toUpperCase()}`, () => this.#file(format), "for print")),
      ] : []),
      ...["png", "svg"].map((format) => item(`Picture, ${format.toUpperCase()}`, () => this.#picture(format), source.isCommand ? "as shown" : null)),
      ...(source.table ? [item("CSV", () => this.#table())]
        : [item("CSV", () => this.#file("csv")), item("netCDF", () => this.#file("nc"))]));
    this.node = element("details", { class: "export" },
      element("summary", { "aria-label": `Export the ${name}`, title: "Copy or save" }, icon(SHARE)), menu);
    this.node.addEventListener("toggle", () => this.node.open && this.#refuse(menu.children));
    this.node.addEventListener("focusout", (event) => {
      if (!this.node.contains(event.relatedTarget)) this.node.open = false;
    });
    this.node.addEventListener("keydown", (event) => this.#key(event, [...menu.children]));
  }

  /** Mark what cannot be had now, with the reason. */
  #refuse(items) {
    const reason = this.#refusal;
    for (const item of items) set(item, { "aria-disabled": reason && "true", title: reason });
  }

  get #refusal() {
    return this.#source.table || this.#source.request() ? null : `There is no ${this.#name} yet.`;
  }

  async #act(act) {
    const reason = this.#refusal;
    if (reason) {
      this.#say(reason);
      return;
    }
    this.node.open = false;
    // What has the focus now gets it back from a dialog, and the items of a closed menu cannot.
    this.node.querySelector("summary").focus();
    try {
      await act();
    } catch (error) {
      this.#say(error.message);
    }
  }

  async #text(format, language) {
    const text = await (await this.#made(format, `the text in ${language}`)).text();
    this.#say("");
    this.#dialog.show(`The ${this.#name} in ${language}`, text, await copy(text));
  }

  /** Have the server make something; while that lasts, say so, and what else takes its time. */
  async #made(format, what) {
    const others = this.#meanwhile();
    this.#say(`Making ${what}${others && `; computed meanwhile: ${others}`}…`, true);
    const [pins, measurements] = [this.#source.pins?.() ?? [], this.#source.measurements?.() ?? null];
    return exported(this.#source.request(format), format, { pins, measurements });
  }

  async #picture(format) {
    download(await this.#source.picture(format), `slipfold-${this.#name}.${format}`);
    this.#say(`Saved as ${format.toUpperCase()}.`);
  }

  #table() {
    download(new Blob([this.#source.table()], { type: "text/csv" }), `slipfold-${this.#name}.csv`);
    this.#say("Saved as CSV.");
  }

  async #file(format) {
    const blob = await (await this.#made(format, `the ${TYPES[format]} file`)).blob();
    download(blob, `slipfold-${this.#name}.${format}`);
    this.#say(`Saved as ${TYPES[format]}.`);
  }

  #key(event, items) {
    const here = items.indexOf(document.activeElement);
    const next = { ArrowDown: here + 1, ArrowUp: here - 1, Home: 0, End: items.length - 1 }[event.key];
    if (event.key === "Escape" && this.node.open) {
      this.node.open = false;
      this.node.querySelector("summary").focus();
      event.stopPropagation();
    } else if (next !== undefined && this.node.open) {
      items.at(next % items.length).focus();
      event.preventDefault();
    }
  }
}

const UNDO = "M6.5 3.5L3 7l3.5 3.5M3.5 7H10a3 3 0 0 1 0 6H8";
const REDO = "M9.5 3.5L13 7l-3.5 3.5M12.5 7H6a3 3 0 0 0 0 6h2";
const LINK = "M6.5 9.5l3-3M7 5l1.5-1.5a2.5 2.5 0 0 1 4 3.5L11 8.5M9 11l-1.5 1.5a2.5 2.5 0 0 1-4-3.5L5 7.5";
const SCREEN = "M1.5 2.5h13M2.5 2.5v8h11v-8M8 10.5v3M5 13.5h6";
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
  #present;
  #say;

  constructor(session, { status, say, tour, editor }) {
    this.#session = session;
    this.#say = say;
    const { store } = session;
    this.#model = new Choice("Model", (name) => this.#pick(name));
    this.#undo = tool("Undo (Ctrl+Z)", UNDO, () => store.undo());
    this.#redo = tool("Redo (Ctrl+Shift+Z)", REDO, () => store.redo());
    const link = tool("Copy the link to this view", LINK, async () => {
      const isWhole = isShort(session.model);
      const isCopied = isWhole && (await copy(location.href));
      if (isWhole) say(isCopied ? "Link copied." : "The link could not be copied; it is the address of this page.");
      else say("The model is too long for a link; open its editor and save it with this view.");
    });
    this.#theme = tool("", "", () => {
      apply(nextChoice());
      this.#showTheme();
    });
    this.#present = tool("Present: large type, without controls (p)", SCREEN, () => this.#toggle(true));
    const tourButton = button("Tour", () => tour.start(), { class: "quiet" });
    this.node = element("header", { class: "masthead" },
      element("h1", {}, "slipfold ", element("span", {}, "explore")), this.#model.node,
      roving(element("span", { class: "tools", role: "toolbar", "aria-label": "View" },
        editor.opener, this.#undo, this.#redo, link, this.#present, tourButton, this.#theme)), status);
    store.changed.subscribe(() => this.#show());
    document.addEventListener("keydown", (event) => this.#key(event));
    this.#showTheme();
    this.#show();
  }

  #show() {
    const { models, view, store } = this.#session;
    this.#model.show(offered(models, view.model).map(({ name, title }) => ({ value: name, text: title ? `${name}: ${title}` : name })), view.model);
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

  /** Hide the controls and enlarge the rest, or take that back. */
  #toggle(isOn) {
    present(isOn);
    this.#say(isOn ? "Press p or Esc to show the controls again." : "");
    if (!isOn) this.#present.focus();
  }

  #key(event) {
    const isTyping = event.target.matches("input[type=text], textarea, select");
    const isPlain = !event.ctrlKey && !event.metaKey && !event.altKey && !event.defaultPrevented;
    const isToggle = event.key === "Escape" ? isPresented() : event.key === "p" && !isTyping;
    if (isPlain && isToggle) this.#toggle(!isPresented());
    if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z" || isTyping) return;
    event.preventDefault();
    if (event.shiftKey) this.#session.store.redo();
    else this.#session.store.undo();
  }
}

function tool(name, path, click) {
  return button(icon(path), click, { class: "tool", "aria-label": name, title: name });
}
