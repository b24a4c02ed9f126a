"""Draw where the tip begins to stick: python docs/figures/stick_slip_study.py.

It reads what stick_slip_map.py computes, and takes a minute for the map of regimes.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from stick_slip_map import LAWS, PULSATIONS, SPEEDS, computed_regimes, key, read

from slipfold.plots import figure_style

FOLDER = Path(__file__).parent

LINES = {"coulomb": ("Coulomb", "-"), "stribeck": ("Stribeck", "--")}


def main() -> None:
    """Draw the picture and write the table."""
    maps = {law: read(law) for law in LAWS}
    draw(maps)
    (FOLDER / "stick_slip_motions.md").write_text(table(maps["coulomb"], said) + "\n")
    (FOLDER / "stick_slip_smoothed.md").write_text(table(maps["coulomb"], smoothed) + "\n")


def draw(maps: dict[str, Any]) -> None:
    """Draw what motions do under Coulomb friction, and where the response begins to stick."""
    with figure_style():
        figure = Figure(figsize=(5.6, 3.6), layout="constrained")
        ax = computed_regimes().plot(ax=figure.add_subplot())
        handles = ax.get_legend().legend_handles
        for law, (name, dashes) in LINES.items():
            values = np.transpose(maps[law]["locus"])
            handles += ax.plot(
                *values, dashes, color="black", linewidth=1.3, label=f"GRAZE, {name}"
            )
        ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.0))
        figure.savefig(FOLDER / "stick_slip_map.png", dpi=150)


def table(places: dict[str, Any], says: Callable[[dict[str, Any]], str]) -> str:
    """Return what is said of each place, as Markdown."""
    heads = ["$N_d$", *(f"$V_d$ = {v:g} m/s" for v in SPEEDS)]
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for n in PULSATIONS[::-1]:
        cells = [says(places[key(v, n)]) for v in SPEEDS]
        lines.append(f"| {n:g} N | {' | '.join(cells)} |")
    return "\n".join(lines)


def said(place: dict[str, Any]) -> str:
    """Return what a motion does, in a few words."""
    period = "no period" if place["period"] is None else f"period {place['period']}"
    return f"{place['fraction']:.0%} stuck, {period}" if place["stops"] else f"slips, {period}"


def smoothed(place: dict[str, Any]) -> str:
    """Return by how much motions under regularized friction are off."""
    return ", ".join("-" if item is None else f"{item:.0e}" for item in place["off"])


if __name__ == "__main__":
    main()
