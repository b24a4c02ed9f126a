"""Bifurcation sets: loci in a plane of two parameters, and what is stable between them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Protocol

import numpy as np
from matplotlib.axes import Axes

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.lines.of_loci import locus_stretches
from slipfold.loci.locus import Locus
from slipfold.loci.region_map import RegionMap
from slipfold.models.model import Model
from slipfold.plots.angles import label_axis
from slipfold.plots.axes import axes_or_new, settle
from slipfold.plots.labels import Label, place_labels
from slipfold.plots.locus_legend import legend_options
from slipfold.plots.locus_marks import locus_marks
from slipfold.plots.locus_style import LOCUS_COLOURS, line_style, locus_colour, mark_style
from slipfold.plots.regions import draw_regions, region_labels, sharpen

Window = tuple[tuple[float, float], tuple[float, float]]

ANCHORS = 60
"""Places along each locus where its name may stand."""

ORDER = ("LIFT", "STICK", "GRAZE", "LP", "BP", "HB", "NS", "PD")
"""From the lowest to the topmost line."""


class HasLoci(Protocol):
    """What is drawn: a `slipfold.LocusDiagram`, or anything else with loci."""

    @property
    def model(self) -> Model:
        """The model."""
        ...

    @property
    def vary(self) -> tuple[str, str]:
        """Names of the two parameters."""
        ...

    @property
    def window(self) -> Window:
        """Least and largest value of each."""
        ...

    @property
    def loci(self) -> Sequence[Locus]:
        """The loci."""
        ...

    @property
    def regions(self) -> RegionMap | None:
        """The regions between them, if they were computed."""
        ...


def draw_loci(
    diagram: HasLoci,
    ax: Axes | None = None,
    *,
    colours: Mapping[str, str] = LOCUS_COLOURS,
    window: Window | None = None,
    regions: bool = True,
    annotate: bool = True,
    lowest: Collection[str] = (),
    legend: bool = True,
) -> Axes:
    """Draw a bifurcation set in its plane.

    Supercritical stretches of PD, NS, BP and HB are solid, subcritical ones dashed; LP is
    dash-dotted, of equilibria solid, and a transcritical BP dotted. A locus of equilibria or of
    period 1 is thick, one of period 2 thin. Dots are points of codimension two, rings the extrema
    of a locus, crosses its ends at a limit of the model. Angles are shown in degrees; the data of
    the axes are radians.
    """
    shaded = regions and diagram.regions is not None
    if not diagram.loci and not shaded:
        raise InputError("the diagram has 0 loci, so there is nothing to draw; give at least 1")
    ax = axes_or_new(ax)
    view = diagram.window if window is None else window
    ax.set_xlim(view[0])
    ax.set_ylim(view[1])
    if shaded and diagram.regions is not None:
        labels = sharpen(diagram.regions, _lines(diagram), diagram.window, view)
        draw_regions(ax, diagram.regions, labels)
    for locus in sorted(diagram.loci, key=lambda item: ORDER.index(item.type)):
        for stretch in locus_stretches(locus):
            style = line_style(locus.type, locus.period, stretch.criticality, colours, locus.kind)
            ax.plot(*stretch.points.T, **style)
    for mark in locus_marks(diagram.loci, diagram.window):
        ax.plot(*mark.values, **mark_style(mark.type))
    ax.set_xlim(view[0])
    ax.set_ylim(view[1])
    label_axis(ax, "x", diagram.model.parameter(diagram.vary[0]))
    label_axis(ax, "y", diagram.model.parameter(diagram.vary[1]))
    if legend:
        _draw_legend(ax, diagram, colours, regions)
    if annotate:
        name_loci(ax, diagram, colours=colours, regions=regions, lowest=lowest)
    return ax


def name_loci(
    ax: Axes,
    diagram: HasLoci,
    *,
    colours: Mapping[str, str] = LOCUS_COLOURS,
    regions: bool = True,
    lowest: Collection[str] = (),
    without: Window | None = None,
) -> None:
    """Name the points of codimension two of a picture, its loci and its regions.

    What is drawn later may be covered by a name, or may move it.
    """
    settle(ax)
    labels = []
    for mark in locus_marks(diagram.loci, diagram.window, lowest):
        place = np.array([mark.values])
        hidden = without is not None and len(_within(place, without)) > 0
        if mark.name and not hidden and len(_within(place, _view(ax))):
            labels.append(Label(mark.name, place))
    for locus in diagram.loci:
        anchors = _within(_anchors(locus), _view(ax))
        if len(anchors):
            labels.append(
                Label(_name(locus), anchors, locus_colour(locus.type, colours), 7.5, leader=False)
            )
    if regions and diagram.regions is not None:
        labels += region_labels(ax, diagram.regions)
    place_labels(ax, labels)


def _draw_legend(ax: Axes, diagram: HasLoci, colours: Mapping[str, str], regions: bool) -> None:
    figure = ax.get_figure(root=True)
    assert figure is not None
    # Five lines below the axes: clear of the numbers and the name of the parameter.
    ax.legend(
        **legend_options([diagram], colours, regions, figure.get_figwidth()),
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        borderaxespad=5.0,
    )


def _lines(diagram: HasLoci) -> list[Array]:
    return [stretch.points for locus in diagram.loci for stretch in locus_stretches(locus)]


def _name(locus: Locus) -> str:
    if locus.type == "LP" and not locus.model.forced:
        return "LP of equilibria" if locus.kind == "equilibrium" else "LP of cycles"
    return locus.type if locus.period == 1 else f"{locus.type} {locus.period}"


def _anchors(locus: Locus) -> Array:
    """Return points along a locus, shape (n, 2)."""
    points = [stretch.points for stretch in locus_stretches(locus)]
    if not points:
        return np.zeros((0, 2))
    together = np.concatenate(points)
    return together[np.linspace(0, len(together) - 1, ANCHORS).astype(int)]


def _view(ax: Axes) -> Window:
    return ax.get_xlim(), ax.get_ylim()


def _within(points: Array, view: Window) -> Array:
    """Return those of the points that lie in a part of the plane."""
    low, high = np.sort(np.array(view).T, axis=0)
    return points[((points >= low) & (points <= high)).all(axis=1)]
