"""The legend of lines and markers below a figure."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from slipfold.plots.response import BREAKS, HasBranches, marks_of, torus_handles
from slipfold.plots.style import LINES, MARKERS

LINE_NAMES = {
    "stable": "stable",
    "period doubling": "unstable: period doubling",
    "fold or torus": "unstable: fold or torus",
}

MARKER_NAMES = {
    "PD": "PD, period doubling",
    "NS": "NS, Neimark–Sacker",
    "LP": "LP, fold",
    "BP": "BP, branch point",
    "LIMIT": "limit of the model",
    "FAILED": "not followed further",
}

GREY = "0.2"


def draw_legend(
    figure: Figure,
    diagrams: Sequence[HasBranches],
    measure: str = "max",
    more: Sequence[Artist] | None = None,
    spans: Sequence[tuple[float, float]] | None = None,
) -> None:
    """Explain lines and markers below the panels; the colors are named beside them.

    Given `more` it has that instead of the tori. Given `spans` of the parameter that the panels of
    each diagram show, markers outside of them are left out.
    """
    marks = [
        mark
        for place, diagram in enumerate(diagrams)
        for branch in diagram.branches
        for mark in marks_of(branch, branch.model.states[0].name, measure)
        if spans is None or min(spans[place]) <= mark.parameter <= max(spans[place])
    ]
    handles: list[Artist] = [
        Line2D([], [], color=GREY, label=name, **LINES[kind]) for kind, name in LINE_NAMES.items()
    ]
    tori = [each for diagram in diagrams for each in diagram.tori]
    broken = any(each.stopped.kind in BREAKS for each in tori)
    if more is None:
        handles += torus_handles(tori, GREY)
    handles += [
        _marker(type_, name)
        for type_, name in MARKER_NAMES.items()
        if any(mark.type == type_ for mark in marks) or (type_ == "FAILED" and broken)
    ]
    if any(mark.hollow for mark in marks):
        handles.append(_marker("PD", "open: subcritical", "white"))
    handles += more or []
    figure.legend(
        handles=handles, loc="outside lower center", ncols=4, columnspacing=1.4, handlelength=2.6
    )


def _marker(type_: str, name: str, face: str = GREY) -> Line2D:
    return Line2D(
        [],
        [],
        linestyle="none",
        marker=MARKERS[type_],
        color=GREY,
        markerfacecolor=face,
        markeredgewidth=0.9,
        label=name,
    )
