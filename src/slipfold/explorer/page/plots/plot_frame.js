/** What the large plots have in common: fonts, axes, margins, and where data are on the screen. */

const MARGIN = { l: 74, r: 18, t: 14, b: 46 };

export const CONFIG = {
  displayModeBar: false,
  doubleClick: false,
  responsive: false,
  scrollZoom: false,
  showTips: false,
};

/**
 * A layout in the page's style.
 * @param {(name: string) => string} colour from `colours()`
 * @param {{title: string, range: [number, number]}} x
 * @param {{title: string, range: [number, number]}} y
 * @param {[number, number]} size in pixels
 */
export function layout(colour, x, y, [width, height]) {
  return {
    width,
    height,
    margin: { ...MARGIN },
    paper_bgcolor: "rgba(0,0,0,0)",
    plot_bgcolor: "rgba(0,0,0,0)",
    font: { family: "system-ui, sans-serif", size: 13, color: colour("ink") },
    showlegend: false,
    hovermode: false,
    dragmode: "zoom",
    xaxis: axis(colour, x),
    yaxis: axis(colour, y),
  };
}

function axis(colour, { title, range }) {
  return {
    title: { text: title, standoff: 8 },
    range: [...range],
    autorange: false,
    zeroline: false,
    showgrid: true,
    gridcolor: colour("grid"),
    linecolor: colour("axis"),
    linewidth: 1,
    mirror: true,
    ticks: "inside",
    ticklen: 5,
    tickcolor: colour("axis"),
    nticks: 7,
    automargin: false,
    exponentformat: "power",
    minexponent: 4,
    // On one of them: on all of them it would run into the title.
    showexponent: "last",
  };
}

/** The part of the page on which data lie, as `{left, top, width, height}` within the plot. */
export function frame([width, height]) {
  return {
    left: MARGIN.l,
    top: MARGIN.t,
    width: width - MARGIN.l - MARGIN.r,
    height: height - MARGIN.t - MARGIN.b,
  };
}

/**
 * How data and pixels belong together.
 * @param {[number, number]} size of the plot in pixels
 * @param {[number, number]} x range
 * @param {[number, number]} y range
 */
export function mapping(size, x, y) {
  const { left, top, width, height } = frame(size);
  return {
    toPixel: (a, b) => [
      left + ((a - x[0]) / (x[1] - x[0])) * width,
      top + (1 - (b - y[0]) / (y[1] - y[0])) * height,
    ],
    toData: (px, py) => [
      x[0] + ((px - left) / width) * (x[1] - x[0]),
      y[0] + (1 - (py - top) / height) * (y[1] - y[0]),
    ],
    isInside: (px, py) => px >= left && px <= left + width && py >= top && py <= top + height,
  };
}
