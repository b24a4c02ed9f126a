r"""Trajectories retraced in short pieces, each compared with the equations by quadrature.

A trajectory x(t) must satisfy :math:`x(b) - x(a) = \int_a^b f(x(t), t)\, dt` on every piece,
whatever integrated it. A step that went over something is seen at the points between its ends.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from slipfold.arrays import Array, Mask
from slipfold.collocation_points import gauss_points
from slipfold.flow.equations import Constants
from slipfold.flow.flow import Flow
from slipfold.models.angles import NO_ANGLES, wrap_angles
from slipfold.results.checks.checked import CHECKS

_GAUSS = gauss_points(CHECKS.degree)
_HALVES = np.concatenate([_GAUSS.points / 2, 0.5 + _GAUSS.points / 2])
_FRACTIONS = np.concatenate([[0.0], _GAUSS.points, _HALVES, [0.5, 1.0]])
_ORDER = np.argsort(_FRACTIONS)
_PLACES = np.argsort(_ORDER)
_STAGES = _PLACES[1 : 1 + CHECKS.degree]
_FINE = _PLACES[1 + CHECKS.degree : 1 + 3 * CHECKS.degree]
_MIDDLE = _PLACES[-2]


@dataclass(frozen=True, eq=False)
class SampledSolution:
    """States that should lie on one solution; of a periodic one the last is the first."""

    phases: Array  # increasing, shape (m + 1,)
    states: Array  # shape (m + 1, n)
    constants: Constants  # coefficients of the equations
    pieces: int  # initial number of pieces in each of the m parts
    # Whether the Jacobians must be as well resolved, for what is derived from them
    slopes: bool = False
    # Revolutions of angles by which states may differ from what comes before them, shape (n,)
    angle_periods: Array = field(default_factory=lambda: NO_ANGLES)


@dataclass(frozen=True, eq=False)
class Retraced:
    """A trajectory in pieces, in scaled states."""

    edges: Array  # phases at which the N pieces begin and end, shape (N + 1,)
    nodes: Array  # states at the beginning of each, shape (N, n)
    stages: Array  # states at its Gauss points, shape (N, m, n)
    # Distance between the end of each piece by the equations and the next node, shape (N, n)
    defects: Array
    # Whether the pieces cover the trajectory, rather than a part that satisfies the equations
    complete: bool
    tried: int  # number of pieces that were compared with the equations
    resolved: bool = True  # whether the pieces are short enough for that

    @property
    def is_finite(self) -> bool:
        """Whether all of its states are numbers."""
        return bool(np.isfinite(self.stages).all())

    @property
    def size(self) -> float:
        """Size of the states, one at least: errors of steps are relative to it."""
        return max(1.0, float(np.abs(self.nodes).max()))

    @property
    def drift(self) -> float:
        """Largest sum of the defects of successive pieces from the beginning, over the size."""
        result = float(np.abs(np.cumsum(self.defects, axis=0)).max()) / self.size
        return result if np.isfinite(result) else np.inf


class _Pieces(NamedTuple):
    """Pieces of trajectories, one a row."""

    begin: Array
    length: Array
    states: Array


class _Compared(NamedTuple):
    """Pieces compared with the equations: scaled states at points within and at the end."""

    begin: Array
    length: Array
    states: Array
    stages: Array
    middles: Array
    ends: Array
    defects: Array
    resolved: Mask

    def rows(self, chosen: Any) -> _Compared:
        parts: Any = (part[chosen] for part in self)
        return _Compared(*parts)

    def halves(self) -> _Pieces:
        """Cut each in two, in their order."""
        half = self.length / 2
        begin = np.stack([self.begin, self.begin + half], axis=1)
        states = np.stack([self.states, self.middles], axis=1)
        return _Pieces(begin.ravel(), np.repeat(half, 2), states.reshape(-1, states.shape[2]))


def retrace(flow: Flow, scales: Array, solutions: Sequence[SampledSolution]) -> list[Retraced]:
    """Cut trajectories into pieces until each satisfies the equations.

    If that does not end, the pieces are the initial ones. Shapes: scales (k, n), or (n,) for all.
    """
    scales = np.broadcast_to(scales, (len(solutions), scales.shape[-1]))
    constants = Constants.stacked([solution.constants for solution in solutions])
    firsts = _first_pieces(flow, solutions, constants)
    searches = [_retracing(*given) for given in zip(solutions, scales, firsts, strict=True)]
    waiting, done = {i: next(search) for i, search in enumerate(searches)}, dict[int, Retraced]()
    slopes = any(solution.slopes for solution in solutions)
    while waiting:
        counts = [len(pieces.begin) for pieces in waiting.values()]
        which = np.repeat(list(waiting), counts)
        pieces = _Pieces(*map(np.concatenate, zip(*waiting.values(), strict=True)))
        compared = _compared(flow, scales[which], constants.rows(which), pieces, slopes)
        for i, last, count in zip(list(waiting), np.cumsum(counts).tolist(), counts, strict=True):
            try:
                waiting[i] = searches[i].send(compared.rows(slice(last - count, last)))
            except StopIteration as end:
                done[i] = end.value
                del waiting[i]
    return [done[i] for i in range(len(solutions))]


def _retracing(
    solution: SampledSolution, scales: Array, pieces: _Pieces
) -> Generator[_Pieces, _Compared, Retraced]:
    """Yield pieces that are to be compared with the equations; return the whole trajectory."""
    first = compared = yield pieces
    done, end, tried = list[_Compared](), float(solution.phases[-1]), len(first.ends)
    while True:
        done.append(compared.rows(compared.resolved))
        waiting = compared.rows(~compared.resolved)
        if not len(waiting.ends):
            return _joined(done, solution, scales, end, tried)
        if tried > CHECKS.max_pieces or not np.isfinite(waiting.defects).all():
            result = _joined([first], solution, scales, float(solution.phases[-1]), tried)
            return replace(result, resolved=False)
        if len(waiting.ends) > CHECKS.batch:
            end = float(waiting.begin[CHECKS.batch])
            waiting = waiting.rows(np.arange(len(waiting.ends)) < CHECKS.batch)
        compared = yield waiting.halves()
        tried += len(compared.ends)


def _first_pieces(
    flow: Flow, solutions: Sequence[SampledSolution], constants: Constants
) -> list[_Pieces]:
    """Cut the parts of trajectories into equal pieces."""
    found: dict[int, _Pieces] = {}
    for count in {solution.pieces for solution in solutions}:
        own = [i for i, solution in enumerate(solutions) if solution.pieces == count]
        given = [solutions[i] for i in own]
        parts = [len(solution.phases) - 1 for solution in given]
        begin, end = (
            np.concatenate([solution.phases[some] for solution in given])
            for some in (slice(None, -1), slice(1, None))
        )
        states = np.concatenate([solution.states[:-1] for solution in given])
        rows = constants.rows(np.repeat(own, parts))
        states = flow.sample(states, begin, end, count, rows)
        lengths = (end - begin) / count
        begin = begin[:, None] + lengths[:, None] * np.arange(count)
        split = (np.split(each, np.cumsum(parts)[:-1]) for each in (begin, lengths, states))
        for i, first, length, along in zip(own, *split, strict=True):
            along = along.reshape(first.size, -1)
            found[i] = _Pieces(first.ravel(), np.repeat(length, count), along)
    return [found[i] for i in range(len(solutions))]


def _compared(
    flow: Flow, scales: Array, constants: Constants, pieces: _Pieces, slopes: bool
) -> _Compared:
    """Integrate each piece to its end, and compare its change with the integral of the rates.

    If `slopes`, their integral is examined as well. Shapes: scales (N, n).
    """
    phases = pieces.begin[:, None] + pieces.length[:, None] * _FRACTIONS[_ORDER]
    states = flow.along(pieces.states, phases, constants)
    each, wide = constants.repeated(phases.shape[1]), scales[:, None]
    rates = flow.rates(states.reshape(phases.size, -1), phases.ravel(), each)
    rates = rates.reshape(states.shape) / wide * pieces.length[:, None, None]
    states = states / wide
    change = states[:, -1] - states[:, 0]
    weights = _GAUSS.weights
    coarse = change - weights @ rates[:, _STAGES]
    defects = change - np.tile(weights / 2, 2) @ rates[:, _FINE]
    size = 1.0 + np.abs(states).max(axis=(1, 2)) + np.abs(rates).max(axis=(1, 2))
    worst = np.maximum(np.abs(coarse), np.abs(defects)).max(axis=1)
    resolved = worst <= CHECKS.rounding * size  # not where it is not a number
    if slopes:
        resolved &= _slopes_resolved(flow, scales, constants, pieces, phases, states)
    resolved |= (pieces.length < CHECKS.rounding) & np.isfinite(worst)
    middles = states[:, _MIDDLE] * scales
    return _Compared(*pieces, states[:, _STAGES], middles, states[:, -1], defects, resolved)


def _slopes_resolved(
    flow: Flow, scales: Array, constants: Constants, pieces: _Pieces, phases: Array, states: Array
) -> Mask:
    """Whether the integral of the Jacobian is the same by half as many points."""
    chosen = np.concatenate([_STAGES, _FINE])
    n = scales.shape[1]
    at, when = (states[:, chosen] * scales[:, None]).reshape(-1, n), phases[:, chosen].ravel()
    slopes = flow.jacobians(at, when, constants.repeated(len(chosen)))
    slopes = slopes.reshape(len(states), len(chosen), n, n)
    slopes *= (scales[:, None, :] / scales[:, :, None] * pieces.length[:, None, None])[:, None]
    slopes = slopes.reshape(len(states), len(chosen), n * n)
    weights = np.concatenate([_GAUSS.weights, np.tile(-_GAUSS.weights / 2, 2)])
    change = np.abs(weights @ slopes).max(axis=1)
    return np.asarray(change <= CHECKS.slopes * (1.0 + np.abs(slopes).max(axis=(1, 2))))


def _joined(
    done: Sequence[_Compared], solution: SampledSolution, scales: Array, end: float, tried: int
) -> Retraced:
    """Put the pieces up to an end in their order."""
    pieces = _Compared(*map(np.concatenate, zip(*done, strict=True)))
    order = np.argsort(pieces.begin, kind="stable")
    pieces = pieces.rows(order[pieces.begin[order] < end])
    nodes, complete = pieces.states / scales, end == solution.phases[-1]
    last = solution.states[-1:] / scales if complete else pieces.ends[-1:]
    apart = np.concatenate([nodes[1:], last]) - pieces.ends
    defects = pieces.defects + wrap_angles(apart, solution.angle_periods / scales)
    return Retraced(np.append(pieces.begin, end), nodes, pieces.stages, defects, complete, tried)
