"""Thresholds of many sets of parameters from guesses, each proved or left open."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.flow import flow_of
from slipfold.flow.scaled import power_of_two
from slipfold.models.model import Model
from slipfold.thresholds.batched_limits import keep_limits
from slipfold.thresholds.batched_orbits import Orbits, find_doublings, find_orbits
from slipfold.thresholds.stable_segment import SHARES, Segments, find_doubts, shortened

__all__ = ["BatchedThresholds", "Found"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

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


class BatchedThresholds:
    """Finds thresholds of one parameter, from guesses for many sets of the others."""

    def __init__(self, model: Model, vary: str, span: tuple[float, float]) -> None:
        self.model = model
        self.flow = flow_of(model)
        self.index = model.parameter_index(vary)
        self.first, self.last = span

    def doublings(self, parameters: Array, scales: Array, guess: Segments) -> Found:
        """Find first period doublings, or that they lie beyond the span.

        Shapes: parameters (m, n_p); scales (m, n).
        """
        width = self.last - self.first
        found = find_doublings(
            self.flow,
            guess.paths[:, -1],
            self._at(parameters, guess.ends),
            self.index,
            scales,
            abs(width),
        )
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
            loses[inside], paths[inside] = self._prove(
                parameters[inside], scales[inside], some, found.multipliers[inside]
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
        at_end = self._at(parameters, guess.ends)
        orbits = find_orbits(self.flow, guess.paths[:, -1], at_end, scales, ON_THE_WAY)
        paths = np.concatenate([guess.paths[:, :-1], orbits.states[:, None]], axis=1)
        lasts, paths = self._prove(
            parameters, scales, Segments(guess.ends, paths), orbits.multipliers, orbits.moved
        )
        return Found(
            np.zeros_like(lasts),
            lasts,
            Segments(guess.ends, paths),
            orbits.multipliers,
            self._residuals(paths[:, -1], at_end, scales),
        )

    def walk(self, parameters: Array, scales: Array, guess: Segments) -> tuple[Array, Orbits]:
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
        orbits = find_orbits(
            self.flow, guessed, self._at(repeated, values.ravel()), scale, ON_THE_WAY
        )
        far = np.linalg.norm((orbits.states - guessed) / scale, axis=1)
        with np.errstate(invalid="ignore"):
            orbits.states[~(far < ANOTHER_BRANCH)] = np.nan
        on_the_way = _by_response(orbits.states, len(shares))
        return np.concatenate([on_the_way, guess.paths[:, -1:]], axis=1), orbits

    def _prove(
        self,
        parameters: Array,
        scales: Array,
        segments: Segments,
        multipliers: NDArray[np.complex128],
        moved: Array | None = None,
    ) -> tuple[Mask, Array]:
        """Return whether responses are stable on the way, and the states there.

        Without `moved`, what the last correction of the ends was, they are period doublings.
        """
        paths, orbits = self.walk(parameters, scales, segments)
        before = paths.shape[1] - 1
        all_multipliers = np.concatenate(
            [_by_response(orbits.multipliers, before), multipliers[:, None]], axis=1
        )
        doubling = moved is None
        ends_moved = np.zeros(len(parameters)) if moved is None else moved
        all_moved = np.column_stack([_by_response(orbits.moved, before), ends_moved])
        all_moved[~np.isfinite(paths).all(axis=2)] = np.inf
        proved = find_doubts(all_multipliers, all_moved, doubling) == ""
        if proved.any():
            proved[proved] = self._keep_limits(
                parameters[proved], segments.ends[proved], paths[proved]
            )
        return proved, paths

    def _keep_limits(self, parameters: Array, ends: Array, paths: Array) -> Mask:
        m, count, n = paths.shape
        values = self.first + np.multiply.outer(np.array(SHARES), ends - self.first)
        repeated = self._at(np.tile(parameters, (count, 1)), values.ravel())
        states = paths.swapaxes(0, 1).reshape(-1, n)
        kept = keep_limits(self.flow, self.model, states, repeated)
        return np.asarray(kept.reshape(count, m).all(axis=0), dtype=bool)

    def _at(self, parameters: Array, values: Array) -> Array:
        moved = parameters.copy()
        moved[:, self.index] = values
        return moved

    def _residuals(self, states: Array, parameters: Array, scales: Array) -> Array:
        zero = np.zeros(len(states))
        constants = self.flow.constants(parameters, power_of_two(scales))
        ends = self.flow.advance(states, zero, zero + 1, constants)
        return np.abs((ends - states) / scales).max(axis=1)


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
