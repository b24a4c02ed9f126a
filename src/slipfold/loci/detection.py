"""Points of codimension two on a locus, and its extrema."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.detection import ON_CIRCLE, is_torus
from slipfold.continuation.contraction import contracts_between
from slipfold.continuation.end import End
from slipfold.continuation.monitor import Zeros
from slipfold.continuation.search import Found
from slipfold.continuation.trail import Sight, Stop, Stretch
from slipfold.loci.locus_problem import LocusProblem, critical_places
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["SpecialPoints"]

STANDING = 1e-6
"""A tangent whose components along both parameters are below this belongs to a cusp."""

PARALLEL = 1e-9
"""A locus whose tangent stays below this along a parameter is parallel to the other's axis."""

DOUBLE = 1e-3
"""Distance of a second critical multiplier at R1 and R2: a double one parts as a square root."""

SAME = 1e-7
"""Arclength within which two extrema found are one cusp."""


class SpecialPoints(Zeros[OrbitPoint]):
    """Records what is special along a locus, and ends one of tori at a strong resonance.

    Types are ``CPC GPD CH R1 R2 R3 R4 LPPD LPNS PDNS NSNS`` and, for extrema, ``first`` and
    ``second`` for the parameter that stands still.
    """

    def __init__(self, problem: LocusProblem) -> None:
        super().__init__(problem)
        self._problem = problem

    def watch(self, stretch: Stretch[OrbitPoint]) -> Sight[OrbitPoint]:
        """Return what is special between two points; the first step from another locus is not."""
        return Sight() if stretch.leaves else super().watch(stretch)

    def excludes(self, a: OrbitPoint, b: OrbitPoint) -> bool:
        """Whether nothing can be found between two points."""
        return contracts_between(a, b)

    def seen(
        self, found: Sequence[Found[OrbitPoint]], stretch: Stretch[OrbitPoint]
    ) -> Sight[OrbitPoint]:
        """Record the points; a pair is real beyond R1 and R2, so that there a torus locus ends."""
        problem = self._problem
        resonances = [item for item in found if item.type in ("R1", "R2")]
        if problem.kind != "NS" or not resonances:
            return Sight(found)
        first = resonances[0]
        reason = f"the locus ends at a strong resonance, {first.type}"
        if problem.orbits == "equilibrium":
            reason = (
                "the locus ends at a Bogdanov-Takens point, BT: the equilibria beyond are neutral "
                "saddles, which are no bifurcation"
            )
        end = End("codimension-2", reason, problem.place(first.point.z))
        return Sight(found, Stop(first.point, end))

    def located(
        self, known: list[OrbitPoint], a: OrbitPoint, b: OrbitPoint
    ) -> list[Found[OrbitPoint]]:
        """Return the special points where a test function changes sign between two points."""
        return _with_cusps(super().located(known, a, b))

    def changes_sign(self, name: str, a: OrbitPoint, b: OrbitPoint) -> bool:
        """Whether a test function does, and not because the locus is parallel to an axis."""
        largest = max(abs(a.tests[name]), abs(b.tests[name]))
        parallel = name in ("first", "second") and largest < PARALLEL
        return not parallel and super().changes_sign(name, a, b)

    def is_genuine(self, found: Found) -> bool:
        """Whether the multipliers are where the type says."""
        values = found.point.multipliers
        others = np.delete(values, critical_places(self._problem.kind, values))
        if found.type in ("PDNS", "LPNS", "NSNS") and self._problem.kind != "NS":
            return is_torus(others)
        if found.type == "NSNS":
            return is_torus(others)
        if found.type in ("R1", "R2") and self._problem.kind != "NS":
            return bool(np.abs(others - (1 if found.type == "R1" else -1)).min() < DOUBLE)
        if found.type in ("LPPD", "LPNS", "PDNS"):
            on_fold = self._problem.kind == "PD" or found.type == "LPNS"
            return bool(np.abs(others - (1 if on_fold else -1)).min() < ON_CIRCLE)
        return True

    def accounts_for(self, found: list[Found], a: OrbitPoint, b: OrbitPoint) -> bool:
        """Whether what was found explains the change in the number of unstable multipliers."""
        change = abs(self._outside(b) - self._outside(a))
        single = sum(item.type in _SINGLE[self._problem.kind] for item in found)
        pairs = sum(item.type in _PAIR[self._problem.kind] for item in found)
        return change <= single + 2 * pairs and (change - single) % 2 == 0

    def _outside(self, point: OrbitPoint) -> int:
        """Number of multipliers outside the unit circle besides the critical ones."""
        places = critical_places(self._problem.kind, point.multipliers)
        others: NDArray[np.float64] = np.abs(np.delete(point.multipliers, places))
        return int(np.count_nonzero(others > 1))


_SINGLE = {"LP": ("R1", "LPPD"), "PD": ("R2", "LPPD"), "NS": ("LPNS", "PDNS")}
_PAIR = {"LP": ("LPNS",), "PD": ("PDNS",), "NS": ("NSNS",)}


def _with_cusps(found: list[Found]) -> list[Found]:
    """Replace the extrema in both parameters at a cusp by one CPC."""
    result: list[Found] = []
    cusps: list[float] = []
    for item in found:
        tests, place = item.point.tests, item.point.arclength
        moving = max(abs(tests["first"]), abs(tests["second"])) > STANDING
        if item.type not in ("first", "second") or moving:
            result.append(item)
        elif not any(abs(place - other) < SAME for other in cusps):
            cusps.append(place)
            result.append(Found("CPC", item.point, item.slope))
    return result
