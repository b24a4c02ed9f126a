"""The special points of a carried branch: the same as before, located anew all at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.carried.carried_curve import CarriedCurve, curve_through
from slipfold.branches.special_point import SpecialPoint
from slipfold.continuation.interpolation import polynomial
from slipfold.normal_forms.normal_form import normal_form
from slipfold.orbits.orbit_batch import correct_orbits

__all__ = ["TESTS", "CarriedPoints", "carried_points"]

Array = NDArray[np.float64]

SHARP = 1e-8
"""Correction of orbits at special points that is the last: the test function of a torus varies by
1e-6 over a branch, and follows from derivatives taken before that correction."""

ROUNDS = 6
"""Interpolations that may locate a special point; two are usual."""

ZERO = 1e-3
"""Value of a test function that is zero, over its larger value beside the crossing: a thousandth
of a step, which no drawing shows."""

NARROW = 1e-5
"""Width of an interval that needs no more narrowing, over the length of the branch."""

DISTINCT = 1e-3
"""Least distance of two special points, over the length of the branch."""

TESTS = {"PD": "PD", "NS": "NS", "LP": "LP"}
"""The test function of each type of special point that can be carried."""

CHANGES = {"PD": 1, "NS": 2, "LP": 1}
"""Multipliers that cross the unit circle there."""


@dataclass(frozen=True, eq=False)
class CarriedPoints:
    """The special points of a carried branch."""

    places: Array  # their arclengths, shape (k,)
    z: Array  # their orbits as unknowns, shape (k, ...)
    multipliers: NDArray[np.complex128]  # their multipliers, shape (k, n)
    # Coefficient of the normal form and criticality of each
    forms: Sequence[tuple[float, str | None]]


def carried_points(curve: CarriedCurve, special: Sequence[SpecialPoint]) -> CarriedPoints | None:
    """Locate the special points of a carried branch; None if they are not those it had."""
    brackets = _brackets(curve)
    if [type_ for type_, _ in brackets] != [item.type for item in special] or _may_hide(curve):
        return None
    located = _locate(curve, brackets)
    if located is None:
        return None
    forms = _normal_forms(curve, special, located[1])
    return None if forms is None else CarriedPoints(*located, forms)


def _normal_forms(
    curve: CarriedCurve, special: Sequence[SpecialPoint], z: Array
) -> list[tuple[float, str | None]] | None:
    """Return coefficients and criticality; None where a doubled branch has one fold more or less.

    That is so where the period doubling it is born from turns from soft to hard, or back.
    """
    forms = []
    for item, orbit in zip(special, z, strict=True):
        monodromy = curve.orbits.linearise(orbit).monodromy
        known = orbit, np.zeros_like(orbit), item.arclength, monodromy, np.nan
        point = curve.orbits.known_point(*known)
        try:
            form = normal_form(curve.orbits, point, item.type)
        except np.linalg.LinAlgError:
            return None  # a second multiplier is critical
        if item.type == "PD" and item.leads_to is not None and form[1] != item.criticality:
            return None
        forms.append(form)
    return forms


def _brackets(curve: CarriedCurve) -> list[tuple[str, int]]:
    """Return type and index of each interval in which multipliers cross the unit circle."""
    found = []
    for i, (left, right) in enumerate(pairwise(curve.unstable)):
        for type_, name in TESTS.items():
            test = curve.tests[name]
            crosses = abs(int(right) - int(left)) == CHANGES[type_]
            if crosses and test[i] * test[i + 1] < 0:
                found.append((type_, i))
    return found


def _may_hide(curve: CarriedCurve) -> bool:
    """Whether a test function seems to cross zero and come back between two orbits."""
    s = curve.arclength
    for i in range(len(s) - 1):
        near = slice(min(max(i - 1, 0), len(s) - 4), max(i + 3, 4))
        inner = np.linspace(s[i], s[i + 1], 10)[1:-1]
        for test in curve.tests.values():
            between = polynomial(s[near], test[near], inner)
            if test[i] * test[i + 1] > 0 and (between * test[i] < 0).any():
                return True
    return False


def _locate(
    curve: CarriedCurve, brackets: list[tuple[str, int]]
) -> tuple[Array, Array, NDArray[np.complex128]] | None:
    """Locate all special points at once: places, unknowns and multipliers."""
    s, size = curve.arclength, curve.z.shape[1]
    if not brackets:
        return np.empty(0), np.empty((0, size)), np.empty((0, curve.multipliers.shape[1]), complex)
    known = [_Crossing(curve, s, TESTS[type_], index) for type_, index in brackets]
    rows = np.array([item.direction for item in known])
    for _ in range(ROUNDS):
        places = [item.zero() for item in known]
        guesses = [item.orbit_at(place) for item, place in zip(known, places, strict=True)]
        found = correct_orbits(curve.orbits, np.array(guesses), rows, SHARP)
        if not found.found.all():
            return None
        at = curve_through(curve.orbits, found)
        for i, (item, place) in enumerate(zip(known, places, strict=True)):
            item.add(place, at.z[i], float(at.tests[item.test][i]))
        if all(item.is_found for item in known):
            break
    apart = DISTINCT * float(s[-1])
    if (np.diff(places) < apart).any() or not all(item.is_found for item in known):
        return None  # a neighbour was mistaken for a crossing
    return np.array(places), at.z, at.multipliers


class _Crossing:
    """A zero of a test function between two orbits, ever more narrowly enclosed."""

    def __init__(self, curve: CarriedCurve, s: Array, test: str, index: int) -> None:
        self.test = test
        near = slice(max(index - 1, 0), index + 3)
        self.where, self.orbits = s[near], curve.z[near]
        self.values = curve.tests[test][near]
        chord = curve.z[index + 1] - curve.z[index]
        self.direction = chord / np.linalg.norm(chord)
        self.left = index - near.start
        self.size = float(np.abs(self.values[self.left : self.left + 2]).max())
        self.narrow = NARROW * float(s[-1])
        self.is_found = False

    @property
    def _near(self) -> slice:
        """The four known orbits around the interval."""
        first = min(max(self.left - 1, 0), len(self.where) - 4)
        return slice(max(first, 0), first + 4)

    def zero(self) -> float:
        """Return where the polynomial through the values has its zero in the interval."""
        low, high = self.where[self.left], self.where[self.left + 1]
        fine = np.linspace(low, high, 65)
        values = polynomial(self.where[self._near], self.values[self._near], fine)
        values[[0, -1]] = self.values[[self.left, self.left + 1]]
        i = int(np.flatnonzero(values[:-1] * values[1:] <= 0)[0])
        share = values[i] / (values[i] - values[i + 1])
        return float(fine[i] + share * (fine[i + 1] - fine[i]))

    def orbit_at(self, place: float) -> Array:
        """Return the orbit that the known ones make likely."""
        near = self._near
        return np.asarray(polynomial(self.where[near], self.orbits[near], np.array([place]))[0])

    def add(self, place: float, z: Array, value: float) -> None:
        """Take one more orbit, and the smaller interval with the crossing."""
        low, high = self.where[self.left], self.where[self.left + 1]
        self.is_found = abs(value) < ZERO * self.size or high - low < self.narrow
        if self.is_found:
            return
        after = self.left + 1
        self.where = np.insert(self.where, after, place)
        self.orbits = np.insert(self.orbits, after, z, axis=0)
        self.values = np.insert(self.values, after, value)
        if self.values[self.left] * value > 0:
            self.left = after
