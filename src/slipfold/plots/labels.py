"""Short texts next to points of a figure, placed where they cover nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.text import Annotation

from slipfold.arrays import Array

RADII = (4.0, 6.0, 9.0, 13.0, 18.0, 24.0, 32.0, 42.0)
"""Distances in points from the point to the edge of its text; without a leader the first four."""

DIRECTIONS = (90, 45, 135, 0, 180, -45, -135, -90, 67, 113, 22, 158, -22, -158, -67, -113)
"""Directions in degrees that are tried, the ones readers like first."""

LEADER = 8.0
"""A text farther away than this gets a thin line to its point."""

NEIGHBORHOOD = 6.0
"""Lines of another color this near, in points, make a text ambiguous."""

NOTHING = ("None", "none", "", " ", None)
"""Markers and line styles that draw nothing."""


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
    centered: bool = False  # whether the text lies on its point instead of next to it


def place_labels(axes: Axes, labels: Sequence[Label]) -> list[Annotation]:
    """Put each text next to its point, clear of lines, markers and other texts.

    The limits and the layout of the figure must be final. The first labels choose first.
    """
    canvas = _Canvas(axes)
    return [canvas.place(label) for label in labels]


class _Canvas:
    """How much ink lies on each square point of the axes, and of which color its lines are."""

    def __init__(self, axes: Axes) -> None:
        figure = axes.get_figure(root=True)
        assert figure is not None
        self.axes, self.scale = axes, 72.0 / figure.dpi
        box = axes.get_window_extent()
        self.origin = np.array([box.x0, box.y0])
        self.size = np.array([box.width, box.height]) * self.scale
        shape = int(self.size[1]) + 2, int(self.size[0]) + 2
        self.ink, self.color = np.zeros(shape), np.zeros(shape, int)
        self.numbers: dict[str, int] = {}
        for line in axes.get_lines():
            points = self.places(np.asarray(line.get_xydata(), dtype=float))
            if line.get_linestyle() not in NOTHING:
                self.add_line(points, to_hex(line.get_color()))
            if line.get_marker() not in NOTHING:
                for point in points:
                    self.add_box(point - 3.0, point + 3.0, 4.0)
        for inset in axes.child_axes:
            extent = inset.get_tightbbox()
            if extent is not None:
                low, high = (extent.get_points() - self.origin) * self.scale
                self.add_box(low, high, 4.0)
        self._add_ticks()

    def _add_ticks(self) -> None:
        """Draw the ticks along the frame; a text covers those that point inwards."""
        corner = self.axes.get_xlim()[0], self.axes.get_ylim()[0]
        for side, axis in enumerate((self.axes.xaxis, self.axes.yaxis)):
            for minor in (False, True):
                values = axis.get_ticklocs(minor=minor)
                points = np.full((len(values), 2), corner)
                points[:, side] = values
                ticks = axis.get_minor_ticks() if minor else axis.get_major_ticks()
                for place, tick in zip(self.places(points), ticks, strict=False):
                    length = tick.tick1line.get_markersize()
                    for low in (0.0, self.size[1 - side] - length):
                        ends = np.array([place, place])
                        ends[:, 1 - side] = low, low + length
                        self.add_box(ends[0], ends[1], 4.0)

    def places(self, points: Array) -> Array:
        """Return where data lie in the axes, in points, shape (n, 2)."""
        return (self.axes.transData.transform(points) - self.origin) * self.scale

    def add_line(self, points: Array, color: str = "") -> None:
        """Draw a line, which counts as another's for labels of another color."""
        number = self.numbers.setdefault(color, len(self.numbers) + 1) if color else 0
        points = points[np.isfinite(points).all(axis=1)]
        for start, end in pairwise(points):
            count = int(min(np.abs(end - start).max(), 4000.0) / 0.7) + 2
            place = start + (end - start) * np.linspace(0, 1, count)[:, None]
            inside = ((place >= 0) & (place < self.size)).all(axis=1)
            column, row = place[inside].astype(int).T
            self.ink[row, column] = np.maximum(self.ink[row, column], 1.0)
            self.color[row, column] = number or self.color[row, column]

    def add_box(self, low: Array, high: Array, weight: float) -> None:
        """Fill a box."""
        left, bottom = np.maximum(low, 0).astype(int)
        right, top = np.maximum(high, -1).astype(int)
        self.ink[bottom : top + 1, left : right + 1] += weight

    def place(self, label: Label) -> Annotation:
        """Draw a text at the best of its places."""
        text = self.axes.annotate(
            label.text, tuple(label.anchors[0]), xytext=(0, 0), textcoords="offset points",
            ha="center", va="center", color=label.color, fontsize=label.size, annotation_clip=False,
        )  # fmt: skip
        text.set_in_layout(False)
        extent = text.get_window_extent()
        half = np.array([extent.width, extent.height]) * self.scale / 2
        offsets, radii, habit = _candidates(half, label)
        places = self.places(label.anchors)
        cost = self._cost(label, places, offsets, half) + 0.4 * radii + habit
        if label.leader:
            cost += np.where(radii > LEADER, self._crossed(places, offsets, half), 0.0)
        anchor, choice = divmod(int(np.argmin(cost)), len(offsets))
        text.xy = tuple(label.anchors[anchor])
        text.set_position(tuple(offsets[choice]))
        center = places[anchor] + offsets[choice]
        self.add_box(center - half, center + half, 5.0)
        if label.leader and radii[choice] > LEADER:
            self._lead(label, text.xy, places[anchor], offsets[choice], half)
        return text

    def _cost(self, label: Label, places: Array, offsets: Array, half: Array) -> Array:
        """Return ink under texts, foreign lines around, and what sticks out.

        Shapes: places (m, 2), offsets (k, 2); returns (m, k).
        """
        own = self.numbers.get(to_hex(label.color), -1)
        foreign = ((self.color > 0) & (self.color != own)).astype(float)
        centers = (places[:, None] + offsets).reshape(-1, 2)
        low, high = centers - half - 1.0, centers + half + 1.0
        beyond = np.maximum(1.0 - low, 0) + np.maximum(high + 1.0 - self.size, 0)
        cost = 1000.0 * beyond.sum(axis=1) + _ink_under(self.ink, low, high)
        cost += 0.1 * _ink_under(foreign, low - NEIGHBORHOOD, high + NEIGHBORHOOD)
        near = 0.7 * _ink_under(foreign, places - NEIGHBORHOOD, places + NEIGHBORHOOD)
        return cost.reshape(len(places), -1) + near[:, None]

    def _crossed(self, places: Array, offsets: Array, half: Array) -> Array:
        """Return the ink that lines from points to their texts would cross, shape (m, k)."""
        tails = offsets * _outside(offsets, half)[:, None]
        # The point's own marker and line lie at its beginning.
        along = places[:, None, None] + tails[:, None] * np.linspace(0.3, 1.0, 12)[:, None]
        limit = np.array(self.ink.shape)[::-1] - 1
        column, row = np.moveaxis(np.clip(along, 0, limit).astype(int), -1, 0)
        return np.asarray(self.ink[row, column].sum(axis=-1))

    def _lead(
        self, label: Label, point: tuple[float, float], place: Array, offset: Array, half: Array
    ) -> None:
        """Join a text to its point by a thin line from the edge of the text."""
        tail = offset * _outside(offset[None], half)[0]
        style = {"arrowstyle": "-", "color": label.color, "linewidth": 0.4}
        line = self.axes.annotate(
            "", point, xytext=tuple(tail), textcoords="offset points", annotation_clip=False,
            arrowprops={**style, "shrinkA": 0.0, "shrinkB": 2.0},
        )  # fmt: skip
        line.set_in_layout(False)
        self.add_line(np.array([place, place + tail]))


