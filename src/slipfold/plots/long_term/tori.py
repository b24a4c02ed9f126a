"""Tori on a response diagram: lighter than the orbits they are born from."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.lines import Line2D

from slipfold.lines.of_branches import OTHER, STABLE
from slipfold.lines.of_tori import torus_stretches
from slipfold.plots.style import LINES, MARKERS
from slipfold.tori.torus_branch import TorusBranch

LIGHTER = 0.5
"""Share of white in the colour of tori."""

NAMES = {STABLE: "torus", OTHER: "unstable torus"}

BREAKS = ("broken", "failed", "homoclinic", "points", "resonance")
"""Kinds of ends that are marked as not followed further."""


def draw_tori(
    ax: Axes, tori: Sequence[TorusBranch], output: str, measure: str, colour: str
) -> None:
    """Draw tori in a lighter shade of a colour; unstable ones are dotted."""
    for each in tori:
        lines = torus_stretches(each, output, measure)
        for line in lines:
            ax.plot(line.parameter, line.value, color=_lighter(colour), **LINES[line.kind])
        if lines and each.stopped.kind in BREAKS:
            place = lines[-1].parameter[-1], lines[-1].value[-1]
            ax.plot(*place, linestyle="none", marker=MARKERS["FAILED"], color=colour, zorder=3)


def torus_handles(tori: Sequence[TorusBranch], colour: str) -> list[Line2D]:
    """Return what a legend says of tori."""
    stable = [bool(each.stable[1:].any()) for each in tori if len(each) > 1]
    unstable = [not each.stable[1:].all() for each in tori if len(each) > 1]
    kinds = [STABLE] * any(stable) + [OTHER] * any(unstable)
    return [
        Line2D([], [], color=_lighter(colour), label=NAMES[kind], **LINES[kind]) for kind in kinds
    ]


def _lighter(colour: str) -> str:
    red, green, blue = (LIGHTER + (1 - LIGHTER) * part for part in to_rgb(colour))
    return to_hex((red, green, blue))
