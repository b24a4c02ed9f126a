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
