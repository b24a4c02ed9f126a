"""Draw where the tip begins to stick: python docs/figures/stick_slip_study.py.

It reads what stick_slip_map.py computes.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from stick_slip_map import LAWS, PULSATIONS, SPEEDS, key, read

from slipfold.plots import figure_style

FOLDER = Path(__file__).parent

LINES = {"coulomb": ("Coulomb", "-"), "stribeck": ("Stribeck", "--")}
KINDS = ("always slips", "sticks once a period", "sticks more often", "does not settle")
FILLS = ("white", "#9ecae1", "#2c7fb8", "#d9b36c")


def main() -> None:
    """Draw the picture and write the table."""
    maps = {law: read(law) for law in LAWS}
    draw(maps)
    (FOLDER / "stick_slip_motions.md").write_text(table(maps["coulomb"], said) + "\n")
    (FOLDER / "stick_slip_smoothed.md").write_text(table(maps["coulomb"], smoothed) + "\n")


def kind_of(place: dict[str, Any]) -> int:
    """Return which of `KINDS` a motion is of."""
    if place["period"] is None:
        return 3
    each = place["stops"] / place["period"]
    return 0 if each == 0 else 1 if each <= 1 else 2


def draw(maps: dict[str, Any]) -> None:
    """Draw where the response begins to stick under both laws, and what motions do under one."""
    with figure_style():
        figure, ax = plt.subplots(figsize=(5.6, 3.6), layout="constrained")
        for law, (name, dashes) in LINES.items():
            values = np.transpose(maps[law]["locus"])
            ax.plot(*values, dashes, color="black", linewidth=1.3, label=f"GRAZE, {name}", zorder=1)
        seen = set()
        for v in SPEEDS:
            for n in PULSATIONS:
                place = maps["coulomb"][key(v, n)]
                kind, longer = kind_of(place), place["period"] not in (1, None)
                seen.add(kind)
                ax.plot(v, n, "s" if longer else "o", **filled(FILLS[kind]))
        handles = ax.get_legend_handles_labels()[0]
        handles += [
            Line2D([], [], linestyle="none", marker="o", label=KINDS[kind], **filled(FILLS[kind]))
            for kind in sorted(seen)
        ]
        square = Line2D(
            [], [], linestyle="none", marker="s", label="longer period", **filled("0.8")
        )
        ax.legend(handles=[*handles, square], loc="upper left", bbox_to_anchor=(1.0, 1.0))
        ax.set(xlabel="$V_d$ (m/s)", ylabel="$N_d$ (N)", xlim=(0, 0.13), ylim=(0, 1))
        figure.savefig(FOLDER / "stick_slip_map.png", dpi=150)
        plt.close(figure)


def filled(colour: str) -> dict[str, Any]:
    """Return the look of a motion's marker."""
    edge = {"markeredgecolor": "0.2", "markeredgewidth": 0.7}
    return {"markerfacecolor": colour, "markersize": 6, "zorder": 2, **edge}


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
    """Return by how much motions under regularised friction are off."""
    return ", ".join("-" if item is None else f"{item:.0e}" for item in place["off"])


if __name__ == "__main__":
    main()
