"""Votes of responses on each cell of the window, and checks by simulation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from slipfold.arrays import Array, Indices, Mask
from slipfold.bifurcations.loci.fan import FanLine
from slipfold.bifurcations.loci.into_stick import stable_states_near
from slipfold.bifurcations.loci.isolated import is_among, other_orbits, stable_orbits
from slipfold.bifurcations.loci.region_map import Region, RegionCheck
from slipfold.bifurcations.loci.window import Plane, Window
from slipfold.continuation.walk import Failure
from slipfold.errors import InputError, refusal
from slipfold.flow.simulate import simulate
from slipfold.models.model import Model
from slipfold.orbits.continued import Straight, continue_to
from slipfold.orbits.kinds import ForcedOrbits
from slipfold.orbits.limits import broken_limit
from slipfold.orbits.orbit_curve import OrbitPoint


class REGIONS:
    """How finely regions are drawn, and how they are checked."""

    cells: int = 480  # cells in either direction: half the width of a line in a figure
    block: int = 8  # cells in either direction that are tested at once for a model
    seeds: int = 3  # orbits tried, the nearest first, where one is continued to a place
    periods: int = 3000  # forcing periods of a check: decay by 0.96 a period takes a thousand
    # Distance from a periodic response that counts as converged, in scaled states
    converged: float = 1e-7
    perturbation: float = 1e-4  # distance from a stable orbit at which a trajectory starts
    # Fraction of the window below which a piece belongs to what surrounds it
    smallest: float = 2e-4
    checked: float = 2e-3  # fraction of the window from which a region is checked by simulation
    clearance: float = 2.5  # cells from a boundary at which a response determines its region
    short_of_stick: float = 0.05  # distance, in windows, from the end of a locus in slip to grazing
    limit_jump: float = 0.25  # difference, in windows, of ends at a limit that are joined


@dataclass(frozen=True)
class Raster:
    """Cells of a window."""

    window: Window  # least and largest value of two parameters

    def columns(self, values: Array, axis: int) -> Indices:
        """Return the cells that values of a parameter lie in, shape (n,). Shapes: values (n,)."""
        low, high = self.window[axis]
        cells = ((np.asarray(values) - low) / (high - low) * REGIONS.cells).astype(int)
        return np.clip(cells, 0, REGIONS.cells - 1)

    def centers(self, axis: int) -> Array:
        """Return the values of a parameter at the centers of the cells, shape (cells,)."""
        low, high = self.window[axis]
        return np.linspace(low, high, 2 * REGIONS.cells + 1)[1::2]

    def draw(self, mask: Mask, values: Array) -> None:
        """Mark the cells that a polyline passes, without gaps.

        Shapes: mask (cells, cells); values (n, 2).
        """
        low, high = np.array(self.window).T
        slack = 1e-12 * (high - low)  # ends on the border lie beyond it by rounding
        for a, b in pairwise(values):
            count = int(2 * np.abs((b - a) / (high - low) * REGIONS.cells).max()) + 2
            between = a + np.linspace(0, 1, count)[:, None] * (b - a)
            kept = between[((low - slack <= between) & (between <= high + slack)).all(axis=1)]
            mask[self.columns(kept[:, 1], 1), self.columns(kept[:, 0], 0)] = True


def where_models_exist(plane: Plane, raster: Raster) -> Mask:
    """Return whether the parameters at the center of each cell define a model.

    Returns shape (cells, cells).
    """
    first, second = raster.centers(0), raster.centers(1)
    middles = np.arange(REGIONS.block // 2, REGIONS.cells, REGIONS.block)
    of = plane.model, plane.names
    coarse = np.array([[model_exists(*of, first[i], second[j]) for i in middles] for j in middles])
    fine = np.kron(coarse, np.ones((REGIONS.block, REGIONS.block), dtype=bool)).astype(bool)
    for row, column in zip(*np.nonzero(_beside_others(coarse)), strict=True):
        for j in range(row * REGIONS.block, (row + 1) * REGIONS.block):
            for i in range(column * REGIONS.block, (column + 1) * REGIONS.block):
                fine[j, i] = model_exists(*of, first[i], second[j])
    return fine


def model_exists(model: Model, names: tuple[str, str], first: float, second: float) -> bool:
    """Whether the parameters do not contradict each other at a place."""
    return not refusal(model.replace, **{names[0]: float(first), names[1]: float(second)})


def _beside_others(coarse: Mask) -> Mask:
    """Blocks that have a neighbor of the other sort, diagonals included."""
    padded = np.pad(coarse, 1, mode="edge")
    n, m = coarse.shape
    around = [padded[i : i + n, j : j + m] for i in range(3) for j in range(3)]
    return np.asarray(np.any([other != coarse for other in around], axis=0))


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
    plane: Plane, raster: Raster, pieces: Indices, clear: Mask, lines: Sequence[FanLine]
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


def _runs(numbers: Indices) -> Iterator[Indices]:
    """Places of each uninterrupted sequence of one number other than 0."""
    edges = np.flatnonzero(np.diff(numbers)) + 1
    for run in np.split(np.arange(len(numbers)), edges):
        if numbers[run[0]]:
            yield run


def agree(plane: Plane, votes: Sequence[Vote]) -> bool:
    """Whether responses across one piece agree.

    A response does not reach every orbit there is. One that lacks what another has does not
    contradict it if the orbit can be continued to its location, and is stable all the way.
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
    """Return the stable orbits of a period at a location, continued from the nearest votes.

    Returns shape (m, n_states).
    """
    size = plane.size
    wanted = max(vote.count(period) for vote in votes)
    having = [vote for vote in votes if vote.count(period) == wanted]
    apart = [float(np.linalg.norm(np.subtract(vote.place, place) / size)) for vote in having]
    near = [having[i] for i in np.argsort(apart, kind="stable")]
    best: list[Array] = []
    for seed in near[: REGIONS.seeds]:
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

    reached = continue_to(Straight(orbits, begin, end), orbits.join(nodes, begin), end[-1], refuse)
    return None if isinstance(reached, Failure) else orbits.nodes(reached.z)


