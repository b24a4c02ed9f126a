"""Zeros of test functions on many branches: approached side by side, found by the flow itself."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.abreast.walk import Bracket
from slipfold.continuation.interpolation import hermite_each
from slipfold.continuation.locate import CLOSE, Enclosed
from slipfold.continuation.newton import correct
from slipfold.orbits.orbit_batch import TESTS, Corrected, OrbitBatch
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["EXACT", "SECANTS", "Approached", "approach", "placed"]

Array = NDArray[np.float64]

NEAR = 1e-7
"""Distance from a zero at which the flow itself takes over: its steps are secants, too."""

ROUNDS = 12

EXACT = 1e-6
"""Corrections shorter than this are the last here: tests are then those of the orbit."""

SECANTS = 4
"""Steps of the flow itself to a zero, of which one or two are needed."""


@dataclass(frozen=True, eq=False)
class Approached:
    """A zero as it is known so far."""

    bracket: Bracket
    z: Array  # shape (u,)
    tangent: Array  # shape (u,)
    multipliers: NDArray[np.complex128]  # shape (n,)
    blocks: Array  # transition matrices in scaled states, shape (m, n, n)
    slope: float  # of the test function along the branch
    arclength: float


def approach(
    orbits: OrbitBatch,
    brackets: Sequence[Bracket],
    function: Callable[[Sequence[Bracket], Corrected], Array] | None = None,
    near: float = NEAR,
) -> list[Approached | None]:
    """Close in on the zeros within brackets, along their chords; None where that fails.

    Of the test functions, if no other function is given: shapes (k,).
    """
    function = function or _tests
    found: list[Approached | None] = [None] * len(brackets)
    if not brackets:
        return found
    z = np.array([item.z for item in brackets])
    cases = np.array([item.case for item in brackets])
    chord = z[:, 1] - z[:, 0]
    lengths = np.sqrt((chord * chord).sum(axis=1))
    rows = chord / lengths[:, None]
    slopes = np.array([item.tangents for item in brackets])
    slopes /= (slopes * rows[:, None]).sum(axis=2)[..., None]  # by the place along the chord
    zeros = [
        Enclosed(length, (float(item.values[0]), float(item.values[1])))
        for item, length in zip(brackets, lengths.tolist(), strict=True)
    ]
    going = np.arange(len(brackets))
    for _ in range(ROUNDS):
        if not len(going):
            break
        places = np.array([zeros[i].next_place() for i in going])
        where = np.column_stack([np.zeros(len(going)), lengths[going]])
        guess, _ = hermite_each(where, z[going], slopes[going], places)
        off = places - ((guess - z[going, 0]) * rows[going]).sum(axis=1)
        guess += off[:, None] * rows[going]
        item = orbits.correct(cases[going], guess, rows[going], EXACT, np.inf)
        values = function([brackets[i] for i in going.tolist()], item)
        left = []
        for row, i in enumerate(going.tolist()):
            if not np.isfinite(values[row]) or not item.tangents[row] @ rows[i] > 0:
                continue
            at, value = float(places[row]), float(values[row])
            if zeros[i].error(at, value) > near < zeros[i].width:
                zeros[i].add(at, value)
                left.append(i)
                continue
            # Along the branch, not along its chord.
            slope = zeros[i].slope(at, value) * float(item.tangents[row] @ rows[i])
            found[i] = Approached(
                brackets[i],
                item.z[row],
                item.tangents[row],
                item.multipliers[row],
                item.blocks[row],
                slope,
                float(np.interp(at, (0.0, lengths[i]), brackets[i].places)),
            )
        going = np.array(left, dtype=np.int64)
    return found


def _tests(brackets: Sequence[Bracket], found: Corrected) -> Array:
    kinds = [TESTS.index(item.kind) for item in brackets]
    return np.asarray(found.tests[np.arange(len(brackets)), kinds])


def placed(orbits: Orbits, item: Approached) -> OrbitPoint | None:
    """Return a zero as the flow itself has it; None where it does not come to it."""
    guess, row, slope = item.z, item.tangent, item.slope
    kind, before, expected = item.bracket.kind, np.inf, None
    for _ in range(SECANTS):
        correction = correct(orbits, guess, row, expected=expected)
        if not correction.converged:
            return None
        point = orbits.point(correction, item.arclength)
        value = point.tests[kind]
        if abs(value) <= CLOSE * abs(slope) or abs(value) >= before:  # what is left is rounding
            break
        guess, row = point.z - value / slope * point.tangent, point.tangent
        before, expected = abs(value), correction.linearisation
    return point
