"""Votes of responses on each cell of the window, and checks by simulation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.continuation.walk import Failure
from slipfold.errors import InputError
from slipfold.flow.simulate import simulate
from slipfold.flow.trajectory import Trajectory
from slipfold.loci.fan import FanLine
from slipfold.loci.into_stick import stable_states_near
from slipfold.loci.isolated import is_among, other_orbits, stable_orbits
from slipfold.loci.region_map import Region, RegionCheck
from slipfold.loci.window import Plane, Window
from slipfold.models.model import Model
from slipfold.orbits.continued import Straight, continue_to
from slipfold.orbits.kinds import ForcedOrbits
from slipfold.orbits.limits import broken_limit
from slipfold.orbits.orbit_curve import OrbitPoint

CELLS = 480
"""Cells in either direction: half a line's width in a figure."""

BLOCK = 8
"""Cells in either direction that are first asked for at once whether a model exists there."""


@dataclass(frozen=True)
class Raster:
    """Cells of a window."""

    window: Window  # least and largest value of two parameters

    def columns(self, values: Array, axis: int) -> NDArray[np.int64]:
        """Return the cells that values of a parameter lie in, shape (n,). Shapes: values (n,)."""
        low, high = self.window[axis]
        cells = ((np.asarray(values) - low) / (high - low) * CELLS).astype(int)
        return np.clip(cells, 0, CELLS - 1)

    def centers(self, axis: int) -> Array:
        """Return the values of a parameter at the centers of the cells, shape (CELLS,)."""
        low, high = self.window[axis]
        return np.linspace(low, high, 2 * CELLS + 1)[1::2]

    def draw(self, mask: NDArray[np.bool_], values: Array) -> None:
        """Mark the cells that a polyline passes, without gaps.

        Shapes: mask (CELLS, CELLS); values (n, 2).
        """
        for a, b in pairwise(values):
            length = [
                abs(b[i] - a[i]) / (high - low) * CELLS for i, (low, high) in enumerate(self.window)
            ]
            count = int(2 * max(length)) + 2
            between = a + np.linspace(0, 1, count)[:, None] * (b - a)
            inside = np.all(
                [
                    (low <= v) & (v <= high)
                    for v, (low, high) in zip(between.T, self.window, strict=True)
                ],
                axis=0,
            )
            kept = between[inside]
            mask[self.columns(kept[:, 1], 1), self.columns(kept[:, 0], 0)] = True


