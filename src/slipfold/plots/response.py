"""Response diagrams: what orbits reach, with their stability and bifurcations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from slipfold.branches.branch import Branch
from slipfold.errors import InputError
from slipfold.lines.of_branches import STUCK, stretches_of
from slipfold.measured.measurement import Measurement
from slipfold.plots.angles import label_output
from slipfold.plots.axes import axes_or_new, settle
from slipfold.plots.labels import Label, place_labels
from slipfold.plots.long_term.tori import draw_tori, torus_handles
from slipfold.plots.marks import marks_of
from slipfold.plots.readings import draw_readings
from slipfold.plots.style import LINES, MARKERS, palette
from slipfold.tori.torus_branch import TorusBranch

MEASURE_NAMES = {
    "max": "max",
    "min": "min",
    "peak_to_peak": "peak-to-peak",
    "modulus": "max modulus of",
}

ANCHORS = 40
"""Places along each branch where its name may stand."""


class HasBranches(Protocol):
    """What is drawn: a `slipfold.Diagram`, or anything else with branches."""

    @property
    def branches(self) -> Sequence[Branch]:
        """The branches."""
        ...

    @property
    def tori(self) -> Sequence[TorusBranch]:
        """The tori, if they were followed."""
        ...


def draw_response(
    diagram: HasBranches,
    output: str = "x",
    measure: str = "max",
    ax: Axes | None = None,
    colour: str = "black",
    annotate: bool = True,
    measured: Measurement | None = None,
) -> Axes:
    """Draw one response diagram, with what was `measured` if that is given.

    Stable orbits are solid, and so are neutral ones, which nothing damps; unstable by period
    doubling dashed; unstable by a fold or a torus dotted. A subcritical PD or NS has an open
    marker. Tori are drawn lighter.
    """
    ax = draw_family([diagram], output, measure, ax, [colour])
    handles = torus_handles(diagram.tori, colour) if measure != STUCK else []
    if handles:
        ax.legend(handles=handles)
    if measured is not None:
        curves: list[Any] = [*diagram.branches, *diagram.tori]
        vary = curves[0].vary
        if measured.vary != vary:
            raise InputError(
                f"{measured.vary} was varied in the measurement but the diagram is over {vary}; "
                f"follow the response over {measured.vary}"
            )
        draw_readings(ax, measured, measure, output)
        ax.legend()
    if annotate:
        name_family(ax, [diagram], None, output, measure, [colour])
    return ax


def draw_family(
    diagrams: Sequence[HasBranches],
    output: str = "x",
    measure: str = "max",
    ax: Axes | None = None,
    colours: Sequence[str] | None = None,
) -> Axes:
    """Draw several response diagrams into one picture; `name_family` then names what is in it."""
    branches: list[Any] = [item for each in diagrams for item in (*each.branches, *each.tori)]
    if not branches:
        raise InputError("the diagram has 0 branches, so there is nothing to draw; give at least 1")
    ax = axes_or_new(ax)
    if measure == STUCK:
        ax.set_ylabel("share of the period in which a contact sticks")
    else:
        label_output(ax, "y", branches[0].model, output, MEASURE_NAMES.get(measure, ""))
    colours = palette(len(diagrams)) if colours is None else colours
    for diagram, colour in zip(diagrams, colours, strict=True):
        for branch in diagram.branches:
            for line in stretches_of(branch, output, measure):
                ax.plot(line.parameter, line.value, color=colour, **LINES[line.kind])
        draw_tori(ax, diagram.tori, output, measure, colour)
    # Markers lie on top of all lines.
    for diagram, colour in zip(diagrams, colours, strict=True):
        for branch in diagram.branches:
            _draw_marks(ax, branch, output, measure, colour)
    ax.set_xlabel(branches[0].model.parameter(branches[0].vary).label)
    return ax


def name_family(
    ax: Axes,
    diagrams: Sequence[HasBranches],
    names: Sequence[str] | None = None,
    output: str = "x",
    measure: str = "max",
    colours: Sequence[str] | None = None,
    without: tuple[float, float] | None = None,
) -> None:
    """Name the special points of a picture, and its curves, where nothing is covered.

    What is drawn later may be covered by a name, or may move it.
    """
    settle(ax)
    colours = palette(len(diagrams)) if colours is None else colours
    labels = []
    for diagram, colour in zip(diagrams, colours, strict=True):
        for branch in diagram.branches:
            for mark in marks_of(branch, output, measure):
                place = np.array([[mark.parameter, mark.value]])
                hidden = without and without[0] <= mark.parameter <= without[1]
                if mark.name and not hidden and len(_within(ax, place)):
                    labels.append(Label(mark.name, place, colour))
    if names is not None:
        for diagram, name, colour in zip(diagrams, names, colours, strict=True):
            anchors = _within(ax, _anchors(diagram, output, measure))
            if len(anchors):
                labels.append(Label(name, anchors, colour, size=7.5))
    place_labels(ax, labels)


def _draw_marks(ax: Axes, branch: Branch, output: str, measure: str, colour: str) -> None:
    for mark in marks_of(branch, output, measure):
        ax.plot(
            mark.parameter,
            mark.value,
            linestyle="none",
            marker=MARKERS[mark.type],
            color=colour,
            markerfacecolor="white" if mark.hollow else colour,
            markeredgewidth=0.9,
            zorder=3,
        )


def _anchors(diagram: HasBranches, output: str, measure: str) -> NDArray[np.float64]:
    """Return points along all branches, shape (n, 2)."""
    chosen = []
    for branch in diagram.branches:
        lines = stretches_of(branch, output, measure)
        points = np.concatenate([np.column_stack([item.parameter, item.value]) for item in lines])
        chosen.append(points[np.linspace(0, len(points) - 1, ANCHORS).astype(int)])
    return np.concatenate(chosen)


def _within(ax: Axes, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return those of the points that the axes show."""
    low, high = np.sort(np.array([ax.get_xlim(), ax.get_ylim()]).T, axis=0)
    return points[((points >= low) & (points <= high)).all(axis=1)]
