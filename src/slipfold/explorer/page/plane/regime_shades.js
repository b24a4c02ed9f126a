/** Shades of what motions do, as in figures of regimes. */

const SHADES = {
  "period 1": "regime-1", "period 2": "regime-2", "period 4": "regime-4", "period 8": "regime-8",
  torus: "regime-torus", chaos: "regime-chaos", sticks: "regime-sticks", stopped: "regime-stopped",
  undecided: "panel",
};

/** The shade of a regime by its name: periods that have none of their own share one. */
function shadeOf(name) {
  return SHADES[name] ?? "regime-other";
}

/**
 * Names and shades of all that motions do, each shade once, the quiet ones first.
 * @param {{names: string[]}} picture the server's
 * @returns {{name: string, tint: string}[]}
 */
export function regimeKeys({ names }) {
  const order = [...Object.values(SHADES).slice(0, 4), "regime-other", ...Object.values(SHADES).slice(4)];
  const keys = new Map(names.map((name) => {
    const tint = shadeOf(name);
    return [tint, { name: tint === "regime-other" ? "other periods" : name, tint }];
  }));
  return [...keys.values()].sort((a, b) => order.indexOf(a.tint) - order.indexOf(b.tint));
}

/**
 * Traces of plotly: a shade for what the motion of each cell does; none where that is not known yet.
 * @param {object|null} picture the server's
 * @param {(name: string) => string} colour
 * @param {[number, number]} factors of the two axes
 */
export function regimeTraces(picture, colour, [fx, fy]) {
  if (!picture) return [];
  const { x, y, labels, names } = picture;
  const tints = ["rgba(0,0,0,0)", ...names.map((name) => colour(shadeOf(name)))];
  return [{
    type: "heatmap", x: x.values.map((v) => v * fx), y: y.values.map((v) => v * fy), z: labels,
    zmin: -0.5, zmax: tints.length - 0.5, showscale: false, hoverinfo: "skip", zsmooth: false,
    colorscale: tints.flatMap((tint, i) => [[i / tints.length, tint], [(i + 1) / tints.length, tint]]),
  }];
}
