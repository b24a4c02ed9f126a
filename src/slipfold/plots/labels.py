"""Short texts beside points of a figure, placed where they cover nothing."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.text import Annotation
from numpy.typing import NDArray

__all__ = ["Label", "place_labels"]

Array = NDArray[np.float64]

RADII = (7.0, 10.0, 14.0, 19.0, 25.0, 32.0, 40.0, 50.0)
"""Distances from the point to the middle of the nearest edge of its text, in points."""

DIRECTIONS = np.deg2rad([90, 45, 135, 0, 180, -45, -135, -90, 67, 113, 22, 158, -22, -158, -67])
"""Directions that are tried, the ones readers like first."""

LEADER = 11.0
"""A text farther away than this gets a thin line to its point."""

SPACING = 1.5
"""Free margin around a text in points."""


@dataclass(frozen=True)
class Label:
    """A text that belongs to one of several points.

    Parameters
    ----------
    text
        The text.
    anchors
        Points in data coordinates, shape (n, 2); the text goes to the one with the best place.
    colour
        Colour of the text.
    size
        Font size in points.
    leader
        Whether a thin line may join a far text to its point.
    """

    text: str
    anchors: Array
    colour: str = "black"
    size: float = 6.5
    leader: bool = True


def place_labels(axes: Axes, labels: Sequence[Label]) -> list[Annotation]:
    """Put each text beside its point, clear of lines, markers and other texts.

    The limits of the axes must be final. The first labels choose first.

    Parameters
    ----------
    axes
        The axes; what is drawn in it is what must not be covered.
    labels
        The texts.

    Returns
    -------
    list of matplotlib.text.Annotation
        In the order of `labels`.
    """
    # Layout settles only when the figure is drawn; places in it mean nothing before.
    figure = axes.get_figure(root=True)
    assert figure is not None
    figure.draw_without_rendering()
    canvas = _Canvas(axes)
    return [_place(axes, canvas, label) for label in labels]


class _Canvas:
    """How much ink lies on each square point of the axes."""

    def __init__(self, axes: Axes) -> None:
        figure = axes.get_figure(root=True)
        assert figure is not None
        self.scale = 72.0 / figure.dpi
        self.transform = axes.transData
        box = axes.get_window_extent()
        self.origin = np.array([box.x0, box.y0])
        self.size = np.array([box.width, box.height]) * self.scale
        self.ink = np.zeros((int(self.size[1]) + 2, int(self.size[0]) + 2))
        for line in axes.get_lines():
            path = line.get_transform().transform_path(line.get_path())
            points = (np.asarray(path.vertices) - self.origin) * self.scale
            if line.get_linestyle() not in ("None", "none", "", " "):
                self.add_line(points)
            if line.get_marker() not in ("None", "none", "", " ", None):
                for point in points:
                    self.add_box(point - 3.0, point + 3.0, 3.0)

    def place(self, anchor: Array) -> Array:
        """Return a point's place in the axes, in points."""
        return (self.transform.transform(anchor) - self.origin) * self.scale

    def add_line(self, points: Array) -> None:
        points = points[np.isfinite(points).all(axis=1)]
        for start, end in itertools.pairwise(points):
            count = int(min(np.abs(end - start).max(), 4000.0) / 0.7) + 2
            place = start + (end - start) * np.linspace(0, 1, count)[:, None]
            inside = ((place >= 0) & (place < self.size)).all(axis=1)
            column, row = place[inside].astype(int).T
            self.ink[row, column] = np.maximum(self.ink[row, column], 1.0)

    def add_box(self, low: Array, high: Array, weight: float) -> None:
        self.ink[self._squares(low, high)] += weight

    def cost(self, low: Array, high: Array) -> float:
        """Ink under a box, and what sticks out of the axes."""
        outside = np.maximum(-low, 0).sum() + np.maximum(high - self.size, 0).sum()
        return float(self.ink[self._squares(low, high)].sum()) + 50.0 * float(outside)

    def _squares(self, low: Array, high: Array) -> tuple[slice, slice]:
        left, bottom = np.maximum(low, 0).astype(int)
        right, top = np.maximum(high, -1).astype(int)
        return slice(bottom, top + 1), slice(left, right + 1)


def _place(axes: Axes, canvas: _Canvas, label: Label) -> Annotation:
    text = axes.annotate(
        label.text,
        tuple(label.anchors[0]),
        xytext=(0, 0),
        textcoords="offset points",
        ha="center",
        va="center",
        color=label.colour,
        fontsize=label.size,
        annotation_clip=False,
    )
    text.set_in_layout(False)
    extent = text.get_window_extent()
    half = np.array([extent.width, extent.height]) * canvas.scale / 2 + SPACING / 2
    best = (np.inf, label.anchors[0], np.zeros(2), 0.0)
    for anchor in label.anchors:
        place = canvas.place(anchor)
        for number, angle in enumerate(DIRECTIONS):
            unit = np.array([np.cos(angle), np.sin(angle)])
            # From the point to the centre of a text whose edge is at the radius.
            reach = np.abs(unit * (half - SPACING)).sum()
            for radius in RADII:
                offset = unit * (radius - 3.0 + reach)
                centre = place + offset
                cost = canvas.cost(centre - half, centre + half)
                cost += 0.25 * (radius - RADII[0]) + 0.05 * number
                if cost < best[0]:
                    best = (cost, anchor, offset, radius)
    _, anchor, offset, radius = best
    text.xy = tuple(anchor)
    text.set_position(tuple(offset))
    place = canvas.place(anchor)
    canvas.add_box(place + offset - half, place + offset + half, 4.0)
    if label.leader and radius > LEADER:
        _lead(axes, canvas, label, anchor, offset, half)
    return text


def _lead(
    axes: Axes, canvas: _Canvas, label: Label, anchor: Array, offset: Array, half: Array
) -> None:
    """Join a text to its point by a thin line from the edge of the text."""
    shrink = float(np.min((half - SPACING / 2) / np.maximum(np.abs(offset), 1e-9)))
    tail = offset * max(1.0 - shrink, 0.0)
    line = axes.annotate(
        "",
        tuple(anchor),
        xytext=tuple(tail),
        textcoords="offset points",
        arrowprops={
            "arrowstyle": "-",
            "color": label.colour,
            "linewidth": 0.4,
            "shrinkA": 0.0,
            "shrinkB": 2.5,
        },
        annotation_clip=False,
    )
    line.set_in_layout(False)
    place = canvas.place(anchor)
    canvas.add_line(np.array([place, place + tail]))
