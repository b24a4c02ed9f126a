/** Where the names of marked points stand: beside the point, clear of lines and of each other. */

const POSITIONS = [
  "top center", "top right", "top left", "middle right", "middle left",
  "bottom right", "bottom left", "bottom center",
];
const HEIGHT = 14;
const WIDTH = 6.7;
const GAP = 8;

/**
 * Choose a place for each text; the first choose first.
 * @param {{text: string, at: [number, number]}[]} texts with their points in pixels
 * @param {[number, number][][]} lines in pixels
 * @param {{left: number, top: number, width: number, height: number}} frame to stay in, in pixels
 * @returns {string[]} plotly's `textposition`
 */
export function labelPlaces(texts, lines, frame) {
  const taken = texts.map(({ at }) => boxAround(at, 10, 10));
  const ink = points(lines);
  return texts.map(({ text, at }) => {
    const costs = POSITIONS.map((position, i) => {
      const box = boxAt(position, at, text.length * WIDTH);
      return 0.3 * i + outside(box, frame) + overlap(box, taken) + inkUnder(box, ink);
    });
    const position = POSITIONS[costs.indexOf(Math.min(...costs))];
    taken.push(boxAt(position, at, text.length * WIDTH));
    return position;
  });
}

function boxAt(position, [x, y], width) {
  const [vertical, horizontal] = position.split(" ");
  const down = { top: -GAP - HEIGHT / 2, middle: 0, bottom: GAP + HEIGHT / 2 }[vertical];
  const beside = vertical === "middle" ? GAP : 4;
  const right = { left: -beside - width / 2, center: 0, right: beside + width / 2 }[horizontal];
  return boxAround([x + right, y + down], width, HEIGHT);
}

function boxAround([x, y], width, height) {
  return [x - width / 2, y - height / 2, x + width / 2, y + height / 2];
}

function outside([left, top, right, bottom], frame) {
  const [ends, floor] = [frame.left + frame.width, frame.top + frame.height];
  const beyond = [frame.left - left, frame.top - top, right - ends, bottom - floor].map((value) => Math.max(value, 0));
  return 5 * beyond.reduce((sum, value) => sum + value, 0);
}

function overlap(box, others) {
  let area = 0;
  for (const other of others) {
    const width = Math.min(box[2], other[2]) - Math.max(box[0], other[0]);
    const height = Math.min(box[3], other[3]) - Math.max(box[1], other[1]);
    if (width > 0 && height > 0) area += width * height;
  }
  return 0.4 * area;
}

function inkUnder([left, top, right, bottom], ink) {
  return ink.filter(([x, y]) => x > left && x < right && y > top && y < bottom).length;
}

/** Lines as points a few pixels apart. */
function points(lines) {
  const found = [];
  for (const line of lines) {
    for (let i = 0; i + 1 < line.length; i++) {
      const [a, b] = [line[i], line[i + 1]];
      const count = Math.min(Math.ceil(Math.hypot(b[0] - a[0], b[1] - a[1]) / 4), 500);
      for (let k = 0; k < count; k++) {
        found.push([a[0] + ((b[0] - a[0]) * k) / count, a[1] + ((b[1] - a[1]) * k) / count]);
      }
    }
  }
  return found;
}
