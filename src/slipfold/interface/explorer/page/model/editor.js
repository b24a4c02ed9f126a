/** The model as a text: shown, edited, opened from a file, saved, and made the model of the page. */

import { texts, withText } from "../connection.js";
import { button, closeButton, element, icon } from "../dom.js";
import { download, posted } from "../toolbar.js";
import { addressOf, initialView, readAddress } from "../view.js";

/** Characters that a model's name may have, so that a number fits behind it. */
const LONGEST_NAME = 180;

/** Bytes of the largest file that is read; the server says what is wrong with a smaller one. */
const LARGEST = 256 * 1024;

/**
 * Make the model of a text one of the page's.
 * @param {object[]} models as the server describes them
 * @param {string} [name] what it is called if that is free
 * @returns {Promise<object>} the model
 * @throws {Error} with the server's sentence
 */
export async function written(models, text, fileName = null, name = null) {
  const known = models.findLast((item) => item.text === text);
  if (known && !known.files) return known;
  const described = await (await posted("/api/model", JSON.stringify({ text, name: fileName }))).json();
  if (known?.files === described.files) return known; // a file that it names may have changed
  const base = described.name.slice(0, LONGEST_NAME);
  const taken = new Set(models.map((item) => item.name));
  const numbered = (count) => `${base} (edited${count > 1 ? ` ${count}` : ""})`;
  let count = 1;
  while (taken.has(numbered(count))) count += 1;
  const own = name !== null && !taken.has(name) ? name : numbered(count);
  const model = { ...described, name: own, base, text };
  models.push(model);
  texts.set(own, text);
  return model;
}

/** The models to choose from: of those that were written on the page the last of each name. */
export function offered(models, current) {
  return models.filter((item) =>
    !item.text || item.name === current || models.findLast(({ base }) => base === item.base) === item);
}

/**
 * Read a link; the text of a model that is in it becomes one of the page's.
 * @returns {Promise<{view: View|null, sentence: string|null}>} as `readAddress`
 */
export async function readLink(address, models) {
  const query = new URLSearchParams(address);
  const text = query.get("text");
  if (text === null) return readAddress(address, models);
  try {
    query.set("model", (await written(models, text, null, query.get("model"))).name);
  } catch (error) {
    return { view: null, sentence: `The model of this link cannot be used: ${error.message}` };
  }
  return readAddress(query.toString(), models);
}

/**
 * The view of a model that was edited: what was set on the page stays, unless the text sets it anew.
 * @param {object} before the model that the view is of
 */
export function carriedOver(view, before, model) {
  const usual = initialView(model);
  const values = new Map(before.parameters.map(({ name, value }) => [name, value]));
  const parameters = { ...usual.parameters };
  for (const { name, value } of model.parameters) {
    if (values.get(name) === value) parameters[name] = view.parameters[name];
  }
  const isKnown = (name) => model.parameters.some((item) => item.name === name);
  const isShown = [...model.states, ...model.outputs].some(({ name }) => name === view.show);
  const { vary, span, show, statistic, plane } = view;
  return {
    ...usual,
    parameters,
    ...(isKnown(vary) ? { vary, span } : {}),
    ...(isShown ? { show, statistic } : {}),
    ...(plane && isKnown(plane.x.name) && isKnown(plane.y.name) ? { plane } : {}),
  };
}

/** The comment in a saved model that holds the view: the file is a model to every other program. */
const HOLDS_VIEW = /^# slipfold explore: (\S*)\n/;

/** A model's text with the view of it. */
function saved(view, model, text) {
  const query = new URLSearchParams(addressOf(view, model));
  for (const name of ["model", "text"]) query.delete(name);
  return `# slipfold explore: ${query.toString().replaceAll("%7E", "~")}\n${text.replace(HOLDS_VIEW, "")}`;
}

/** What a text says of its model, and the equations, by group. */
function equationsOf({ title, about, groups }) {
  return [element("p", { class: "about-title" }, title), about ? element("p", {}, about) : null,
    ...groups.flatMap(({ title: name, rows }) => [element("h3", {}, name),
      element("table", {}, ...rows.map(([left, right, note]) => element("tr", {},
        element("th", { scope: "row" }, left), element("td", {}, "= ", right), element("td", { class: "note" }, note))))]),
  ].filter(Boolean);
}

const PEN = "M3 13l.7-3L10.5 3.2l2.3 2.3L6 12.3zM9 4.7L11.3 7";

