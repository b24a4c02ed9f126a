/** What a panel shows, in the forms in which it can leave the page. */

import { element, icon } from "./dom.js";
import { copy, download, exported } from "./files.js";

const SHARE = "M8 10V2.5M5 5l3-3 3 3M3 9v4.5h10V9";
const TYPES = { csv: "CSV", nc: "netCDF" };

/**
 * @typedef {object} Source
 * @property {() => object|null} [request] what made the view; null if there is nothing yet
 * @property {() => string} [table] the rows of a spreadsheet, of what the server cannot make again
 * @property {(format: "png"|"svg") => Promise<Blob>} picture
 * @property {() => string|null} [readings] name of the file whose readings are drawn
 */

export class ExportMenu {
  /** The element to put on the page. */
  node;
  #source;
  #name;
  #say;
  #dialog;

  /**
   * @param {string} name of the files, e.g. `"diagram"`
   * @param {Source} source
   * @param {{dialog: import("./text_dialog.js").TextDialog, say: (sentence: string) => void}} page
   */
  constructor(name, source, { dialog, say }) {
    this.#source = source;
    this.#name = name;
    this.#dialog = dialog;
    this.#say = say;
    const item = (text, act) => element("button", {
      type: "button", role: "menuitem", on: { click: () => this.#act(act) },
    }, text);
    const menu = element("div", { class: "menu", role: "menu", "aria-label": `Export the ${name}` },
      ...(source.table ? [] : [
        item("Copy as Python", () => this.#text("python", "Python")),
        item("Copy as TOML", () => this.#text("toml", "TOML")),
      ]),
      item("PNG", () => this.#picture("png")), item("SVG", () => this.#picture("svg")),
      ...(source.table ? [item("CSV", () => this.#table())]
        : [item("CSV", () => this.#file("csv")), item("netCDF", () => this.#file("nc"))]));
    this.node = element("details", { class: "export" },
      element("summary", { "aria-label": `Export the ${name}`, title: "Copy or save" }, icon(SHARE)), menu);
    this.node.addEventListener("focusout", (event) => {
      if (!this.node.contains(event.relatedTarget)) this.node.open = false;
    });
    this.node.addEventListener("keydown", (event) => this.#key(event, [...menu.children]));
  }

  async #act(act) {
    this.node.open = false;
    // What has the focus now gets it back from a dialog, and the items of a closed menu cannot.
    this.node.querySelector("summary").focus();
    if (!this.#source.table && !this.#source.request()) {
      this.#say(`There is no ${this.#name} yet.`);
      return;
    }
    try {
      await act();
    } catch (error) {
      this.#say(error.message);
    }
  }

  async #text(format, language) {
    const readings = this.#source.readings?.() ?? null;
    const text = await (await exported(this.#source.request(), format, readings)).text();
    const isCopied = await copy(text);
    this.#dialog.show(`The ${this.#name} in ${language}`, text, isCopied);
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
    this.#say(`Computing the ${TYPES[format]} file…`);
    const blob = await (await exported(this.#source.request(), format)).blob();
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
