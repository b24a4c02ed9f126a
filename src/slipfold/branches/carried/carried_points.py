"""The special points of a carried branch: the same as before, located anew all at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from slipfold.arrays import Array
from slipfold.branches.abreast.located import Approached, approach
from slipfold.branches.abreast.walk import Bracket
from slipfold.branches.carried.carried_curve import CarriedCurve
from slipfold.branches.special_point import SpecialPoint
from slipfold.continuation.interpolation import polynomial
from slipfold.normal_forms.normal_form import normal_form
from slipfold.orbits.orbit_batch import OrbitBatch

NARROW = 1e-6
"""Distance to which special points are located, over the length of the branch: secants reach it in
one step more than what a drawing shows."""

DISTINCT = 1e-3
"""Least distance of two special points, over the length of the branch."""

TESTS = {"PD": "PD", "NS": "NS", "LP": "LP"}
"""The test function of each type of special point that can be carried."""

CHANGES = {"PD": 1, "NS": 2, "LP": 1}
"""Multipliers that cross the unit circle there."""


@dataclass(frozen=True, eq=False)
class CarriedPoints:
    """The special points of a carried branch."""

    located: Sequence[Approached]  # where they are
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
    forms = _normal_forms(curve, special, [item.z for item in located])
    return None if forms is None else CarriedPoints(located, forms)


def _normal_forms(
    curve: CarriedCurve, special: Sequence[SpecialPoint], z: Sequence[Array]
) -> list[tuple[float, str | None]] | None:
    """Return coefficients and criticality; None where a doubled branch has one fold more or less.

    That is so where the period doubling it is born from turns from soft to hard, or back.
    """
    forms = []
    for item, orbit in zip(special, z, strict=True):
        monodromy = curve.orbits.linearise(orbit).monodromy
        known = orbit, np.zeros_like(orbit), item.arclength, monodromy, np.nan
        point = curve.orbits.derived_point(*known)
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


def _locate(curve: CarriedCurve, brackets: list[tuple[str, int]]) -> list[Approached] | None:
    """Locate all special points at once; None where one is lost, or taken for its neighbour."""
    s = curve.arclength
    items = [
        Bracket(
            0,
            0,
            type_,
            curve.z[i : i + 2],
            curve.tangents[i : i + 2],
            s[i : i + 2],
            curve.tests[TESTS[type_]][i : i + 2],
            (int(curve.unstable[i]), int(curve.unstable[i + 1])),
        )
        for type_, i in brackets
    ]
    length = float(s[-1])
    found = approach(OrbitBatch.of_branch(curve.orbits), items, near=NARROW * length)
    located = [item for item in found if item is not None]
    apart = np.diff([item.arclength for item in located])
    return None if len(located) < len(found) or (apart < DISTINCT * length).any() else located
