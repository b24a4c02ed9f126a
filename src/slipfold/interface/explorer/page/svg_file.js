/** Drawings of the page as one SVG or PNG that needs no style sheet. */

import { set, svg } from "./dom.js";

const STYLES = [
  "fill", "stroke", "stroke-width", "stroke-dasharray", "stroke-linecap", "stroke-linejoin",
  "opacity", "font-family", "font-size", "font-style", "text-anchor", "vector-effect", "paint-order",
];

/** Size of the lines that say what the whole sheet shows, in pixels. */
const LINE = 18;
const LETTER = 8.8;

/** Largest distance between drawings, in pixels. */
const GAP = 16;

/** Beside the drawings, in pixels. */
const MARGIN = 8;

/**
 * Drawings at their places on the page with their captions, as one.
 * @param {string} title what they show
 */
export function sheetOf(title, figures, color) {
  const parts = figures.flatMap(({ drawing, caption }) => [drawing, caption ?? drawing]);
  const boxes = parts.map((part) => part.getBoundingClientRect());
  const frames = figures.map(({ drawing, caption }) => frameOf([drawing, caption ?? drawing]));
  const lefts = frames.map((frame) => Math.min(...frames.filter((other) => areBeside(frame, other)).map(({ left }) => left)));
  const width = Math.max(...frames.map(({ right }, i) => right - lefts[i])) + 2 * MARGIN;
  const lines = wrapped(title, width / LETTER);
  const top = Math.min(...boxes.map((box) => box.top)) - LINE * lines.length - 12;
  const lifted = (box) => top + blankAbove(boxes, box.top);
  const height = Math.max(...boxes.map((box) => box.bottom - lifted(box)));
  const font = getComputedStyle(document.body).fontFamily;
  const sheet = svg("svg", { viewBox: `${-MARGIN} 0 ${width} ${height}`, width, height, "font-family": font },
    svg("rect", { x: -MARGIN, width, height, fill: color("panel") }),
    ...lines.map((line, i) => svg("text", {
      x: 10, y: LINE * (i + 1), "font-size": 14, "font-weight": 600, fill: color("ink"),
    }, line)),
    ...figures.map(({ drawing }, i) => placed(drawing, drawing.getBoundingClientRect(), lefts[i], lifted(drawing.getBoundingClientRect()))),
    ...figures.flatMap(({ caption }, i) => (caption ? captioned(caption, lefts[i], lifted(caption.getBoundingClientRect())) : [])));
  sheet.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  return { text: new XMLSerializer().serializeToString(sheet), width, height };
}

/** Where some elements are together. */
function frameOf(elements) {
  const boxes = elements.map((node) => node.getBoundingClientRect());
  return {
    left: Math.min(...boxes.map(({ left }) => left)), right: Math.max(...boxes.map(({ right }) => right)),
    top: Math.min(...boxes.map(({ top }) => top)), bottom: Math.max(...boxes.map(({ bottom }) => bottom)),
  };
}

/** Whether two frames stand in one row: each row begins at the left, whatever controls the page has there. */
function areBeside(one, other) {
  return one.top < other.bottom && other.top < one.bottom;
}

/** Height of the bands above a place that hold controls on the page and nothing in a file, but for a margin each. */
function blankAbove(boxes, place) {
  const sorted = boxes.toSorted((a, b) => a.top - b.top);
  let [bottom, blank] = [sorted[0].top, 0];
  for (const box of sorted) {
    if (box.top <= place) blank += Math.max(box.top - bottom - GAP, 0);
    bottom = Math.max(bottom, box.bottom);
  }
  return blank;
}

/** A sheet as a picture of twice its size. */
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

/** A sentence in lines of so many letters. */
export function wrapped(sentence, most) {
  return sentence.split(" ").reduce((lines, word) => {
    const longer = [lines.at(-1), word].filter(Boolean).join(" ");
    return longer.length <= most ? [...lines.slice(0, -1), longer] : [...lines, word];
  }, [""]);
}

/** The words of a caption at their places, those of its legend behind their colors. */
function captioned(caption, left, top) {
  return [...caption.querySelectorAll("span")].filter((span) => span.childElementCount === 0)
    .flatMap((span) => {
      const box = span.getBoundingClientRect();
      const { color, fontSize, fontWeight } = getComputedStyle(span);
      const [x, middle] = [box.left - left, box.top - top + box.height / 2];
      const isKey = span.classList.contains("key");
      const { width, marginRight, height, backgroundColor, borderTopColor, borderTopWidth } = getComputedStyle(span, "::before");
      const [length, gap] = isKey ? [width, marginRight].map(parseFloat) : [0, 0];
      // A box has a ground and no border.
      const [stroke, thick] = parseFloat(borderTopWidth) ? [borderTopColor, borderTopWidth] : [backgroundColor, height];
      const line = svg("path", { d: `M${x} ${middle}h${length}`, stroke, "stroke-width": parseFloat(thick) });
      const text = svg("text", {
        x: x + length + gap, y: middle + 4, "font-size": parseFloat(fontSize),
        "font-weight": fontWeight, fill: color,
      }, span.textContent);
      return isKey ? [line, text] : [text];
    });
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
