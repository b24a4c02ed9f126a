"""Short texts next to points of a figure, placed where they cover nothing."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.text import Annotation

from slipfold.arrays import Array

RADII = (4.0, 6.0, 9.0, 13.0, 18.0, 24.0, 32.0, 42.0)
"""Distances in points from the point to the edge of its text."""

DIRECTIONS = (90, 45, 135, 0, 180, -45, -135, -90, 67, 113, 22, 158, -22, -158, -67, -113)
"""Directions in degrees that are tried, the ones readers like first."""

LEADER = 8.0
"""A text farther away than this gets a thin line to its point."""

NEIGHBORHOOD = 6.0
"""Lines of another color this near, in points, make a text ambiguous."""


@dataclass(frozen=True, eq=False)
class Label:
    """A text that belongs to one of several points."""

    text: str
    # Points in data coordinates, shape (n, 2); the text goes to the one with the best place
    anchors: Array
    color: str = "black"  # color of the text
    size: float = 6.5  # font size in points
    # Whether a thin line may join a far text to its point; without one the text stays near
    leader: bool = True
    centerd: bool = False  # whether the text lies on its point instead of next to it


def place_labels(axes: Axes, labels: Sequence[Label]) -> list[Annotation]:
    """Put each text next to its point, clear of lines, markers and other texts.

    The limits and the layout of the figure must be final. The first labels choose first.
    """
    canvas = _Canvas(axes, sorted({to_hex(label.color) for label in labels}))
    return [_place(axes, canvas, label) for label in labels]


class _Canvas:
    """How much ink lies on each square point of the axes."""

    def __init__(self, axes: Axes, colors: Iterable[str]) -> None:
        figure = axes.get_figure(root=True)
        assert figure is not None
        self.scale = 72.0 / figure.dpi
        self.transform = axes.transData
        box = axes.get_window_extent()
        self.origin = np.array([box.x0, box.y0])
        self.size = np.array([box.width, box.height]) * self.scale
        shape = int(self.size[1]) + 2, int(self.size[0]) + 2
        self.ink = np.zeros(shape)
        self.foreign = {color: np.zeros(shape) for color in colors}
        for line in axes.get_lines():
            points = self.places(np.asarray(line.get_xydata(), dtype=float))
            color = to_hex(line.get_color())
            if line.get_linestyle() not in ("None", "none", "", " "):
                self.add_line(points, color)
            if line.get_marker() not in ("None", "none", "", " ", None):
                for point in points:
                    self.add_box(point - 3.0, point + 3.0, 4.0)
        for inset in axes.child_axes:
            extent = inset.get_tightbbox()
            if extent is not None:
                low, high = (extent.get_points() - self.origin) * self.scale
                self.add_box(low, high, 4.0)

        self._add_ticks(axes)

    def _add_ticks(self, axes: Axes) -> None:
        """Draw the ticks along the frame; a text covers those that point inwards."""
        for side, axis in enumerate((axes.xaxis, axes.yaxis)):
            for minor in (False, True):
                places = np.zeros((len(axis.get_ticklocs(minor=minor)), 2))
                places[:, side] = axis.get_ticklocs(minor=minor)
                places[:, 1 - side] = (axes.get_ylim, axes.get_xlim)[side]()[0]
                ticks = axis.get_minor_ticks() if minor else axis.get_major_ticks()
                for place, tick in zip(self.places(places), ticks, strict=False):
                    length = tick.tick1line.get_markersize()
                    for low in (0.0, self.size[1 - side] - length):
                        place[1 - side] = low
                        tip = place.copy()
                        tip[1 - side] = low + length
                        self.add_box(place, tip, 4.0)

    def places(self, points: Array) -> Array:
        """Return where data lie in the axes, in points, shape (n, 2)."""
        return (self.transform.transform(points) - self.origin) * self.scale

    def add_line(self, points: Array, color: str = "") -> None:
        """Draw a line, which counts as another's for labels of another color."""
        points = points[np.isfinite(points).all(axis=1)]
        for start, end in pairwise(points):
            count = int(min(np.abs(end - start).max(), 4000.0) / 0.7) + 2
            place = start + (end - start) * np.linspace(0, 1, count)[:, None]
            inside = ((place >= 0) & (place < self.size)).all(axis=1)
            column, row = place[inside].astype(int).T
            self.ink[row, column] = np.maximum(self.ink[row, column], 1.0)
            for other, ink in self.foreign.items():
                if color and other != color:
                    ink[row, column] = 1.0

    def add_box(self, low: Array, high: Array, weight: float) -> None:
        """Fill a box."""
        left, bottom = np.maximum(low, 0).astype(int)
        right, top = np.maximum(high, -1).astype(int)
        self.ink[bottom : top + 1, left : right + 1] += weight

    def cost(self, low: Array, high: Array, color: str) -> Array:
        """Ink under boxes, foreign lines around them, and what sticks out; shape (n,)."""
        beyond = np.maximum(1.0 - low, 0) + np.maximum(high + 1.0 - self.size, 0)
        cost = 1000.0 * beyond.sum(axis=1) + _ink_under(self.ink, low, high)
        foreign = self.foreign[to_hex(color)]
        return cost + 0.1 * _ink_under(foreign, low - NEIGHBORHOOD, high + NEIGHBORHOOD)

    def foreign_near(self, places: Array, color: str) -> Array:
        """Ink of other colors around the points that texts belong to, shape (n,)."""
        ink = self.foreign[to_hex(color)]
        return 0.7 * _ink_under(ink, places - NEIGHBORHOOD, places + NEIGHBORHOOD)

    def crossed(self, places: Array, offsets: Array, half: Array) -> Array:
        """Ink that lines from points to their texts would cross, shape (n_places, n_offsets)."""
        inside = np.min(half / np.maximum(np.abs(offsets), 1e-9), axis=1)
        tails = offsets * np.maximum(1.0 - inside, 0.0)[:, None]
        # The point's own marker and line lie at its beginning.
        shares = np.linspace(0.3, 1.0, 12)
        along = places[:, None, None] + tails[:, None] * shares[:, None]
        limit = np.array(self.ink.shape)[::-1] - 1
        column, row = np.moveaxis(np.clip(along, 0, limit).astype(int), -1, 0)
        return np.asarray(self.ink[row, column].sum(axis=-1))


