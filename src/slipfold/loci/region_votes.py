"""What responses that cross a region say of the stable orbits in it, and whether they agree."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.continuation.walk import Failure
from slipfold.errors import InputError
from slipfold.loci.fan import FanLine
from slipfold.loci.into_stick.responses import stable_beside
from slipfold.loci.raster import Raster
from slipfold.loci.stable_spans import is_among, stable_orbits
from slipfold.models.model import Model
from slipfold.orbits.continued import Straight, carry_to
from slipfold.orbits.kinds import ForcedOrbits
from slipfold.orbits.limits import broken_limit
from slipfold.orbits.orbit_curve import OrbitPoint

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
    pieces: NDArray[np.int64],
    clear: NDArray[np.bool_],
    raster: Raster,
    plane: tuple[str, str],
    lines: Sequence[FanLine],
) -> Iterator[Vote]:
    """Ask every response what it says of the pieces it crosses."""
    for line in lines:
        if not (line.branches or line.sticking):
            continue
        axis = plane.index(line.fixed)
        cell = int(raster.columns(np.array([line.value]), axis)[0])
        crossed = pieces[:, cell] if axis == 0 else pieces[cell]
        sure = clear[:, cell] if axis == 0 else clear[cell]
        values = raster.centres(1 - axis)
        for run in _runs(np.where(sure, crossed, 0)):
            value = float(values[run[len(run) // 2]])
            place = (line.value, value) if axis == 0 else (value, line.value)
            sticking = tuple(stable_beside(line, value))
            found = stable_orbits(line.branches, value)
            yield Vote(int(crossed[run[0]]), place, found, sticking)


def _runs(numbers: NDArray[np.int64]) -> Iterator[NDArray[np.int64]]:
    """Places of each uninterrupted sequence of one number other than 0."""
    edges = np.flatnonzero(np.diff(numbers)) + 1
    for run in np.split(np.arange(len(numbers)), edges):
        if numbers[run[0]]:
            yield run


def agree(model: Model, plane: tuple[str, str], raster: Raster, votes: Sequence[Vote]) -> bool:
    """Whether responses across one piece agree.

    A response does not reach every orbit there is. One that lacks what another has does not
    contradict it if the orbit can be carried to its place, and is stable all the way.
    """
    for period in {period for vote in votes for period in vote.nodes}:
        wanted = max(vote.count(period) for vote in votes)
        for vote in votes:
            if vote.count(period) == wanted:
                continue
            if len(carried_orbits(model, plane, raster, votes, vote.place, period)) != wanted:
                return False
    return True


def carried_orbits(
    model: Model,
    plane: tuple[str, str],
    raster: Raster,
    votes: Sequence[Vote],
    place: tuple[float, float],
    period: int,
) -> list[Array]:
    """Return the stable orbits of a period at a place, carried there from the nearest votes.

    Returns shape (m, n_states).
    """
    size = np.array([high - low for low, high in raster.window])
    wanted = max(vote.count(period) for vote in votes)
    having = [vote for vote in votes if vote.count(period) == wanted]
    near = sorted(having, key=lambda vote: _distance(vote.place, place, size))
    best: list[Array] = []
    for seed in near[:SEEDS]:
        found: list[Array] = []
        # The parameter that changes most says where on the way an orbit is.
        order = np.argsort(np.abs(np.array(place) - seed.place) / size)
        names = [plane[i] for i in order]
        begin, end = np.array(seed.place)[order], np.array(place)[order]
        for start in seed.nodes.get(period, ()):
            nodes = _carried(model, names, start, begin, end, size[order], period)
            if nodes is not None and not is_among(model, nodes, period, found):
                found.append(nodes)
        best = max(best, found, key=len)
        if len(best) == wanted:
            break
    return best


def _distance(a: tuple[float, float], b: tuple[float, float], size: Array) -> float:
    return float(np.linalg.norm((np.array(a) - b) / size))


def _carried(
    model: Model,
    names: Sequence[str],
    nodes: Array,
    begin: Array,
    end: Array,
    size: Array,
    period: int,
) -> Array | None:
    """Follow a stable orbit on the straight way from one place to another, the second named most.

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

    reached = carry_to(Straight(orbits, begin, end), orbits.pack(nodes, begin), end[-1], refuse)
    return None if isinstance(reached, Failure) else orbits.nodes(reached.z)
