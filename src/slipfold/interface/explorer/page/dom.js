/** Elements of the page, and a choice among names. */

const SVG = "http://www.w3.org/2000/svg";

/**
 * Make an HTML element.
 * @param {Record<string, any>} [attributes] attributes; `on` holds listeners by event name; false
 * and null leave an attribute out
 */
export function element(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

/** Make an SVG element; otherwise as `element`. */
export function svg(tag, attributes = {}, ...children) {
  return filled(document.createElementNS(SVG, tag), attributes, children);
}

/** Set several attributes. */
export function set(node, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === false || value === undefined) node.removeAttribute(name);
    else node.setAttribute(name, value === true ? "" : String(value));
  }
}

/**
 * A picture of the page's own set, drawn from a path.
 * @param {string} path of a 16 by 16 drawing
 */
export function icon(path) {
  return svg("svg", { viewBox: "0 0 16 16", class: "icon", "aria-hidden": "true" },
    svg("path", { d: path }));
}

/** A button with words on it. */
export function button(text, click, attributes = {}) {
  return element("button", { type: "button", ...attributes, on: { click } }, text);
}

/** The small cross that closes or removes something. */
export function closeButton(name, click) {
  return button(icon("M4 4l8 8M12 4l-8 8"), click, { class: "quiet close", "aria-label": name });
}

function filled(node, { on = {}, ...attributes }, children) {
  set(node, attributes);
  for (const [event, listener] of Object.entries(on)) node.addEventListener(event, listener);
  node.append(...children.filter((child) => child !== null && child !== undefined).map(asNode));
  return node;
}

function asNode(child) {
  return child instanceof Node ? child : document.createTextNode(String(child));
}

export class Choice {
  /** The element to put on the page. */
  node;
  #select;
  #options = "";

  constructor(label, chosen, isLabelSeen = true) {
    this.#select = element("select", {
      "aria-label": label,
      on: { change: () => chosen(this.#select.value) },
    });
    this.node = element("label", { class: "choice" },
      isLabelSeen ? element("span", {}, label) : null, this.#select);
  }

  /** Show what there is and what is chosen. */
  show(options, value) {
    const key = JSON.stringify(options);
    if (key !== this.#options) {
      this.#options = key;
      this.#select.replaceChildren(...options.map((option) =>
        element("option", { value: option.value, title: option.title ?? null }, option.text)));
    }
    this.#select.value = value;
  }
}

/**
 * What calls an action once after the next frame, however often it is called itself. In a frame the
 * browser lays out the page; what asks for sizes before makes it do so twice.
 */
export function afterFrame(action) {
  let isDue = false;
  return () => {
    if (isDue) return;
    isDue = true;
    requestAnimationFrame(() => setTimeout(() => {
      isDue = false;
      action();
    }));
  };
}

/** What moves the focus within a list or toolbar: by how many, or to which end. */
const MOVES = { ArrowRight: 1, ArrowLeft: -1, ArrowDown: 1, ArrowUp: -1 };

/**
 * Make the buttons within an element one stop of the tabulator; arrow keys move between them.
 * @param {HTMLElement} node whose buttons may come and go
 * @returns {HTMLElement} the same
 */
export function roving(node) {
  const items = () => [...node.querySelectorAll("button, summary")].filter((item) =>
    !item.disabled && !item.closest(".menu") && item.checkVisibility());
  const stop = (chosen) => items().forEach((item) => set(item, { tabindex: item === chosen ? "0" : "-1" }));
  const restore = () => {
    const all = items();
    if (all.filter(({ tabIndex }) => tabIndex === 0).length !== 1) stop(all.find(({ tabIndex }) => tabIndex === 0) ?? all[0]);
  };
  node.addEventListener("focusin", ({ target }) => items().includes(target) && stop(target));
  node.addEventListener("keydown", (event) => {
    const all = items();
    const here = all.indexOf(event.target);
    const next = { Home: 0, End: all.length - 1 }[event.key] ?? here + MOVES[event.key];
    if (here < 0 || event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey || !all[next]) return;
    all[next].focus();
    event.preventDefault();
  });
  new MutationObserver(afterFrame(restore)).observe(node, { childList: true, subtree: true, attributeFilter: ["disabled", "hidden"] });
  new ResizeObserver(restore).observe(node);
  return node;
}
