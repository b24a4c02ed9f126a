"""Zeros of test functions on many branches: approached side by side, found by the flow itself."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.branches.abreast.walk import Bracket
from slipfold.continuation.interpolation import hermite_each
from slipfold.continuation.locate import Enclosed
from slipfold.continuation.newton import EXACT as SOLVED
from slipfold.orbits.orbit_batch import EXACTLY, TESTS, Corrected, OrbitBatch, Settled
from slipfold.orbits.test_functions import evaluate_each, floquet_multipliers

NEAR = 1e-7
"""Distance from a zero at which the flow itself takes over: its steps are secants, too."""

ROUNDS = 12

EXACT = 1e-6
"""Corrections shorter than this are the last here: tests are then those of the orbit."""

SECANTS = 4
"""Steps of the flow itself to a zero, of which one or two are needed."""

CONTRACTS = 0.5
"""What may be left of a function after a step that tells its slope: more may be rounding."""


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

    @property
    def case(self) -> int:
        """Number of the case whose branch it is on."""
        return self.bracket.case


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


def settled_zeros(
    orbits: OrbitBatch,
    items: Sequence[Approached],
    function: Callable[[Sequence[Approached], Settled], Array],
    close: float,
    tolerance: float,
) -> list[tuple[Settled, float] | None]:
    """Return zeros by the flow itself, each with what is left there; None where that fails.

    The steps are secants along the branch, which end within an arclength `close` of the zero; what
    is left after the last of them is rounding.
    """
    found: list[tuple[Settled, float] | None] = [None] * len(items)
    cases, slopes = (
        np.array([getattr(item, name) for item in items]) for name in ("case", "slope")
    )
    z, rows = (np.array([getattr(item, name) for item in items]) for name in ("z", "tangent"))
    going, before = np.arange(len(items)), np.full(len(items), np.nan)
    for last in range(SECANTS):
        if not len(going):
            break
        own = cases[going]
        now = orbits.correct(own, z[going], rows[going], SOLVED, np.inf, EXACTLY)
        missed = orbits.residuals(own, now.z)
        here = Settled(now.z, now.tangents, now.monodromies, missed)
        left = function([items[i] for i in going.tolist()], here)
        fails = ~(np.isfinite(left) & (here.residuals <= tolerance))
        ratio = left / before[going]
        slopes[going] *= np.where(np.abs(ratio) < CONTRACTS, 1 - ratio, 1.0)  # of the last step
        before[going] = left
        done = (np.abs(left) <= close * np.abs(slopes[going])) | (last == SECANTS - 1)
        for row in np.flatnonzero(done & ~fails).tolist():
            found[going[row]] = here.of(slice(row, row + 1)), float(left[row])
        more = np.flatnonzero(~done & ~fails)
        going = going[more]
        rows[going] = here.tangents[more]
        steps = left[more] / slopes[going]
        z[going] = here.z[more] - steps[:, None] * here.tangents[more]
    return found


def tests_of(items: Sequence[Approached], found: Settled) -> Array:
    """Return the test functions whose zeros are special points, shape (k,)."""
    tests = np.full((len(items), len(TESTS)), np.nan)
    known = np.isfinite(found.monodromies).all(axis=(1, 2))
    multipliers = floquet_multipliers(found.monodromies[known])
    tests[known, :-1], tests[known, -1] = (
        evaluate_each(multipliers, TESTS[:-1]),
        found.tangents[known, -1],
    )
    kinds = [TESTS.index(item.bracket.kind) for item in items]
    return np.asarray(tests[np.arange(len(items)), kinds])
