"""Response diagrams: what orbits reach, with their stability and bifurcations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np
from matplotlib.axes import Axes

from slipfold.branches.branch import Branch
from slipfold.branches.special_point import SpecialPoint
from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.plots.axes import axes_or_new, label_of
from slipfold.plots.labels import Label, place_labels
from slipfold.plots.stretches import measure_of, stretches_of
from slipfold.plots.style import LINES, MARKERS, palette

if TYPE_CHECKING:
    from slipfold.plots.labels import Array

__all__ = ["HasBranches", "draw_family", "draw_response"]

MEASURE_NAMES = {"max": "max", "min": "min", "peak_to_peak": "p–p", "modulus": "max |·| of"}


class HasBranches(Protocol):
    """What is drawn: a `slipfold.Diagram`, or anything else with branches."""

    @property
    def branches(self) -> Sequence[Branch]:
        """The branches."""
        ...


def draw_response(
    diagram: HasBranches,
    output: str = "x",
    measure: str = "max",
    ax: Axes | None = None,
    colour: str = "black",
    annotate: bool = True,
) -> Axes:
    """Draw one response diagram.

    Stable orbits are solid; unstable by period doubling dashed; unstable by a fold or a torus
    dotted. A subcritical PD or NS has an open marker.

    Parameters
    ----------
    diagram
        Branches to draw.
    output
        A state or output of the model.
    measure
        ``"max"``, ``"min"``, ``"peak_to_peak"``, or ``"modulus"`` for the largest absolute value,
        each over the continuous orbit.
    ax
        Axes to draw in; new ones if None.
    colour
        Colour of lines and markers.
    annotate
        Whether special points are named.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    InputError
        For an unknown output or measure, or if there is no branch.
    """
    return draw_family([diagram], None, output, measure, ax, [colour], annotate)


def draw_family(
    diagrams: Sequence[HasBranches],
    names: Sequence[str] | None = None,
    output: str = "x",
    measure: str = "max",
    ax: Axes | None = None,
    colours: Sequence[str] | None = None,
    annotate: bool = True,
) -> Axes:
    """Draw several response diagrams into one picture, each with its name beside its line.

    Parameters
    ----------
    diagrams
        The diagrams; all vary the same parameter.
    names
        What to write beside each line; nothing if None.
    output
        A state or output of the model.
    measure
        As in `draw_response`.
    ax
        Axes to draw in; new ones if None.
    colours
        One a diagram; from dark to light if None.
    annotate
        Whether special points are named.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    InputError
        For an unknown output or measure, or if there is no branch.
    """
    branches = [branch for diagram in diagrams for branch in diagram.branches]
    if not branches:
        raise InputError("the diagram has 0 branches, so there is nothing to draw; give at least 1")
    ax = axes_or_new(ax)
    colours = palette(len(diagrams)) if colours is None else colours
    labels: list[Label] = []
    for diagram, colour in zip(diagrams, colours, strict=True):
        _draw_lines(ax, diagram, output, measure, colour)
        labels += _draw_markers(ax, diagram, output, measure, colour)
    _label_axes(ax, branches[0].model, branches[0].vary, output, measure)
    ax.autoscale_view()
    if annotate:
        place_labels(ax, labels)
    if names is not None:
        place_labels(ax, _names(diagrams, names, output, measure, colours))
    return ax


def _draw_lines(ax: Axes, diagram: HasBranches, output: str, measure: str, colour: str) -> None:
    births = {
        point.leads_to: point
        for branch in diagram.branches
        for point in branch.special
        if point.leads_to is not None
    }
    for branch in diagram.branches:
        for stretch in stretches_of(branch, output, measure, births.get(branch.id)):
            ax.plot(stretch.parameter, stretch.value, color=colour, **LINES[stretch.kind])


def _draw_markers(
    ax: Axes, diagram: HasBranches, output: str, measure: str, colour: str
) -> list[Label]:
    labels = []
    for branch in diagram.branches:
        for point in branch.special:
            if point.type not in MARKERS:
                continue
            value = float(measure_of(point.orbit.extrema, output, measure)[0])
            if not np.isfinite(value):
                continue
            hollow = point.criticality == "subcritical"
            ax.plot(
                point.value,
                value,
                linestyle="none",
                marker=MARKERS[point.type],
                color=colour,
                markerfacecolor="white" if hollow else colour,
                markeredgewidth=0.9,
                zorder=3,
                clip_on=False,
            )
            labels.append(Label(_short_name(point), np.array([[point.value, value]]), colour))
    return labels


def _short_name(point: SpecialPoint) -> str:
    """Return what stands beside the marker."""
    if point.type == "LIMIT":
        return "collapse" if "collapse" in point.name else point.name
    return point.name if point.type == "EVENT" else point.type


def _names(
    diagrams: Sequence[HasBranches],
    names: Sequence[str],
    output: str,
    measure: str,
    colours: Sequence[str],
) -> list[Label]:
    return [
        Label(name, _anchors(diagram, output, measure), colour, size=7.5)
        for diagram, name, colour in zip(diagrams, names, colours, strict=True)
    ]


def _anchors(diagram: HasBranches, output: str, measure: str) -> Array:
    """Return points along the last branch, where lines of a family lie farthest apart."""
    line = np.concatenate(
        [
            np.column_stack([stretch.parameter, stretch.value])
            for stretch in stretches_of(diagram.branches[-1], output, measure)
        ]
    )
    return line[np.linspace(0, len(line) - 1, 24).astype(int)]


def _label_axes(ax: Axes, model: Model, vary: str, output: str, measure: str) -> None:
    ax.set_xlabel(model.parameter(vary).label)
    ax.set_ylabel(f"{MEASURE_NAMES[measure]} {label_of(model, output)}")
