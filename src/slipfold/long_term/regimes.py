"""Classes of trajectories over a plane of parameters and in regions of a bifurcation set."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations

import numpy as np

from slipfold.arrays import Array, Indices, Mask
from slipfold.bifurcations.loci.region_map import Region, RegionCheck, RegionMap, RegionMotion
from slipfold.bifurcations.loci.window import Window, locus_progress
from slipfold.flow.flow import flow_of
from slipfold.long_term.classification import (
    CHAOS,
    CLASSIFICATION,
    NOT_DONE,
    OPEN,
    PERIODIC,
    STICKS,
    TORUS,
    UNDECIDED,
    Classified,
    TrajectoryGrid,
)
from slipfold.models.angles import distances
from slipfold.models.model import Model
from slipfold.progress import Observer, Progress

NONE = "none"
"""Kind of a run in a cell without a further trajectory."""

APERIODIC = (TORUS, CHAOS, UNDECIDED)

UP, DOWN = 1, 2
"""Runs that have already continued their trajectories along the second parameter."""

STEPS = ((1, 0), (-1, 0), (0, 1), (0, -1))
"""Steps from a cell to its neighbors along the first and the second parameter."""


def continue_to_neighbors(work: TrajectoryGrid, grid: Indices) -> None:
    """Continue each trajectory of each cell to the cells next to it, until none is new.

    A trajectory is new if the cell has none of its kind, or, if it repeats, none of its period and
    mean. New trajectories are stored in further runs. Shapes: grid (n1, n2), the cells.
    """
    new = _distinct(work)
    while len(new):
        proposals = _proposals(work, grid, new)
        work.total += len(proposals) * work.periods_of_a_motion
        result = [
            _continued(work, proposals[first : first + CLASSIFICATION.batch])
            for first in range(0, len(proposals), CLASSIFICATION.batch)
        ]
        new = np.concatenate([np.empty((0, 2), np.intp), *result])


def _distinct(work: TrajectoryGrid) -> Indices:
    """Return run and cell of each trajectory that no earlier run has in that cell."""
    cells = np.arange(work.known.kinds.shape[1])
    result = []
    for run in range(len(work.known.kinds)):
        rows = np.full(len(cells), run)
        new = ~_known(work, cells, work.known.rows((run, cells)), run)
        result.append(np.column_stack([rows[new], cells[new]]))
    return np.concatenate(result)


def _proposals(work: TrajectoryGrid, grid: Indices, sources: Indices) -> Indices:
    """Return run and cell of trajectories, each with a neighboring cell to continue it to."""
    shape = grid.shape
    result = []
    for step in STEPS:
        places = np.array(np.unravel_index(sources[:, 1], shape)) + np.array(step)[:, None]
        inside = ((places >= 0) & (places < np.array(shape)[:, None])).all(axis=0)
        # A sweep with this trajectory has continued it to the next cell already.
        done = (DOWN, UP)[step[1] > 0] if step[1] else None
        if done is not None:
            swept = work.known.rows((done, sources[:, 1]))
            inside &= ~_same(work, sources[:, 1], swept, work.known.rows(tuple(sources.T)))
        targets = grid[tuple(places[:, inside])]
        result.append(np.column_stack([sources[inside], targets]))
    proposals = np.concatenate(result)
    # Trajectories with stick are expensive, and not distinguished.
    sticks = work.known.kinds[proposals[:, 0], proposals[:, 1]] == STICKS
    stuck_there = (work.known.kinds[:, proposals[:, 2]] == STICKS).any(axis=0)
    return proposals[~(sticks & stuck_there)]


def _continued(work: TrajectoryGrid, proposals: Indices) -> Indices:
    """Follow some proposals; store what is new, and return its runs and cells."""
    runs, cells, targets = proposals.T
    result = work.judged(targets, work.known.states[runs, cells])
    # A trajectory that does not repeat soon keeps its kind; if that is new, it is followed longer.
    opened = result.kinds == OPEN
    before = work.known.kinds[runs, cells]
    result.kinds[opened] = np.where(np.isin(before, APERIODIC), before, UNDECIDED)[opened]
    new = ~_known(work, targets, result)
    longer = np.flatnonzero(new & opened)
    if len(longer):
        judged, interrupted = work.classified_open(targets[longer], result.states[longer])
        if interrupted:
            raise KeyboardInterrupt
        result.put(longer, judged)
        new &= ~_known(work, targets, result)
    return _stored(work, targets, result, np.flatnonzero(new))


def _stored(work: TrajectoryGrid, targets: Indices, result: Classified, rows: Indices) -> Indices:
    """Store trajectories that are new, one after the other; return their runs and cells."""
    kept = []
    for row in rows:
        cell, trajectory = targets[row : row + 1], result.rows(np.array([row]))
        if _known(work, cell, trajectory)[0]:
            continue
        free = np.flatnonzero(work.known.kinds[:, cell[0]] == NONE)
        if not len(free):
            nowhere = Classified.unknown(NONE, np.full_like(work.known.states[:1], np.nan))
            work.known = work.known.joined(nowhere)
            free = np.array([len(work.known.kinds) - 1])
        work.known.put((free[:1], cell), trajectory)
        kept.append((free[0], cell[0]))
    return np.array(kept, np.intp).reshape(-1, 2)


def _known(
    work: TrajectoryGrid, cells: Indices, result: Classified, runs: int | None = None
) -> Mask:
    """Whether the first runs, or all of them, have the trajectories in their cells already."""
    known = ~np.isin(result.kinds, (PERIODIC, STICKS, *APERIODIC))
    for run in range(len(work.known.kinds) if runs is None else runs):
        known |= _same(work, cells, work.known.rows((run, cells)), result)
    return known


def _same(work: TrajectoryGrid, cells: Indices, one: Classified, other: Classified) -> Mask:
    """Whether pairs of trajectories are the same, or may be if one is undecided."""
    apart = distances(work.models[0], one.means, other.means)
    alike = (one.kinds == other.kinds) & (one.periods == other.periods)
    periodic = alike & (apart <= CLASSIFICATION.same_mean)
    (rows,) = np.nonzero(alike & (one.kinds == PERIODIC) & ~periodic)
    if len(rows):
        periodic[rows] = _shifted(work, cells[rows], one.means[rows], other.means[rows])
    same = (one.kinds == other.kinds) & (periodic | (one.kinds != PERIODIC))
    both = np.isin(one.kinds, APERIODIC) & np.isin(other.kinds, APERIODIC)
    return same | both & ((one.kinds == UNDECIDED) | (other.kinds == UNDECIDED))


def _shifted(work: TrajectoryGrid, cells: Indices, one: Array, other: Array) -> Mask:
    """Whether a shift, as to the next of a pendulum's wells, changes far less than part of it."""
    flow, count = flow_of(work.model), len(cells)
    vectors = np.array([work.models[cell].vector for cell in cells])
    constants = flow.constants(vectors, np.tile(work.scales, (count, 1)))
    changes = np.zeros((2, *one.shape))
    # Places that no symmetry singles out, and a part of which no few make a shift
    for phase, *around in np.random.default_rng(0).uniform(-1, 1, (4, one.shape[1] + 1)):
        states = (one + around * work.scales + part * (other - one) for part in (0.0, 0.38, 1.0))
        there, *moved = (flow.rates(at, np.full(count, phase), constants) for at in states)
        changes = np.maximum(changes, np.abs(np.array(moved) - there) / work.scales)
    part, whole = changes.max(axis=2)
    return np.asarray(whole <= CLASSIFICATION.same_mean * part)


