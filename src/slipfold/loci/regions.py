"""The regions between loci: found on a raster, labelled by the responses that cross them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.settings import Settings
from slipfold.loci.fan import FanLine
from slipfold.loci.locus import Locus
from slipfold.loci.locus_curve import locus_curve
from slipfold.loci.locus_problem import critical_places
from slipfold.loci.progress import LocusObserver, LocusProgress
from slipfold.loci.region_check import check_region
from slipfold.loci.region_map import Region, RegionMap
from slipfold.loci.stable_spans import stable_spans
from slipfold.loci.window import Window
from slipfold.models.model import Model

__all__ = ["map_regions"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Labels = NDArray[np.int64]

CELLS = 480
"""Cells of the raster in either direction: half a line's width in a figure."""

SMALLEST = 2e-4
"""Share of the window below which a piece is not a region of its own but belongs to what lies
beside it."""

CHECKED = 2e-3
"""Share of the window from which on a region is checked by simulation."""

CLEAR = 2.5
"""Distance from a boundary, in cells, at which a response says what region it is in."""

LIMIT_JUMP = 0.25
"""Ends at a limit on neighbouring lines are joined if they differ by less than this share of the
window."""


@dataclass(frozen=True)
class _Raster:
    """Cells of a window."""

    window: Window

    def columns(self, values: Array, axis: int) -> NDArray[np.int64]:
        """Return the cells that values of a parameter lie in."""
        low, high = self.window[axis]
        cells = ((np.asarray(values) - low) / (high - low) * CELLS).astype(int)
        return np.clip(cells, 0, CELLS - 1)

    def centres(self, axis: int) -> Array:
        """Return the values of a parameter at the centres of the cells."""
        low, high = self.window[axis]
        return np.linspace(low, high, 2 * CELLS + 1)[1::2]

    def draw(self, mask: Mask, values: Array) -> None:
        """Mark the cells that a polyline passes."""
        for a, b in pairwise(values):
            length = [
                abs(b[i] - a[i]) / (high - low) * CELLS for i, (low, high) in enumerate(self.window)
            ]
            count = int(2 * max(length)) + 2
            between = a + np.linspace(0, 1, count)[:, None] * (b - a)
            mask[self.columns(between[:, 1], 1), self.columns(between[:, 0], 0)] = True


def map_regions(
    model: Model,
    plane: tuple[str, str],
    window: Window,
    loci: Sequence[Locus],
    lines: Sequence[FanLine],
    settings: Settings,
    observer: LocusObserver | None = None,
) -> RegionMap:
    """Label the regions between loci by the stable responses of period 1 and 2 in them.

    A boundary is a stretch of a locus on which no other multiplier is outside the unit circle, or
    a place where a stable branch ends at a limit of the model. Inside a region nothing changes, so
    every response that crosses it says the same: where two disagree, the region is marked.

    Parameters
    ----------
    model
        The model.
    plane
        Names of the parameters.
    window
        Least and largest value of each.
    loci
        All loci in the window.
    lines
        Responses across the window.
    settings
        Options of continuation, for the checks.
    observer
        Called after each region's check.
    """
    from scipy import ndimage  # a tenth of a second to import

    raster = _Raster(window)
    boundary = np.zeros((CELLS, CELLS), dtype=bool)
    for values in _boundaries(loci, lines, plane, window):
        raster.draw(boundary, values)
    pieces: Labels = ndimage.label(~boundary)[0].astype(np.int64)
    pieces = _without_slivers(pieces, boundary)
    distance: Array = ndimage.distance_transform_edt(np.pad(pieces > 0, 1))[1:-1, 1:-1]
    clear = ndimage.distance_transform_edt(~boundary) > CLEAR
    votes = _votes(pieces, clear, raster, plane, lines)
    regions, labels = _labelled(pieces, votes, distance, raster)
    nearest = ndimage.distance_transform_edt(
        labels == 0, return_distances=False, return_indices=True
    )
    if regions:
        labels = labels[tuple(nearest)]
    checked: list[Region] = []
    for region in regions:
        if region.share >= CHECKED:
            if observer is not None:
                done = len(checked)
                observer(LocusProgress("regions", done, len(regions), region.place, region.name))
            checks = check_region(model, plane, window, region, settings)
            region = replace(region, checks=checks)
        checked.append(region)
    return RegionMap(raster.centres(0), raster.centres(1), labels, tuple(checked))