export class ModelEditor {
  /** The panel to put on the page. */
  node;
  /** The button that opens it. */
  opener = element("button", {
    type: "button", class: "tool", "aria-label": "Edit the model", title: "Edit the model", "aria-expanded": "false",
    on: { click: () => (this.node.hidden ? this.open() : this.close()) },
  }, icon(PEN));
  #session;
  #say;
  #shown = null;
  #fileName = null;
  #lines = element("pre", { "aria-hidden": "true" });
  #text = element("textarea", {
    spellcheck: "false", wrap: "off", "aria-label": "The model as TOML", "aria-describedby": "editor-fault",
    on: {
      input: () => this.#changed(),
      scroll: () => { this.#lines.scrollTop = this.#text.scrollTop; },
      keydown: (event) => this.#key(event),
    },
  });
  #fault = element("div", { class: "fault", id: "editor-fault", role: "alert", hidden: true });
  #apply = button("Apply", () => this.apply(), { class: "main", title: "Ctrl+Enter" });
  #reload = button("Reload", () => this.#readAgain(), { title: "Read the file again" });
  #state = element("span", { role: "status" });
  #lined = element("div", { class: "lined" });
  #actions = element("div", { class: "actions" });
  #equations = element("div", { class: "equations", role: "region", tabindex: "0", "aria-label": "Equations" });
  #tabs = ["Text", "Equations"].map((name, i) => button(name, () => this.#turnTo(i === 0), { class: "small-button" }));
  #file = element("input", {
    type: "file", accept: ".toml,.txt", class: "unseen", tabindex: "-1", "aria-label": "File with a model",
    on: { change: () => this.#openFile(this.#file.files[0]) },
  });

  constructor(session, { say }) {
    this.#session = session;
    this.#say = say;
    this.node = element("section", {
      class: "editor", id: "editor", hidden: true, "aria-labelledby": "editor-heading",
      on: {
        dragover: (event) => event.preventDefault(),
        drop: (event) => this.#drop(event),
        keydown: (event) => event.key === "Escape" && this.close(),
      },
    },
    element("div", { class: "panel-head" }, element("h2", { id: "editor-heading" }, "Model"), ...this.#tabs,
      button("Open file…", () => this.#file.click()), button("Save", () => this.#save()), this.#reload,
      closeButton("Close the editor", () => this.close())),
    this.#lined, this.#equations, this.#fault, this.#actions, this.#file);
    this.#lined.append(this.#lines, this.#text);
    this.#actions.append(this.#state, this.#apply);
    this.#turnTo(true);
    session.store.changed.subscribe(() => this.node.hidden || this.#follow());
  }

  /** Open the panel with the text of the model. */
  async open() {
    this.node.hidden = false;
    this.opener.setAttribute("aria-expanded", "true");
    await this.#follow();
    this.#text.focus();
  }

  /** Close the panel; what was not applied stays in it. */
  close() {
    this.node.hidden = true;
    this.opener.setAttribute("aria-expanded", "false");
    this.opener.focus();
  }

  /**
   * Make the model of the text and show it.
   * @param {{isFile?: boolean}} [how] isFile: a file was opened, whose view is shown too
   */
  async apply({ isFile = false } = {}) {
    const text = this.#text.value;
    const isSameText = !isFile && !this.#isChanged && this.#fault.hidden;
    if (isSameText && !this.#session.model.files) {
      this.#showState("Nothing was changed.");
      return;
    }
    const session = this.#session;
    const { files } = session.model;
    this.#showState("Building the model…");
    this.#apply.disabled = true;
    try {
      const model = await written(session.models, text, this.#fileName);
      if (isSameText && model.files === files) {
        this.#showState("Nothing was changed.");
        return;
      }
      const { view, model: before } = session; // sliders may have moved meanwhile
      this.#adopt(model);
      const address = HOLDS_VIEW.exec(text)?.[1];
      const isSame = model.base === (before.base ?? before.name);
      if (address !== undefined && isFile) this.#show(readAddress(`model=${encodeURIComponent(model.name)}&${address}`, session.models));
      else session.store.commit(isSame ? carriedOver(view, before, model) : initialView(model));
      await this.#ask(model);
      this.#showState("Applied.");
    } catch (error) {
      this.#refuse(error.message);
    } finally {
      this.#apply.disabled = false;
    }
  }

  #show({ view, sentence }) {
    this.#session.store.commit(view);
    if (sentence) this.#say(sentence);
  }

  /** Show the text of another model, unless that in the panel was changed and not applied. */
  async #follow() {
    const { model } = this.#session;
    this.#reload.hidden = Boolean(model.text);
    if (model === this.#shown || this.#isChanged) return;
    await this.#read(model);
  }

  async #read(model) {
    try {
      const answer = await this.#ask(model);
      if (model !== this.#session.model) return;
      this.#fileName = null;
      this.#adopt(model, answer.text, answer.given);
      this.#text.setSelectionRange(0, 0); // it begins with what the model is
      this.#showState(this.#isChanged ? "The file has changed; Apply takes what is new in it." : "");
    } catch (error) {
      this.#refuse(error.message);
    }
  }

  /** Ask for the text of a model, and show the equations that come with it. */
  async #ask(model) {
    const answer = await (await posted("/api/text", JSON.stringify(withText({ model: model.name })))).json();
    if (model === this.#session.model) this.#equations.replaceChildren(...equationsOf(answer));
    return answer;
  }

  #turnTo(isText) {
    for (const node of [this.#lined, this.#actions]) node.hidden = !isText;
    this.#equations.hidden = isText;
    this.#tabs.forEach((tab, i) => tab.setAttribute("aria-pressed", String((i === 0) === isText)));
  }

  /** Read the file of the model again, and make what it holds now the model. */
  async #readAgain() {
    const before = this.#text.dataset.given;
    try {
      const { text } = await this.#ask(this.#session.model);
      this.#text.value = text;
    } catch (error) {
      this.#showState("");
      this.#accuse(error.message); // its line is one of the file, not of the text that is shown
      return;
    }
    this.#changed();
    if (this.#text.value === before && !this.#session.model.files) this.#showState("The file has not changed.");
    else await this.apply();
  }

  /** @param {string} [given] what the model was made of: its file may have changed since */
  #adopt(model, text = this.#text.value, given = text) {
    this.#shown = model;
    if (this.#text.value !== text) this.#text.value = text;
    this.#text.dataset.given = given;
    this.#changed();
  }

  get #isChanged() {
    return this.#shown !== null && this.#text.value !== this.#text.dataset.given;
  }

  #changed() {
    this.#accuse(null);
    this.#number();
    if (this.#isChanged) this.#showState("Changed, not applied.");
  }

  /** Number the lines; that with a mistake is marked. */
  #number(wrong = 0) {
    const count = this.#text.value.split("\n").length;
    this.#lines.replaceChildren(...Array.from({ length: count }, (_, i) =>
      element("span", { class: i + 1 === wrong && "wrong" }, `${i + 1}\n`)));
    this.#lines.scrollTop = this.#text.scrollTop;
  }

  #refuse(sentence) {
    this.#showState("");
    this.#accuse(sentence);
    const place = /line (\d+), column (\d+)/.exec(sentence);
    if (!place) return;
    const [line, column] = place.slice(1).map(Number);
    this.#number(line);
    const start = this.#text.value.split("\n").slice(0, line - 1).join("\n").length + (line > 1) + column - 1;
    this.#text.focus();
    this.#text.setSelectionRange(start, start);
  }

  #accuse(sentence) {
    this.#fault.hidden = sentence === null;
    const [words = "", ...excerpt] = (sentence ?? "").split("\n");
    this.#fault.replaceChildren(element("p", {}, words),
      ...(excerpt.length ? [element("pre", { tabindex: "0" }, excerpt.join("\n"))] : []));
  }

  #showState(state) {
    this.#state.textContent = state;
  }

  async #openFile(file) {
    if (!file) return;
    this.#file.value = "";
    this.#fileName = file.name;
    if (file.size > LARGEST) {
      this.#refuse(`${file.name} is larger than ${LARGEST / 1024} kB; start slipfold explore with it instead`);
      return;
    }
    this.#text.value = (await file.text()).replaceAll("\r\n", "\n");
    this.#changed();
    await this.apply({ isFile: true });
  }

  #drop(event) {
    if (!event.dataTransfer.files.length) return;
    event.preventDefault();
    this.#openFile(event.dataTransfer.files[0]);
  }

  async #save() {
    await this.#follow(); // the text may still be on its way
    if (this.#shown === null) return;
    const { view, model } = this.#session;
    const text = this.#isChanged ? this.#text.value : saved(view, model, this.#text.value);
    const name = (model.base ?? model.name).replace(/[^\w.-]+/g, "-");
    download(new Blob([text], { type: "application/toml" }), this.#fileName ?? `${name}.toml`);
    this.#showState(this.#isChanged ? "Saved as it stands, without the view." : "Saved with the view.");
  }

  #key(event) {
    if (event.key !== "Enter" || !(event.ctrlKey || event.metaKey)) return;
    event.preventDefault();
    this.apply();
  }
}
