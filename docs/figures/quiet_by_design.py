"""Thresholds and vibration of the oscillator over alpha and Vd, and where two NS points meet.

python docs/figures/quiet_by_design.py writes quiet_by_design.png and the table beside it.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import slipfold as sf
from slipfold.bifurcations.loci.locus import lines_between
from slipfold.parameter_space.optimum import ParameterizedOrbit, ParameterizedPoint
from slipfold.plots.labels import Label, place_labels
from slipfold.plots.style import COLUMN, figure_style, settle

FOLDER = Path(__file__).parent

LOAD = 0.02
"""Pulsation at which the vibration is measured, in N."""

CHOOSE = {"alpha": ("45deg", "85deg"), "Vd": (0.3, 1.0)}
ANGLES = np.radians(np.linspace(45, 85, 17))
SPEEDS = np.linspace(0.3, 1.0, 15)
WANTED = {
    "x": [0.0253, 0.026, 0.027, 0.028, 0.029, 0.03, 0.0305, 0.031, 0.06, 0.128],
    "y": [0.03, 0.06, 0.09, 0.12, 0.128],
}
"""Thresholds that are to be exceeded, in N, by the state that is to vibrate least."""

WINDOW = {"alpha": ("57.5deg", "65deg"), "Nd": (0.02, 0.3)}


def main() -> None:
    """Compute all of it and draw it."""
    model = sf.SlidingOscillator(f=12.5)
    special = sf.response(model, vary="Nd", span=(0, 0.98)).special
    doubling, torus = special[0].point, special[2].point
    designs = {
        state: sf.design(doubling, CHOOSE, above=wanted, load=LOAD, state=state)
        for state, wanted in WANTED.items()
    }
    (FOLDER / "quiet_by_design.md").write_text(table(designs["x"]))
    locus = sf.locus(torus, ("alpha", "Nd"), WINDOW, switch=False)
    with figure_style():
        figure = Figure(figsize=(3 * COLUMN, 1.05 * COLUMN), layout="constrained")
        left, middle, right = figure.subplots(1, 3)
        labels = [
            draw_designs(ax, model, doubling, designs[state])
            for ax, state in ((left, "y"), (middle, "x"))
        ]
        draw_locus(right, locus)
        # Where a name covers nothing is known when the layout is.
        for ax, names in zip((left, middle), labels, strict=True):
            settle(ax)
            place_labels(ax, names)
        figure.savefig(FOLDER / "quiet_by_design.png", dpi=200)


def draw_designs(ax, model, doubling, found):
    """Draw what alpha and Vd can do, and the designs that vibrate least; return what to name."""
    labels = []
    state = [item.name for item in model.states].index(found.state)
    placed = ParameterizedPoint.at(doubling, ("alpha", "Vd"))
    orbit = ParameterizedOrbit.at(model.replace(Nd=LOAD), ("alpha", "Vd"))
    reached = np.empty((len(ANGLES), len(SPEEDS), 2))
    for row, alpha in enumerate(ANGLES):
        for column, speed in enumerate(SPEEDS):
            there = {"alpha": float(alpha), "Vd": float(speed)}
            placed, orbit = placed.moved_to(there), orbit.moved_to(there)
            reached[row, column] = placed.value, orbit.level(state)[0]
    for row, alpha in enumerate(ANGLES):
        if row % 2:
            continue
        color = "0.35" if row in (0, len(ANGLES) - 1) else "0.75"
        ax.plot(*reached[row].T, color=color, linewidth=0.8, zorder=1)
        if row % 8 == 0:
            labels.append(Label(f"{np.degrees(alpha):.0f}°", reached[row, -1:]))
    for column in (0, 4, 14):
        ax.plot(*reached[:, column].T, color="0.75", linewidth=0.8, linestyle="--", zorder=1)
        labels.append(Label(f"{SPEEDS[column]:g} m/s", reached[0, column][None]))
    found.plot(ax=ax)
    ax.lines[-2].set_linestyle("none")
    ax.legend(frameon=False)
    ax.set_xscale("log")
    ax.set_xlim(0.019, 0.22)
    ax.set_xticks([0.03, 0.05, 0.1, 0.2], ["0.03", "0.05", "0.1", "0.2"])
    ax.minorticks_off()
    return labels


def draw_locus(ax, found):
    """Draw the NS points of the period-2 branch over the direction of the plate."""
    (locus,) = found.loci
    alpha, value = np.concatenate(lines_between(locus)).T
    ax.plot(np.degrees(alpha), value, color="black")
    (meeting,) = (point for _, point in found.special if point.type == "MIN")
    alpha, value = np.degrees(meeting.values[0]), meeting.values[1]
    ax.plot(alpha, value, marker="o", color="tab:orange")
    ax.annotate(f"{alpha:.4f}°", (alpha, value), (6, -3), textcoords="offset points")
    ax.set_xlim(58, 65)
    ax.set_xlabel(r"$\alpha$ (deg)")
    ax.set_ylabel("NS of period 2 at $N_d$ (N)")


def table(found):
    """Return the designs as a table."""
    rows = [
        "| PD above (N) | alpha (deg) | Vd (m/s) | PD at (N) | rms of x/L |",
        "|---|---|---|---|---|",
    ]
    for wanted, (alpha, speed), thresholds, level in zip(
        found.wanted, found.values, found.thresholds, found.levels, strict=True
    ):
        cells = f"{wanted:g}", f"{np.degrees(alpha):.2f}", f"{speed:.3f}", f"{thresholds[0]:.4f}"
        rows.append(f"| {' | '.join(cells)} | {level:.5f} |")
    return "\n".join(rows) + "\n"


if __name__ == "__main__":
    main()