def _ink_under(ink: Array, low: Array, high: Array) -> Array:
    """Sum over boxes at once, through the table of sums from the corner."""
    sums = np.zeros((ink.shape[0] + 1, ink.shape[1] + 1))
    sums[1:, 1:] = ink.cumsum(axis=0).cumsum(axis=1)
    limit = np.array(ink.shape)[::-1]
    left, bottom = np.clip(np.floor(low), 0, limit).astype(int).T
    right, top = np.clip(np.floor(high) + 1, 0, limit).astype(int).T
    result = sums[top, right] - sums[bottom, right] - sums[top, left] + sums[bottom, left]
    return np.asarray(result)


def _place(axes: Axes, canvas: _Canvas, label: Label) -> Annotation:
    text = axes.annotate(
        label.text,
        tuple(label.anchors[0]),
        xytext=(0, 0),
        textcoords="offset points",
        ha="center",
        va="center",
        color=label.color,
        fontsize=label.size,
        annotation_clip=False,
    )
    text.set_in_layout(False)
    extent = text.get_window_extent()
    half = np.array([extent.width, extent.height]) * canvas.scale / 2
    offsets, radii, habit = _candidates(half, label)
    places = canvas.places(label.anchors)
    centers = (places[:, None] + offsets).reshape(-1, 2)
    cost = canvas.cost(centers - half - 1.0, centers + half + 1.0, label.color)
    near = canvas.foreign_near(places, label.color)
    liking = np.tile(0.4 * radii + habit, len(places)) + np.repeat(near, len(offsets))
    if label.leader:
        liking += np.where(radii > LEADER, canvas.crossed(places, offsets, half), 0.0).ravel()
    best = int(np.argmin(cost + liking))
    anchor, choice = divmod(best, len(offsets))
    text.xy = tuple(label.anchors[anchor])
    text.set_position(tuple(offsets[choice]))
    canvas.add_box(centers[best] - half, centers[best] + half, 5.0)
    if label.leader and radii[choice] > LEADER:
        _lead(axes, canvas, label, text, half)
    return text


def _candidates(half: Array, label: Label) -> tuple[Array, Array, Array]:
    """Return offsets of the center of a text, their distances, and how little they are liked."""
    if label.centerd:
        return np.zeros((1, 2)), np.zeros(1), np.zeros(1)
    offsets, radii, habit = [], [], []
    allowed = RADII if label.leader else RADII[:4]
    for (rank, angle), radius in product(enumerate(np.deg2rad(DIRECTIONS)), allowed):
        unit = np.array([np.cos(angle), np.sin(angle)])
        # The center lies in this direction where the edge of the text has the distance.
        edge = float(np.min(half / np.maximum(np.abs(unit), 1e-9)))
        offsets.append(unit * (radius + edge))
        radii.append(radius)
        habit.append(0.1 * rank)
    return np.array(offsets), np.array(radii), np.array(habit)


def _lead(axes: Axes, canvas: _Canvas, label: Label, text: Annotation, half: Array) -> None:
    """Join a text to its point by a thin line from the edge of the text."""
    offset = np.array(text.get_position())
    inside = float(np.min(half / np.maximum(np.abs(offset), 1e-9)))
    tail = offset * max(1.0 - inside, 0.0)
    line = axes.annotate(
        "",
        text.xy,
        xytext=tuple(tail),
        textcoords="offset points",
        arrowprops={
            "arrowstyle": "-",
            "color": label.color,
            "linewidth": 0.4,
            "shrinkA": 0.0,
            "shrinkB": 2.0,
        },
        annotation_clip=False,
    )
    line.set_in_layout(False)
    place = canvas.places(np.array([text.xy]))[0]
    canvas.add_line(np.array([place, place + tail]))
