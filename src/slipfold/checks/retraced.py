r"""Motions retraced in short pieces, each held against the equations by quadrature.

Whatever integrated a motion x(t), it must satisfy :math:`x(b) - x(a) = \int_a^b f(x(t), t)\, dt`
on every piece. A step that went over something is seen at the points between its ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from slipfold.arrays import Array, Mask
from slipfold.collocation_points import gauss_points
from slipfold.flow.equations import Constants
from slipfold.flow.flow import Flow
from slipfold.models.turns import NO_TURNS, without_turns

DEGREE = 6
"""Gauss points a piece: the error falls with the 13th power of its length."""

SMALL = 1e-12
"""Defect of a piece, over the size of what it changes, that needs no shorter pieces: what steps
of the flow at its coarsest tolerance may leave."""

SMALL_SLOPES = 1e-10
"""The same of the change of a perturbation: multipliers are compared to 1e-8."""

ABREAST = 160
"""Pieces of a motion that are cut at once, those that come first: enough for what is steep here and
there. Of a motion that is intricate all along a part is held against the equations."""

TRIED = 2000
"""Pieces of a motion that are tried at most, sixty times as many as are enough where nothing is
steep."""

SHORTEST = 1e-12
"""Length of a piece, in forcing periods, that is not cut again: there a force jumps."""

_GAUSS = gauss_points(DEGREE)
_HALVES = np.concatenate([_GAUSS.points / 2, 0.5 + _GAUSS.points / 2])
_FRACTIONS = np.concatenate([[0.0], _GAUSS.points, _HALVES, [0.5, 1.0]])
_ORDER = np.argsort(_FRACTIONS)
_PLACES = np.argsort(_ORDER)
_STAGES = _PLACES[1 : 1 + DEGREE]
_FINE = _PLACES[1 + DEGREE : 1 + 3 * DEGREE]
_MIDDLE = _PLACES[-2]


@dataclass(frozen=True, eq=False)
class Motion:
    """States claimed to lie on one solution; of a periodic one the last is the first."""

    phases: Array  # increasing, shape (m + 1,)
    states: Array  # shape (m + 1, n)
    constants: Constants  # coefficients of the equations
    pieces: int  # pieces to begin with, in each of the m parts
    # Whether the Jacobians must be as well resolved, for what is derived from them
    slopes: bool = False
    # Whole turns of angles by which states may differ from what comes before them, shape (n,)
    turns: Array = field(default_factory=lambda: NO_TURNS)


@dataclass(frozen=True, eq=False)
class Retraced:
    """A motion in pieces, in scaled states."""

    edges: Array  # phases at which the N pieces begin and end, shape (N + 1,)
    nodes: Array  # states at the beginning of each, shape (N, n)
    stages: Array  # states at its Gauss points, shape (N, m, n)
    # What each piece lacks to end where the next begins, by the equations, shape (N, n)
    defects: Array
    # Whether the pieces cover the motion, rather than a part that satisfies the equations
    whole: bool
    tried: int  # number of pieces that were held against the equations
    resolved: bool = True  # whether the pieces are short enough for that

    @property
    def size(self) -> float:
        """Size of the states, one at least: errors of steps are relative to it."""
        return max(1.0, float(np.abs(self.nodes).max()))

    @property
    def drift(self) -> float:
        """Largest sum of the defects of successive pieces from the beginning, over the size."""
        found = float(np.abs(np.cumsum(self.defects, axis=0)).max()) / self.size
        return found if np.isfinite(found) else np.inf


@dataclass(frozen=True, eq=False)
class _Pieces:
    """Pieces of one motion, one a row."""

    begin: Array
    length: Array
    states: Array

    def some(self, chosen: Mask) -> _Pieces:
        return _Pieces(self.begin[chosen], self.length[chosen], self.states[chosen])


@dataclass(frozen=True, eq=False)
class _Held:
    """Pieces held against the equations: states within, the end, what is lacking; scaled."""

    pieces: _Pieces
    stages: Array
    middles: Array
    ends: Array
    lacking: Array
    resolved: Mask

    def some(self, chosen: Mask) -> _Held:
        return _Held(
            self.pieces.some(chosen),
            self.stages[chosen],
            self.middles[chosen],
            self.ends[chosen],
            self.lacking[chosen],
            self.resolved[chosen],
        )

    def halves(self) -> _Pieces:
        """Cut each in two, in their order."""
        half = self.pieces.length / 2
        begin = np.stack([self.pieces.begin, self.pieces.begin + half], axis=1)
        states = np.stack([self.pieces.states, self.middles], axis=1)
        return _Pieces(begin.ravel(), np.repeat(half, 2), states.reshape(-1, states.shape[2]))


def retrace(flow: Flow, scales: Array, motion: Motion) -> Retraced:
    """Cut a motion into pieces until each satisfies the equations.

    If that does not come to an end, they are the pieces it began with.
    """
    first = held = _held(flow, scales, motion, _first_pieces(flow, motion))
    done, end, tried = list[_Held](), float(motion.phases[-1]), len(first.ends)
    while True:
        done.append(held.some(held.resolved))
        waiting = held.some(~held.resolved)
        if not len(waiting.ends):
            return _joined(done, motion, scales, end, tried)
        if tried > TRIED or not np.isfinite(waiting.lacking).all():
            found = _joined([first], motion, scales, float(motion.phases[-1]), tried)
            return replace(found, resolved=False)
        if len(waiting.ends) > ABREAST:
            end = float(waiting.pieces.begin[ABREAST])
            waiting = waiting.some(np.arange(len(waiting.ends)) < ABREAST)
        held = _held(flow, scales, motion, waiting.halves())
        tried += len(held.ends)


def _first_pieces(flow: Flow, motion: Motion) -> _Pieces:
    """Cut the parts of a motion into equal pieces."""
    count, phases = motion.pieces, motion.phases
    states = flow.sample(motion.states[:-1], phases[:-1], phases[1:], count, motion.constants)
    lengths = np.diff(phases) / count
    begin = phases[:-1, None] + lengths[:, None] * np.arange(count)
    return _Pieces(begin.ravel(), np.repeat(lengths, count), states.reshape(begin.size, -1))


def _held(flow: Flow, scales: Array, motion: Motion, pieces: _Pieces) -> _Held:
    """Carry each piece to its end, and compare its change with the integral of the rates."""
    phases = pieces.begin[:, None] + pieces.length[:, None] * _FRACTIONS[_ORDER]
    states = flow.along(pieces.states, phases, motion.constants)
    rates = flow.rates(states.reshape(phases.size, -1), phases.ravel(), motion.constants)
    rates = rates.reshape(states.shape) / scales * pieces.length[:, None, None]
    states = states / scales
    change = states[:, -1] - states[:, 0]
    weights = _GAUSS.weights
    coarse = change - np.einsum("k,ikn->in", weights, rates[:, _STAGES])
    lacking = change - np.einsum("k,ikn->in", np.tile(weights / 2, 2), rates[:, _FINE])
    size = 1.0 + np.abs(states).max(axis=(1, 2)) + np.abs(rates).max(axis=(1, 2))
    worst = np.maximum(np.abs(coarse), np.abs(lacking)).max(axis=1)
    resolved = worst <= SMALL * size  # not where it is not a number
    if motion.slopes:
        resolved &= _slopes_resolved(flow, scales, motion, pieces, phases, states)
    resolved |= (pieces.length < SHORTEST) & np.isfinite(worst)
    middles = states[:, _MIDDLE] * scales
    return _Held(pieces, states[:, _STAGES], middles, states[:, -1], lacking, resolved)


def _slopes_resolved(
    flow: Flow, scales: Array, motion: Motion, pieces: _Pieces, phases: Array, states: Array
) -> Mask:
    """Whether the integral of the Jacobian is the same by half as many points."""
    chosen = np.concatenate([_STAGES, _FINE])
    n = len(scales)
    at, when = (states[:, chosen] * scales).reshape(-1, n), phases[:, chosen].ravel()
    slopes = flow.jacobians(at, when, motion.constants) * (scales / scales[:, None])
    slopes = slopes.reshape(len(states), len(chosen), n * n) * pieces.length[:, None, None]
    weights = np.concatenate([_GAUSS.weights, np.tile(-_GAUSS.weights / 2, 2)])
    change = np.abs(np.einsum("k,ikn->in", weights, slopes)).max(axis=1)
    return np.asarray(change <= SMALL_SLOPES * (1.0 + np.abs(slopes).max(axis=(1, 2))))


def _joined(
    done: Sequence[_Held], motion: Motion, scales: Array, end: float, tried: int
) -> Retraced:
    """Put the pieces up to an end in their order."""
    begin = np.concatenate([item.pieces.begin for item in done])
    order = np.argsort(begin, kind="stable")
    order = order[begin[order] < end]
    nodes = np.concatenate([item.pieces.states for item in done])[order] / scales
    ends = np.concatenate([item.ends for item in done])[order]
    lacking = np.concatenate([item.lacking for item in done])[order]
    whole = end == motion.phases[-1]
    last = motion.states[-1:] / scales if whole else ends[-1:]
    return Retraced(
        np.append(begin[order], end),
        nodes,
        np.concatenate([item.stages for item in done])[order],
        lacking + without_turns(np.concatenate([nodes[1:], last]) - ends, motion.turns / scales),
        whole,
        tried,
    )