def _outside(offsets: Array, half: Array) -> Array:
    """Return which fraction of the way to the center of a text lies outside of it, shape (k,)."""
    inside = np.min(half / np.maximum(np.abs(offsets), 1e-9), axis=1)
    return np.maximum(1.0 - inside, 0.0)


def _ink_under(ink: Array, low: Array, high: Array) -> Array:
    """Sum over boxes at once, through the table of sums from the corner."""
    sums = np.zeros((ink.shape[0] + 1, ink.shape[1] + 1))
    sums[1:, 1:] = ink.cumsum(axis=0).cumsum(axis=1)
    limit = np.array(ink.shape)[::-1]
    left, bottom = np.clip(np.floor(low), 0, limit).astype(int).T
    right, top = np.clip(np.floor(high) + 1, 0, limit).astype(int).T
    return np.asarray(sums[top, right] - sums[bottom, right] - sums[top, left] + sums[bottom, left])


def _candidates(half: Array, label: Label) -> tuple[Array, Array, Array]:
    """Return offsets of the center of a text, their distances, and how little they are liked."""
    if label.centered:
        return np.zeros((1, 2)), np.zeros(1), np.zeros(1)
    radii = np.array(RADII if label.leader else RADII[:4])
    angles = np.deg2rad(DIRECTIONS)
    units = np.column_stack([np.cos(angles), np.sin(angles)])
    # The center lies in this direction where the edge of the text has the distance.
    edges = np.min(half / np.maximum(np.abs(units), 1e-9), axis=1)
    offsets = units[:, None] * (radii + edges[:, None])[..., None]
    habit = np.repeat(0.1 * np.arange(len(angles)), len(radii))
    return offsets.reshape(-1, 2), np.tile(radii, len(angles)), habit