def check_region(
    plane: Plane,
    region: Region,
    orbits: Mapping[int, Sequence[Array]],
    states: Array,
    *,
    may_stick: bool = False,
) -> tuple[RegionCheck, ...]:
    """Simulate well inside a region: from rest, from near each stable orbit, from distant states.

    Shapes: orbits (m, n_states); states (k, n_states).
    """
    at = plane.at(region.place)
    # Where contacts may stick, trajectories from rest are simulated through stick elsewhere.
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
    """Simulate from rest, then from near it: symmetry may keep what is unstable there for ever."""
    for state in (model.start, _near(model, model.start)):
        settled, note = _simulated(model, state)
        # Longer periods and tori are no contradiction: the label speaks of periods 1 and 2.
        agrees = settled not in (1, 2) or settled in region.stable
        check = RegionCheck(region.place, "rest", settled, agrees, note)
        if agrees:
            break
    return check


def _from_orbit(model: Model, region: Region, period: int, state: Array) -> RegionCheck:
    settled, note = _simulated(model, _near(model, state))
    return RegionCheck(region.place, f"period {period}", settled, settled == period, note)


def _simulated(model: Model, state: Array) -> tuple[int, str]:
    """Return the period that a trajectory converges to, 0 if it does not, and a sentence."""
    motion = simulate(
        model, REGIONS.periods, state, tolerance=REGIONS.converged, through_stick=False
    )
    return motion.settlement.period or 0, motion.settlement.message


def _near(model: Model, state: Array) -> Array:
    return np.asarray(state + REGIONS.perturbation * model.state_scales() / np.sqrt(len(state)))
