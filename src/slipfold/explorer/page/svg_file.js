/** Drawings of the page as one SVG or PNG that needs no style sheet. */

import { set, svg } from "./dom.js";

const STYLES = [
  "fill", "stroke", "stroke-width", "stroke-dasharray", "stroke-linecap", "stroke-linejoin",
  "opacity", "font-family", "font-size", "font-style", "text-anchor", "vector-effect",
];

/**
 * Drawings at their places on the page, as one.
 * @param {SVGElement[]} drawings
 * @param {string} paper colour behind them
 * @returns {{text: string, width: number, height: number}}
 */
export function sheetOf(drawings, paper) {
  const boxes = drawings.map((drawing) => drawing.getBoundingClientRect());
  const left = Math.min(...boxes.map((box) => box.left));
  const top = Math.min(...boxes.map((box) => box.top));
  const width = Math.max(...boxes.map((box) => box.right)) - left;
  const height = Math.max(...boxes.map((box) => box.bottom)) - top;
  const sheet = svg("svg", { viewBox: `0 0 ${width} ${height}`, width, height },
    svg("rect", { width, height, fill: paper }),
    ...drawings.map((drawing, i) => placed(drawing, boxes[i], left, top)));
  sheet.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  return { text: new XMLSerializer().serializeToString(sheet), width, height };
}

/**
 * A sheet as a picture of twice its size.
 * @param {{text: string, width: number, height: number}} sheet
 * @returns {Promise<Blob>}
 */
export async function pictureOf({ text, width, height }) {
  const image = new Image();
  const address = URL.createObjectURL(new Blob([text], { type: "image/svg+xml" }));
  image.src = address;
  await image.decode();
  const canvas = Object.assign(document.createElement("canvas"), { width: 2 * width, height: 2 * height });
  canvas.getContext("2d").drawImage(image, 0, 0, 2 * width, 2 * height);
  URL.revokeObjectURL(address);
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}

function placed(drawing, box, left, top) {
  const copy = drawing.cloneNode(true);
  const originals = [drawing, ...drawing.querySelectorAll("*")];
  [copy, ...copy.querySelectorAll("*")].forEach((node, i) => {
    const style = getComputedStyle(originals[i]);
    for (const name of STYLES) node.style.setProperty(name, style.getPropertyValue(name));
    node.removeAttribute("class");
  });
  set(copy, { x: box.left - left, y: box.top - top, width: box.width, height: box.height });
  return copy;
}