# -- boundaries ------------------------------------------------------------------------------------


def _boundaries(
    loci: Sequence[Locus], lines: Sequence[FanLine], plane: tuple[str, str], window: Window
) -> Iterator[Array]:
    """Polylines on which stable responses begin or end."""
    for locus in loci:
        outside = np.array([_others_outside(locus, i) for i in range(len(locus))])
        curve = locus_curve(locus)
        for i in range(len(locus) - 1):
            if not (outside[i] and outside[i + 1]):
                yield curve.between(i)
    yield from _limit_lines(lines, plane, window)


def _others_outside(locus: Locus, index: int) -> bool:
    multipliers = locus.multipliers[index]
    others = np.delete(multipliers, critical_places(locus.type, multipliers))
    return bool((np.abs(others) > 1).any())


def _limit_lines(
    lines: Sequence[FanLine], plane: tuple[str, str], window: Window
) -> Iterator[Array]:
    """Join the ends of stable branches at a limit of the model from one line to the next."""
    for axis in (0, 1):
        along = [line for line in lines if line.fixed == plane[axis]]
        low, high = window[1 - axis]
        for a, b in pairwise(along):
            for period, name, value in _limit_ends(a):
                others = [
                    other
                    for other_period, other_name, other in _limit_ends(b)
                    if (other_period, other_name) == (period, name)
                    and abs(other - value) < LIMIT_JUMP * (high - low)
                ]
                if others:
                    other = min(others, key=lambda item: abs(item - value))
                    ends = np.array([[a.value, value], [b.value, other]])
                    yield ends if axis == 0 else ends[:, ::-1]


def _limit_ends(line: FanLine) -> Iterator[tuple[int, str, float]]:
    for branch in line.branches:
        for span in stable_spans(branch):
            if span.limit is not None:
                yield branch.period, span.limit_name, span.limit


def _without_slivers(pieces: Labels, boundary: Mask) -> Labels:
    """Give pieces too small to be regions no number."""
    sizes = np.bincount(pieces.ravel())
    small = sizes < SMALLEST * pieces.size
    small[0] = False
    return np.where(small[pieces], 0, pieces)


# -- labels ----------------------------------------------------------------------------------------


def _votes(
    pieces: Labels,
    clear: Mask,
    raster: _Raster,
    plane: tuple[str, str],
    lines: Sequence[FanLine],
) -> dict[int, list[tuple[int, ...]]]:
    """What every response says of the pieces it crosses, one entry a cell."""
    votes: dict[int, list[tuple[int, ...]]] = {}
    for line in lines:
        if not line.branches:
            continue
        axis = plane.index(line.fixed)
        cell = int(raster.columns(np.array([line.value]), axis)[0])
        crossed = pieces[:, cell] if axis == 0 else pieces[cell]
        sure = clear[:, cell] if axis == 0 else clear[cell]
        values = raster.centres(1 - axis)
        stable = [
            (branch.period, span) for branch in line.branches for span in stable_spans(branch)
        ]
        for index in np.flatnonzero(sure & (crossed > 0)):
            periods = {period for period, span in stable if span.low <= values[index] <= span.high}
            votes.setdefault(int(crossed[index]), []).append(tuple(sorted(periods)))
    return votes


def _labelled(
    pieces: Labels,
    votes: dict[int, list[tuple[int, ...]]],
    distance: Array,
    raster: _Raster,
) -> tuple[list[Region], Labels]:
    """Number the pieces that a response crosses, the largest first."""
    sizes = np.bincount(pieces.ravel(), minlength=2)
    order = sorted((piece for piece in votes), key=lambda piece: -sizes[piece])
    labels = np.zeros_like(pieces)
    regions = []
    total = sizes[1:].sum()
    for number, piece in enumerate(order, 1):
        labels[pieces == piece] = number
        said = votes[piece]
        # A stable orbit cannot vanish inside a region: one response that has it is enough.
        periods = tuple(sorted({period for vote in said for period in vote}))
        inside = np.where(pieces == piece, distance, 0)
        row, column = np.unravel_index(int(inside.argmax()), inside.shape)
        place = (float(raster.centres(0)[column]), float(raster.centres(1)[row]))
        regions.append(
            Region(number, periods, float(sizes[piece] / total), place, len(set(said)) == 1)
        )
    return regions, labels
