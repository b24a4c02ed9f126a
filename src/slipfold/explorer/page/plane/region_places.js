/** Where the names of regions stand: in the widest part of each, if they fit at all. */

const WIDTH = 7;
const HEIGHT = 18;
const MARGIN = 8;

/**
 * A place for the name of each region.
 * @param {object} regions the server's: `labels` row by row from the bottom, `names`
 * @param {{width: number, height: number}} frame of the plot in pixels
 * @returns {{text: string, x: number, y: number}[]} in SI units; names that do not fit are left out
 */
export function regionPlaces(regions, frame) {
  const { labels, names, stable } = regions;
  const cell = [frame.width / labels[0].length, frame.height / labels.length];
  const rows = Math.ceil(HEIGHT / cell[1]);
  return Object.entries(names).flatMap(([id, name]) => {
    for (const text of [name, ...shorter(stable[id] ?? [])]) {
      const columns = Math.ceil((text.length * WIDTH + MARGIN) / cell[0]);
      const place = roomiest(labels, Number(id), columns, rows);
      if (place) return [{ text, x: middle(regions.x, place[0]), y: middle(regions.y, place[1]) }];
    }
    return [];
  });
}

/** Names of a region that take less room: its periods alone. */
function shorter(stable) {
  return stable.length > 1 ? [stable.join(" and "), stable.join("+")] : [];
}

/** The middle of a box within a region, around which there is most of the region. */
function roomiest(labels, id, columns, rows) {
  const sums = summed(labels, id);
  const within = (left, bottom, right, top) =>
    sums[top][right] - sums[bottom][right] - sums[top][left] + sums[bottom][left];
  const [height, width] = [labels.length, labels[0].length];
  let best = null;
  let most = 0;
  for (let bottom = 0; bottom + rows <= height; bottom++) {
    for (let left = 0; left + columns <= width; left++) {
      const [right, top] = [left + columns, bottom + rows];
      if (within(left, bottom, right, top) < columns * rows) continue;
      const around = within(
        Math.max(left - columns, 0), Math.max(bottom - 2 * rows, 0),
        Math.min(right + columns, width), Math.min(top + 2 * rows, height));
      if (around > most) [most, best] = [around, [left + columns / 2, bottom + rows / 2]];
    }
  }
  return best;
}

/** How many cells of a region lie below and left of each corner. */
function summed(labels, id) {
  const sums = [new Array(labels[0].length + 1).fill(0)];
  for (const row of labels) {
    const below = sums.at(-1);
    const line = [0];
    row.forEach((label, i) => line.push(line[i] + below[i + 1] - below[i] + Number(label === id)));
    sums.push(line);
  }
  return sums;
}

/** The coordinate at a place between cells. */
function middle(centres, place) {
  const step = (centres.at(-1) - centres[0]) / (centres.length - 1);
  return centres[0] + (place - 0.5) * step;
}
