"""Thresholds of many sets of parameters from guesses, each proved or left open."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array, Mask
from slipfold.flow.strobes.linearised_steps import linearised_steps_of
from slipfold.models.model import Model
from slipfold.orbits.orbit_batch import Corrected, OrbitBatch
from slipfold.thresholds.batched_orbits import ROUGHLY, find_doublings, find_orbits
from slipfold.thresholds.stable_segment import SHARES, Segments, find_doubts, shortened

ANOTHER_BRANCH = 0.1
"""An orbit this far from its guess, in scaled states and spans, may belong to another branch."""

ON_THE_WAY = 1e-5
"""Orbits on the way are corrected until the correction is shorter than this; the last one then has
left an error of its square."""


@dataclass(frozen=True, eq=False)
class Found:
    """What was found from guesses, one row each."""

    # Whether a response is proved to lose its stability by period doubling, or to keep it to the
    # end of the span, shape (m,). Where neither holds, nothing else means anything.
    loses: Mask
    lasts: Mask
    segments: Segments  # the stable part of each response
    multipliers: NDArray[np.complex128]  # Floquet multipliers at its end, shape (m, n)
    residuals: Array  # how far the orbit there fails to close, in scaled states, shape (m,)


def nothing_found(states: int) -> Found:
    """Return what is found of no response at all."""
    none = np.empty(0, dtype=bool)
    segments = Segments(np.empty(0), np.empty((0, len(SHARES), states)))
    return Found(none, none, segments, np.empty((0, states), dtype=complex), np.empty(0))


@dataclass(frozen=True, eq=False)
class _Ends:
    """Orbits at which the stable parts of responses end."""

    multipliers: NDArray[np.complex128]  # shape (m, n)
    clear: Mask  # whether each stays far from all limits, as far as was looked, shape (m,)
    # Length of the last correction, shape (m,); none where they are period doublings
    moved: Array | None = None


class BatchedThresholds:
    """Finds thresholds of one parameter, from guesses for many sets of the others."""

    def __init__(self, model: Model, vary: str, span: tuple[float, float]) -> None:
        self.model = model
        self.first, self.last = span
        self._vary = vary, abs(self.last - self.first)
        self._steps = linearised_steps_of(model)
        self._bounds = np.array([limit.bound for limit in model.limits])

    def orbits(self, parameters: Array, scales: Array) -> OrbitBatch:
        """Return the orbits of period 1 with these parameters, unknown at phase zero alone.

        Shapes: parameters (m, n_p); scales (m, n).
        """
        return OrbitBatch(self.model, parameters, scales, self._vary, nodes=1, steps=self._steps)

    def doublings(self, parameters: Array, scales: Array, guess: Segments) -> Found:
        """Find first period doublings, or that they lie beyond the span.

        Shapes: parameters (m, n_p); scales (m, n).
        """
        width = self.last - self.first
        orbits = self.orbits(parameters, scales)
        found = find_doublings(orbits, guess.paths[:, -1], guess.ends)
        far = np.linalg.norm((found.states - guess.paths[:, -1]) / scales, axis=1)
        with np.errstate(invalid="ignore"):
            near = (far < ANOTHER_BRANCH) & (
                np.abs(found.values - guess.ends) < ANOTHER_BRANCH * abs(width)
            )
            share = (found.values - self.first) / width
            solved = (found.failures == "") & near & (share > 0)
            inside, beyond = solved & (share <= 1), solved & (share > 1)
        paths = np.concatenate([guess.paths[:, :-1], found.states[:, None]], axis=1)
        loses = inside.copy()
        if inside.any():
            some = Segments(found.values, paths).of(inside)
            there = _Ends(found.multipliers[inside], found.clear[inside])
            loses[inside], paths[inside] = self._prove(
                parameters[inside], scales[inside], some, there
            )
        result = Found(
            loses,
            np.zeros_like(loses),
            Segments(found.values, paths),
            found.multipliers,
            found.residuals,
        )
        if beyond.any():
            shorter = shortened(guess.paths[beyond], 1 / share[beyond])
            ends = np.full(len(shorter), self.last)
            rest = self.lasting(parameters[beyond], scales[beyond], Segments(ends, shorter))
            _insert(result, beyond, rest)
        return result

    def lasting(self, parameters: Array, scales: Array, guess: Segments) -> Found:
        """Find out whether responses are stable to the end of the span.

        Shapes: parameters (m, n_p); scales (m, n).
        """
        orbits = self.orbits(parameters, scales)
        found = find_orbits(orbits, guess.paths[:, -1], guess.ends, ON_THE_WAY)
        everything = np.arange(len(parameters))
        last = orbits.states(everything, found.z)
        paths = np.concatenate([guess.paths[:, :-1], last], axis=1)
        ends = _Ends(found.multipliers, self._clear(found), np.maximum(found.moved, ROUGHLY))
        lasts, paths = self._prove(parameters, scales, Segments(guess.ends, paths), ends)
        return Found(
            np.zeros_like(lasts),
            lasts,
            Segments(guess.ends, paths),
            found.multipliers,
            orbits.residuals(everything, found.z),
        )

    def _clear(self, found: Corrected) -> Mask:
        return found.found & found.seen.clear(self._bounds)

    def walk(self, parameters: Array, scales: Array, guess: Segments) -> tuple[Array, Corrected]:
        """Correct the orbits on the way to known ends; return paths, and the orbits by share.

        Orbits at the same share lie side by side: lanes of the flow take about as many steps each.

        Shapes: parameters (m, n_p); scales (m, n); returns paths (m, len(SHARES), n).
        """
        n = guess.paths.shape[2]
        shares = np.array(SHARES[:-1])
        values = self.first + np.multiply.outer(shares, guess.ends - self.first)
        repeated = np.tile(parameters, (len(shares), 1))
        scale = np.tile(scales, (len(shares), 1))
        guessed = guess.paths[:, :-1].swapaxes(0, 1).reshape(-1, n)
        orbits = self.orbits(repeated, scale)
        found = find_orbits(orbits, guessed, values.ravel(), ON_THE_WAY)
        states = orbits.states(np.arange(len(scale)), found.z)[:, 0]
        far = np.linalg.norm((states - guessed) / scale, axis=1)
        with np.errstate(invalid="ignore"):
            states[~(far < ANOTHER_BRANCH)] = np.nan
        on_the_way = _by_response(states, len(shares))
        return np.concatenate([on_the_way, guess.paths[:, -1:]], axis=1), found

    def _prove(
        self, parameters: Array, scales: Array, segments: Segments, ends: _Ends
    ) -> tuple[Mask, Array]:
        """Return whether responses are stable on the way, and the states there."""
        paths, found = self.walk(parameters, scales, segments)
        before = paths.shape[1] - 1
        multipliers = np.concatenate(
            [_by_response(found.multipliers, before), ends.multipliers[:, None]], axis=1
        )
        doubling = ends.moved is None
        ends_moved = np.zeros(len(parameters)) if ends.moved is None else ends.moved
        moved = np.maximum(_by_response(found.moved, before), ROUGHLY)
        moved = np.column_stack([moved, ends_moved])
        moved[~np.isfinite(paths).all(axis=2)] = np.inf
        proved = find_doubts(multipliers, moved, doubling) == ""
        near = ~np.column_stack([_by_response(self._clear(found), before), ends.clear])
        case, place = np.nonzero(near & proved[:, None])
        values = self.first + np.array(SHARES)[place] * (segments.ends[case] - self.first)
        orbits = self.orbits(parameters, scales)
        margins = orbits.margins(case, orbits.join(case, paths[case, place][:, None], values))
        proved[case[~(margins > 0).all(axis=1)]] = False
        return proved, paths


def _by_response(rows: NDArray[Any], count: int) -> NDArray[Any]:
    """Put what is known of all responses at one share after the other into a row for each.

    Shapes: rows (count * m, ...); returns (m, count, ...).
    """
    return rows.reshape(count, -1, *rows.shape[1:]).swapaxes(0, 1)


def _insert(whole: Found, some: Mask, part: Found) -> None:
    """Put rows into a result that is being made."""
    whole.loses[some], whole.lasts[some] = part.loses, part.lasts
    whole.segments.ends[some], whole.segments.paths[some] = part.segments.ends, part.segments.paths
    whole.multipliers[some], whole.residuals[some] = part.multipliers, part.residuals
