"""What responses that cross a region say of the stable orbits in it, and whether they agree."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.continuation.newton import correct
from slipfold.errors import InputError
from slipfold.loci.fan import FanLine
from slipfold.loci.raster import Raster
from slipfold.loci.stable_spans import orbit_on, stable_spans
from slipfold.models.model import Model
from slipfold.orbits.find import hold_parameter
from slipfold.orbits.forced_orbits import ForcedOrbits
from slipfold.orbits.limits import broken_limit

__all__ = ["Vote", "agree", "carried_orbits", "collect_votes"]

Array = NDArray[np.float64]

STEPS = 8
"""Steps in which an orbit is carried from one place to another, and halvings of a step."""

SEEDS = 3
"""Orbits tried, the nearest first, where one is to be carried to a place."""

SAME = 1e-4
"""Two stable orbits this close in scaled states are one."""

REACH = 0.5
"""An orbit this far from the one before, in scaled states, may be another."""


@dataclass(frozen=True, eq=False)
class Vote:
    """One response crossing one piece of the plane.

    Parameters
    ----------
    piece
        Number of the piece.
    place
        Values of the two parameters in the middle of the crossing.
    nodes
        Stable orbits at the place by their period, each of shape (m, n_states).
    """

    piece: int
    place: tuple[float, float]
    nodes: dict[int, list[Array]]

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
        if not line.branches:
            continue
        axis = plane.index(line.fixed)
        cell = int(raster.columns(np.array([line.value]), axis)[0])
        crossed = pieces[:, cell] if axis == 0 else pieces[cell]
        sure = clear[:, cell] if axis == 0 else clear[cell]
        values = raster.centres(1 - axis)
        for run in _runs(np.where(sure, crossed, 0)):
            value = float(values[run[len(run) // 2]])
            place = (line.value, value) if axis == 0 else (value, line.value)
            yield Vote(int(crossed[run[0]]), place, _stable_orbits(line, value))


def _runs(numbers: NDArray[np.int64]) -> Iterator[NDArray[np.int64]]:
    """Places of each uninterrupted sequence of one number other than 0."""
    edges = np.flatnonzero(np.diff(numbers)) + 1
    for run in np.split(np.arange(len(numbers)), edges):
        if numbers[run[0]]:
            yield run


def _stable_orbits(line: FanLine, value: float) -> dict[int, list[Array]]:
    found: dict[int, list[Array]] = {}
    for branch in line.branches:
        scales = branch.model.state_scales()
        for span in stable_spans(branch):
            if span.low <= value <= span.high:
                nodes = orbit_on(branch, span, value)
                known = found.setdefault(branch.period, [])
                if nodes is not None and not _is_among(nodes, known, branch.period, scales):
                    known.append(nodes)
    return {period: orbits for period, orbits in found.items() if orbits}


def _is_among(nodes: Array, known: Sequence[Array], period: int, scales: Array) -> bool:
    """Whether an orbit is one of others, begun in whichever forcing period."""
    each, rest = divmod(len(nodes), period)
    turns = [np.roll(nodes, turn * each, axis=0) for turn in range(period if rest == 0 else 1)]
    return any(np.abs((turn - other) / scales).max() < SAME for turn in turns for other in known)


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
        for start in seed.nodes.get(period, ()):
            nodes = _carried(model, plane, start, seed.place, place, period)
            scales = model.state_scales()
            if nodes is not None and not _is_among(nodes, found, period, scales):
                found.append(nodes)
        best = max(best, found, key=len)
        if len(best) == wanted:
            break
    return best


def _distance(a: tuple[float, float], b: tuple[float, float], size: Array) -> float:
    return float(np.linalg.norm((np.array(a) - b) / size))


def _carried(
    model: Model,
    plane: tuple[str, str],
    nodes: Array,
    origin: tuple[float, float],
    place: tuple[float, float],
    period: int,
) -> Array | None:
    """Follow a stable orbit on the straight way from one place to another."""
    start, end = np.array(origin), np.array(place)
    share, step = 0.0, 1.0 / STEPS
    while share < 1:
        trial = min(share + step, 1.0)
        at = start + trial * (end - start)
        try:
            there = model.replace(**dict(zip(plane, map(float, at), strict=True)))
        except InputError:  # on the way lies no model
            return None
        problem = ForcedOrbits(there, {plane[0]: 1.0}, period, len(nodes))
        guess = problem.unknown(nodes, there)
        correction = correct(problem, guess, hold_parameter(problem.size), reach=REACH)
        if correction.converged and correction.linearisation is not None:
            multipliers = np.linalg.eigvals(correction.linearisation.monodromy)
            if np.abs(multipliers).max() > 1 or broken_limit(problem, correction.z) is not None:
                return None
            nodes, share = problem.nodes(correction.z), trial
        else:
            step /= 2
            if step < 2.0**-STEPS:
                return None
    return nodes
