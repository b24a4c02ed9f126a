"""The regions between loci: found on a raster, labeled by the responses that cross them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from slipfold.arrays import Array, Indices
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.bifurcations.loci.fan import BranchEnd, FanLine
from slipfold.bifurcations.loci.into_stick import add_sticking, changes_in_stick, sticking_checks
from slipfold.bifurcations.loci.isolated import ISOLATED, Starts
from slipfold.bifurcations.loci.locus import Locus, lines_between
from slipfold.bifurcations.loci.region_map import Region, RegionCheck, RegionMap
from slipfold.bifurcations.loci.region_votes import (
    REGIONS,
    Raster,
    Vote,
    agree,
    check_region,
    collect_votes,
    orbits_continued_to,
    where_models_exist,
)
from slipfold.bifurcations.loci.window import Plane
from slipfold.flow.modes import MET
from slipfold.orbits.test_functions import critical_places

NO_GRAZING: Mapping[BranchEnd, SpecialPoint] = MappingProxyType({})

ENDING = ("limit", "span")
"""Kinds of ends that limits of the model are joined to."""


def map_regions(
    plane: Plane,
    loci: Sequence[Locus],
    lines: Sequence[FanLine],
    grazing: Mapping[BranchEnd, SpecialPoint] = NO_GRAZING,
) -> RegionMap:
    """Label the regions between loci by the stable responses of period 1 and 2 in them.

    A boundary is a segment of a locus on which no other multiplier is outside the unit circle, or
    the end of a stable branch at a limit of the model, unless a grazing point is near: that lies on
    a locus. Inside a region nothing changes, so all responses that cross it agree. Where two
    disagree, or one has a pitchfork inside whose locus is not known, the region is marked. Where
    responses stick, trajectories decide which do.
    """
    from scipy import ndimage  # a tenth of a second to import

    raster = Raster(plane.window)
    boundary = np.zeros((REGIONS.cells, REGIONS.cells), dtype=bool)
    for values in _boundaries(plane, loci, lines, grazing):
        raster.draw(boundary, values)
    exists = where_models_exist(plane, raster)
    pieces: Indices = ndimage.label(~boundary & exists)[0].astype(np.int64)
    pieces = _without_slivers(pieces)
    distance: Array = ndimage.distance_transform_edt(np.pad(pieces > 0, 1))[1:-1, 1:-1]
    clear = ndimage.distance_transform_edt(~boundary) > REGIONS.clearance
    bands = list(_short_of_grazing(plane, lines, grazing))
    votes = [
        vote
        for vote in collect_votes(plane, raster, pieces, clear, lines)
        if not any((low <= vote.place).all() and (vote.place <= high).all() for low, high in bands)
    ]
    regions, labels = _labeled(plane, pieces, votes, distance, raster)
    split = {int(labels[cell]) for cell in _changes(plane, lines, raster) if clear[cell]}
    regions = [
        replace(region, consistent=False) if region.id in split else region for region in regions
    ]
    numbers = {region.id: int(pieces[labels == region.id][0]) for region in regions}
    nearest = ndimage.distance_transform_edt(
        labels == 0, return_distances=False, return_indices=True
    )
    if regions:
        labels = np.where(exists, labels[tuple(nearest)], 0)
    may_stick = (
        bool(grazing)
        or any(line.sticking for line in lines)
        or any(locus.type in MET for locus in loci)
    )
    starts = Starts(plane.model, [branch for line in lines for branch in line.branches])
    checked: list[Region] = []
    for region in regions:
        if region.fraction >= REGIONS.checked:
            plane.report("regions", len(checked), len(regions), region.place, region.name)
            piece = [vote for vote in votes if vote.piece == numbers[region.id]]
            orbits = {
                period: orbits_continued_to(plane, piece, region.place, period)
                for period in set(region.stable)
            }
            states = starts.number(ISOLATED.places * len(lines) + region.id)
            checks: tuple[RegionCheck, ...] = ()
            if may_stick:
                at, seeds = [vote.place for vote in piece], [vote.sticking for vote in piece]
                region, stuck = add_sticking(plane, region, at, seeds)
                checks = sticking_checks(plane, region, stuck)
            checks += check_region(plane, region, orbits, states, may_stick=may_stick)
            region = replace(region, checks=checks)
        checked.append(region)
    return RegionMap(raster.centers(0), raster.centers(1), labels, tuple(checked))


# -- boundaries ------------------------------------------------------------------------------------


def _boundaries(
    plane: Plane, loci: Sequence[Locus], lines: Sequence[FanLine], grazing: Collection[BranchEnd]
) -> Iterator[Array]:
    """Polylines on which stable responses begin or end."""
    for locus in loci:
        outside = [_others_outside(locus, i) for i in range(len(locus))]
        for line, ends in zip(lines_between(locus), pairwise(outside), strict=True):
            if not all(ends):
                yield line
    yield from _gaps_near_stick(plane, loci, lines, grazing)
    yield from _limit_lines(plane, lines, grazing)


def _short_of_grazing(
    plane: Plane, lines: Sequence[FanLine], grazing: Mapping[BranchEnd, SpecialPoint]
) -> Iterator[Array]:
    """Yield the ends of stretches of lines in which a response still slips, too slowly to follow.

    They say nothing of their region. Shapes: (2, 2).
    """
    for line in lines:
        for branch in line.branches:
            for row in (0, -1):
                point = grazing.get((branch, row))
                if point is None:
                    continue
                ends = np.full((2, 2), line.value)
                along = sorted((branch.parameter[row], point.value))
                ends[:, plane.names.index(line.vary)] = along
                yield ends


def _gaps_near_stick(
    plane: Plane, loci: Sequence[Locus], lines: Sequence[FanLine], grazing: Collection[BranchEnd]
) -> Iterator[Array]:
    """Join loci in slip, which end short of stick, to where responses beside them come to it."""
    if not any(locus.type in MET for locus in loci):
        return
    grazings = [line for locus in loci if locus.type in MET for line in lines_between(locus)]
    doubled = [
        plane.place(line.vary, end.value, line.value)
        for line in lines
        for end in _ends(line, grazing)
        if end.period > 1 and end.reason
    ]
    near = (np.concatenate([np.empty((0, 2)), *grazings]), REGIONS.short_of_stick)
    jumps = (np.reshape(doubled, (-1, 2)), REGIONS.limit_jump)
    for locus in loci:
        for end in (locus.started, locus.stopped):
            if locus.type in MET or end.kind != "limit":
                continue
            for others, reach in (near, jumps):
                apart = np.linalg.norm((others - end.values) / plane.size, axis=-1)
                if apart.min(initial=np.inf) < reach:
                    yield np.array([end.values, others[apart.argmin()]])


def _others_outside(locus: Locus, index: int) -> bool:
    multipliers = locus.multipliers[index]
    others = np.delete(multipliers, critical_places(locus.type, multipliers))
    return bool((np.abs(others) > 1).any())


def _limit_lines(
    plane: Plane, lines: Sequence[FanLine], grazing: Collection[BranchEnd]
) -> Iterator[Array]:
    """Join the ends of stable branches at a limit of the model from one line to the next."""
    for axis in (0, 1):
        along = [line for line in lines if line.fixed == plane.names[axis]]
        for a, b in pairwise(along):
            left, right = _ends(a, grazing), _ends(b, grazing)
            for one, other in _joined(left, right, REGIONS.limit_jump * plane.size[1 - axis]):
                ends = np.array([[a.value, one], [b.value, other]])
                yield ends if axis == 0 else ends[:, ::-1]


class _End(NamedTuple):
    """Where a branch ends at a limit of the model, or at the edge of the window."""

    period: int
    reason: str
    value: float
    stable: bool

    def continues(self, other: _End) -> bool:
        """Whether a limit goes from one end to the other, next to a stable response."""
        same = self.reason == other.reason or "" in (self.reason, other.reason)
        beside = (self.reason and self.stable) or (other.reason and other.stable)
        return self.period == other.period and same and bool(beside)


def _ends(line: FanLine, grazing: Collection[BranchEnd]) -> list[_End]:
    """Where branches end; where they begin at a limit they were followed both ways."""
    return [
        _End(
            branch.period,
            end.reason.split(":")[0] if end.kind == "limit" else "",
            end.value,
            bool(branch.stable[row]),
        )
        for branch in line.branches
        if len(branch)
        for row, end, kinds in ((0, branch.started, ("limit",)), (-1, branch.stopped, ENDING))
        if end.kind in kinds and (branch, row) not in grazing
    ]


def _changes(plane: Plane, lines: Sequence[FanLine], raster: Raster) -> Iterator[tuple[int, int]]:
    """Yield the cells, as row and column, at which the stable responses of a line change.

    Pitchforks at which some emanate; of those through stick whatever they meet, and where they
    end.
    """
    for line in lines:
        for value in (*_forks(line), *changes_in_stick(line)):
            place = plane.place(line.vary, value, line.value)
            if plane.contains(place):  # responses are followed beyond the window
                column, row = (int(raster.columns(np.array([place[i]]), i)[0]) for i in (0, 1))
                yield row, column


def _forks(line: FanLine) -> Iterator[float]:
    for point in (point for branch in line.branches for point in branch.special):
        others = np.delete(point.multipliers, np.abs(point.multipliers - 1).argmin())
        # At a transcritical point two responses exchange stability: their number stays.
        if point.name == "pitchfork" and (np.abs(others) <= 1).all():
            yield point.value


def _joined(left: list[_End], right: list[_End], reach: float) -> Iterator[tuple[float, float]]:
    """Pair every end on one line with the nearest that continues it on the next."""
    for end in left:
        others = [item.value for item in right if end.continues(item)]
        nearest = min(others, key=lambda value: abs(value - end.value), default=np.inf)
        if abs(nearest - end.value) < reach:
            yield end.value, nearest


def _without_slivers(pieces: Indices) -> Indices:
    """Give pieces too small to be regions no number."""
    sizes = np.bincount(pieces.ravel())
    small = sizes < REGIONS.smallest * pieces.size
    small[0] = False
    return np.where(small[pieces], 0, pieces)


# -- labels ----------------------------------------------------------------------------------------


def _labeled(
    plane: Plane, pieces: Indices, votes: Sequence[Vote], distance: Array, raster: Raster
) -> tuple[list[Region], Indices]:
    """Number the pieces that a response crosses, the largest first."""
    sizes = np.bincount(pieces.ravel(), minlength=2)
    crossed = sorted({vote.piece for vote in votes}, key=lambda piece: -sizes[piece])
    labels = np.zeros_like(pieces)
    regions = []
    total = sizes[1:].sum()
    for number, piece in enumerate(crossed, 1):
        labels[pieces == piece] = number
        said = [vote for vote in votes if vote.piece == piece]
        # A stable orbit cannot vanish inside a region: one response that has it is enough.
        kinds = sorted({period for vote in said for period in vote.nodes})
        counts = [max(vote.count(period) for vote in said) for period in kinds]
        periods = tuple(np.repeat(kinds, counts).astype(int).tolist())
        inside = np.where(pieces == piece, distance, 0)
        row, column = np.unravel_index(int(inside.argmax()), inside.shape)
        place = (float(raster.centers(0)[column]), float(raster.centers(1)[row]))
        fraction = float(sizes[piece] / total)
        regions.append(Region(number, periods, fraction, place, agree(plane, said)))
    return regions, labels