def where_models_exist(plane: Plane, raster: Raster) -> NDArray[np.bool_]:
    """Return whether the parameters at the center of each cell define a model.

    Returns shape (CELLS, CELLS).
    """
    first, second = raster.centers(0), raster.centers(1)
    middles = np.arange(BLOCK // 2, CELLS, BLOCK)
    of = plane.model, plane.names
    coarse = np.array([[model_exists(*of, first[i], second[j]) for i in middles] for j in middles])
    fine = np.kron(coarse, np.ones((BLOCK, BLOCK), dtype=bool)).astype(bool)
    for row, column in zip(*np.nonzero(_beside_others(coarse)), strict=True):
        for j in range(row * BLOCK, (row + 1) * BLOCK):
            for i in range(column * BLOCK, (column + 1) * BLOCK):
                fine[j, i] = model_exists(*of, first[i], second[j])
    return fine


def model_exists(model: Model, names: tuple[str, str], first: float, second: float) -> bool:
    """Whether the parameters do not contradict each other at a place."""
    try:
        model.replace(**{names[0]: float(first), names[1]: float(second)})
    except InputError:
        return False
    return True


def _beside_others(coarse: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Blocks that have a neighbor of the other sort, diagonals included."""
    padded = np.pad(coarse, 1, mode="edge")
    n, m = coarse.shape
    around = [padded[i : i + n, j : j + m] for i in range(3) for j in range(3)]
    return np.asarray(np.any([other != coarse for other in around], axis=0))


SEEDS = 3
"""Orbits tried, the nearest first, where one is to be carried to a place."""


@dataclass(frozen=True, eq=False)
class Vote:
    """One response crossing one piece of the plane."""

    piece: int  # number of the piece
    place: tuple[float, float]  # values of the two parameters in the middle of the crossing
    # Stable orbits at the place by their period, each of shape (m, n_states)
    nodes: dict[int, list[Array]]
    # States of the stable orbits that stick beside it
    sticking: tuple[Array, ...] = ()

    def count(self, period: int) -> int:
        """Return how many stable orbits of a period there are."""
        return len(self.nodes.get(period, ()))


def collect_votes(
    plane: Plane,
    raster: Raster,
    pieces: NDArray[np.int64],
    clear: NDArray[np.bool_],
    lines: Sequence[FanLine],
) -> Iterator[Vote]:
    """Yield the vote of every response on the pieces it crosses."""
    for line in lines:
        if not (line.branches or line.sticking):
            continue
        axis = plane.names.index(line.fixed)
        cell = int(raster.columns(np.array([line.value]), axis)[0])
        crossed = pieces[:, cell] if axis == 0 else pieces[cell]
        sure = clear[:, cell] if axis == 0 else clear[cell]
        values = raster.centers(1 - axis)
        for run in _runs(np.where(sure, crossed, 0)):
            value = float(values[run[len(run) // 2]])
            place = plane.place(line.vary, value, line.value)
            sticking = tuple(stable_states_near(line, value))
            found = stable_orbits(line.branches, value)
            yield Vote(int(crossed[run[0]]), place, found, sticking)


def _runs(numbers: NDArray[np.int64]) -> Iterator[NDArray[np.int64]]:
    """Places of each uninterrupted sequence of one number other than 0."""
    edges = np.flatnonzero(np.diff(numbers)) + 1
    for run in np.split(np.arange(len(numbers)), edges):
        if numbers[run[0]]:
            yield run


def agree(plane: Plane, votes: Sequence[Vote]) -> bool:
    """Whether responses across one piece agree.

    A response does not reach every orbit there is. One that lacks what another has does not
    contradict it if the orbit can be carried to its place, and is stable all the way.
    """
    for period in {period for vote in votes for period in vote.nodes}:
        wanted = max(vote.count(period) for vote in votes)
        for vote in votes:
            if vote.count(period) == wanted:
                continue
            if len(orbits_continued_to(plane, votes, vote.place, period)) != wanted:
                return False
    return True


def orbits_continued_to(
    plane: Plane, votes: Sequence[Vote], place: tuple[float, float], period: int
) -> list[Array]:
    """Return the stable orbits of a period at a place, carried there from the nearest votes.

    Returns shape (m, n_states).
    """
    size = plane.size
    wanted = max(vote.count(period) for vote in votes)
    having = [vote for vote in votes if vote.count(period) == wanted]
    apart = [float(np.linalg.norm(np.subtract(vote.place, place) / size)) for vote in having]
    near = [having[i] for i in np.argsort(apart, kind="stable")]
    best: list[Array] = []
    for seed in near[:SEEDS]:
        found: list[Array] = []
        # The parameter that changes most says where on the way an orbit is.
        order = np.argsort(np.abs(np.array(place) - seed.place) / size)
        names = [plane.names[i] for i in order]
        begin, end = np.array(seed.place)[order], np.array(place)[order]
        for start in seed.nodes.get(period, ()):
            nodes = _continued(plane.model, names, start, begin, end, size[order], period)
            if nodes is not None and not is_among(plane.model, nodes, period, found):
                found.append(nodes)
        best = max(best, found, key=len)
        if len(best) == wanted:
            break
    return best


def _continued(
    model: Model,
    names: Sequence[str],
    nodes: Array,
    begin: Array,
    end: Array,
    size: Array,
    period: int,
) -> Array | None:
    """Continue a stable orbit along the straight line between two places.

    Shapes: nodes (m, n_states); begin, end, size (2,); returns (m, n_states).
    """
    if (begin == end).all():
        return nodes
    orbits = ForcedOrbits(model, dict(zip(names, size.tolist(), strict=True)), period, len(nodes))

    def refuse(point: OrbitPoint) -> str | None:
        if np.abs(point.multipliers).max() > 1:
            return "it is unstable on the way"
        try:
            orbits.model_at(point.z)
        except InputError as error:  # on the way lies no model
            return str(error)
        return broken_limit(orbits, point.z)

    reached = continue_to(Straight(orbits, begin, end), orbits.pack(nodes, begin), end[-1], refuse)
    return None if isinstance(reached, Failure) else orbits.nodes(reached.z)


FORCING_PERIODS = 3000
"""Forcing periods of a check: the slowest decay of the base case, 0.96 a period, needs a
thousand near a boundary."""

SETTLED = 1e-7
"""Distance from a periodic response that counts as settled, in scaled states."""

PERTURBATION = 1e-4
"""Distance from a stable orbit at which a trajectory starts, in scaled states."""


def check_region(
    plane: Plane,
    region: Region,
    orbits: Mapping[int, Sequence[Array]],
    states: Array,
    *,
    may_stick: bool = False,
) -> tuple[RegionCheck, ...]:
    """Simulate from rest, from beside each stable orbit and from states far off, well inside.

    Shapes: orbits (m, n_states); states (k, n_states).
    """
    at = plane.at(region.place)
    # Where contacts stick, motions from rest go on through that, and are looked at as such.
    checks = [] if may_stick else [_from_rest(at, region)]
    for period in sorted(set(region.slipping)):
        found = orbits.get(period, ())
        checks += [_from_orbit(at, region, period, nodes[0]) for nodes in found]
        for _ in range(region.slipping.count(period) - len(found)):
            note = "the orbit could not be continued to this point"
            checks.append(RegionCheck(region.place, f"period {period}", 0, False, note))
    for orbit in other_orbits(at, orbits, states):
        note = f"settled on a response of period {orbit.period} that none across the region has"
        checks.append(RegionCheck(region.place, "elsewhere", orbit.period, False, note))
    return tuple(checks)


def _from_rest(model: Model, region: Region) -> RegionCheck:
    check = _judged(
        simulate(model, FORCING_PERIODS, tolerance=SETTLED, through_stick=False), region
    )
    if check.agrees:
        return check
    # A motion may rest for ever on a response that is not stable, as symmetry lets it.
    pushed = _beside(model, model.start)
    return _judged(
        simulate(model, FORCING_PERIODS, pushed, tolerance=SETTLED, through_stick=False), region
    )


def _judged(motion: Trajectory, region: Region) -> RegionCheck:
    settled = motion.settlement.period or 0
    # Longer periods and tori are no contradiction: the label speaks of periods 1 and 2.
    agrees = settled not in (1, 2) or settled in region.stable
    return RegionCheck(region.place, "rest", settled, agrees, motion.settlement.message)


def _beside(model: Model, state: Array) -> Array:
    return np.asarray(state + PERTURBATION * model.state_scales() / np.sqrt(len(state)))


def _from_orbit(model: Model, region: Region, period: int, state: Array) -> RegionCheck:
    motion = simulate(
        model, FORCING_PERIODS, _beside(model, state), tolerance=SETTLED, through_stick=False
    )
    settled = motion.settlement.period or 0
    return RegionCheck(
        region.place, f"period {period}", settled, settled == period, motion.settlement.message
    )