RUNS = ("rest", "up", "down")
"""The first runs; those after them are trajectories continued from neighboring cells."""


def find_regimes(
    model: Model,
    over: Mapping[str, Array],
    start: Array,
    transient: int,
    observer: Observer | None = None,
) -> tuple[TrajectoryGrid, bool]:
    """Follow trajectories in all cells: from the start, and from those of neighboring cells.

    Runs up and down along the second parameter come first. Then every trajectory is continued to
    all neighbors until none is new. Return them, and whether that was interrupted. Shapes: over
    (n1,), (n2,); start (n,).
    """
    grids = np.meshgrid(*over.values(), indexing="ij")
    values = {name: grid.ravel() for name, grid in zip(over, grids, strict=True)}
    work = TrajectoryGrid(model, values, len(RUNS), start, transient, observer)
    interrupted = False
    try:
        work.from_rest(0)
        cells = np.arange(grids[0].size).reshape(grids[0].shape)
        _sweep(work, cells)
        work.classify_open()
        continue_to_neighbors(work, cells)
        _name_alike(work)
    except KeyboardInterrupt:
        interrupted = True
    return work, interrupted


def _sweep(work: TrajectoryGrid, lines: Indices) -> None:
    """Continue trajectories along the second parameter, up and down again."""
    states = np.tile(work.start, (lines.shape[0], 1))
    for index in range(lines.shape[1]):
        states = work.follow(1, lines[:, index], states)
    for index in reversed(range(lines.shape[1])):
        states = work.follow(2, lines[:, index], states)


def _name_alike(work: TrajectoryGrid) -> None:
    """Give responses that are one but for a shift the mean of the first."""
    known, cells = work.known, np.arange(work.known.kinds.shape[1])
    for later, run in combinations(range(len(known.kinds))[::-1], 2):
        rows = (run, cells), (later, cells)
        same = _same(work, cells, *map(known.rows, rows)) & (known.kinds[later] == PERIODIC)
        known.means[later, same] = known.means[run, same]


def resolve_regions(
    model: Model,
    plane: tuple[str, str],
    window: Window,
    regions: RegionMap,
    points: tuple[int, int],
    observer: Observer | None = None,
) -> tuple[RegionMap, bool]:
    """Follow trajectories on a grid in regions without known stable responses.

    Return the regions with their trajectories, and whether that was interrupted. A contradiction
    between trajectories and the label of a region adds a check that makes the label unknown.
    """
    places = {
        region.id: _places(regions, region, window, points)
        for region in regions.regions
        if not (region.known and region.stable)
    }
    if not places:
        return regions, False
    numbers = np.repeat([*places], [len(result) for result in places.values()])
    values = np.array([point for result in places.values() for point in result])

    def on_progress(progress: Progress) -> None:
        if observer is not None:
            text = f"forcing periods of trajectories at {len(values)} places"
            middle = (float(values[0, 0]), float(values[0, 1]))
            observer(locus_progress("regimes", progress.done, progress.total, middle, text))

    columns = dict(zip(plane, values.T, strict=True))
    start = np.asarray(model.start, dtype=float)
    work = TrajectoryGrid(model, columns, 1, start, CLASSIFICATION.transient, on_progress)
    interrupted = False
    try:
        work.from_rest(0)
        work.classify_open()
    except KeyboardInterrupt:
        interrupted = True
    result: dict[int, list[RegionMotion]] = {number: [] for number in places}
    known = zip(work.reported_kinds[0], work.known.periods[0], work.known.exponents[0], strict=True)
    for number, point, (kind, period, exponent) in zip(numbers, values, known, strict=True):
        if kind != NOT_DONE:
            at = (float(point[0]), float(point[1]))
            largest = None if np.isnan(exponent) else float(exponent)
            result[int(number)].append(RegionMotion(at, str(kind), int(period), largest))
    resolved = tuple(_with(region, tuple(result.get(region.id, ()))) for region in regions.regions)
    return replace(regions, regions=resolved), interrupted


def _with(region: Region, trajectories: tuple[RegionMotion, ...]) -> Region:
    """Return a region with its trajectories and a check for each period missing in its label.

    Longer periods are no contradiction, since labels list periods 1 and 2.
    """
    against = []
    for period in sorted({1, 2} - {*region.stable}):
        seen = [one.values for one in trajectories if (one.kind, one.period) == (PERIODIC, period)]
        if seen:
            note = (
                f"settled on a response of period {period} that none across the region has, seen "
                f"at {len(seen)} of {len(trajectories)} places"
            )
            against.append(RegionCheck(seen[0], "rest", period, False, note))
    return replace(region, motions=trajectories, checks=(*region.checks, *against))


def _places(
    regions: RegionMap, region: Region, window: Window, points: tuple[int, int]
) -> list[tuple[float, float]]:
    """Return the centers of the cells of a grid that lie in a region, or the region's own place."""
    from scipy.ndimage import minimum_filter  # a tenth of a second to import

    first, second = (
        low + (np.arange(count) + 0.5) * (high - low) / count
        for (low, high), count in zip(window, points, strict=True)
    )
    # Away from its borders; the edge of the map is no border
    size = 2 * CLASSIFICATION.margin + 1
    inside = minimum_filter(regions.labels == region.id, size, mode="nearest")
    columns, rows = (
        np.abs(cells - values[:, None]).argmin(axis=1)
        for cells, values in ((regions.first, first), (regions.second, second))
    )
    grid = inside[np.ix_(rows, columns)]
    result = [(float(first[i]), float(second[j])) for j, i in np.argwhere(grid)]
    return result or [region.place]
