"""First points of loci: from special points of branches and of other loci."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from slipfold.arrays import Array
from slipfold.branches.settings import Settings
from slipfold.continuation.atlas import Start
from slipfold.continuation.follow import BIRTH
from slipfold.continuation.newton import correct
from slipfold.continuation.search import Found
from slipfold.continuation.walk import Failure, walk
from slipfold.errors import BREAKDOWNS, InputError, breakdown
from slipfold.loci.describe import plane_of
from slipfold.loci.locus_equations import LocusEquations
from slipfold.loci.special_points import DOUBLED
from slipfold.orbits.orbit_curve import OrbitPoint
from slipfold.orbits.test_functions import PAIRED

UNDEFINED = 1e-9
"""Smallest singular value, over the largest, of a Jacobian that defines a curve."""

FIRST = 0.01
"""First step from a regular point: a locus may be begun where it bends, beside a cusp."""

BESIDE = 1e-2
"""Distance from a double Hopf point at which the other of the loci that cross there is begun."""

MOVED = 1e-3
"""A special point may be moved by this, in scaled variables, before it is another one."""

CROSSING = {
    "LPPD": ("LP", "PD"),
    "LPNS": ("LP", "NS"),
    "PDNS": ("PD", "NS"),
    "DP": ("LP", "BP"),
    "BPPD": ("BP", "PD"),
    "BPNS": ("BP", "NS"),
    "R1": ("LP", "NS"),
    "R2": ("PD", "NS"),
    "BT": ("LP", "BP", "HB"),
    "ZH": ("LP", "BP", "HB"),
}
"""Types of the loci that pass through a point of codimension two, or end there."""


@dataclass(frozen=True, eq=False)
class LocusStart(Start[OrbitPoint]):
    """Where a locus is to be followed from."""

    # Whether its orbits are there those of half the period, passed twice, or equilibria
    doubled: bool = False
    # Type of the point of codimension two that it passes there; empty if it passes none
    crosses: str = ""
    step: float = FIRST  # length of the first step
    # Orbits by which it is known, where another locus of its type passes its first point
    beside: tuple[Array, ...] = ()


def regular_start(
    curve: LocusEquations, z: Array, settings: Settings, crosses: str = ""
) -> LocusStart:
    """Return a point of a locus with both its directions."""
    try:
        point = _regular_point(curve, z, settings)
    except InputError:
        raise
    except BREAKDOWNS as error:
        raise _no_locus(curve, z, breakdown(error)) from None
    both = _rising_first(point, curve.turned(point))
    step = BIRTH if crosses else FIRST
    return LocusStart(curve, both, departs=bool(crosses), crosses=crosses, step=step)


def _regular_point(curve: LocusEquations, z: Array, settings: Settings) -> OrbitPoint:
    linearised = curve.linearise(z)
    if not np.isfinite(linearised.jacobian).all():
        raise _no_locus(curve, z, "its orbit cannot be integrated")
    jacobian = linearised.jacobian
    if _is_singular(curve, jacobian, z):
        raise _no_locus(curve, z, "neither of them moves it")
    right = np.linalg.svd(jacobian)[2]
    newton = settings.newton
    correction = correct(curve, z, right[-1], newton.tolerance, newton.iterations)
    if not correction.converged or correction.distance > MOVED:
        reason = correction.failure or "Newton's method leads to another orbit"
        raise _no_locus(curve, z, reason)
    return curve.point(correction, 0.0)


def _rising_first(point: OrbitPoint, turned: OrbitPoint) -> tuple[OrbitPoint, OrbitPoint]:
    """Begin where the parameters rise together: the sign of a singular vector is arbitrary."""
    rises = float(point.tangent[-2:].sum())
    return (point, turned) if rises >= 0 else (turned, point)


def _is_singular(curve: LocusEquations, jacobian: Array, z: Array) -> bool:
    """Whether no curve is defined: neither parameter, changed by its window or itself, matters."""
    effects = np.linalg.norm(jacobian[:, -2:], axis=0)
    if float((effects * np.maximum(np.abs(z[-2:]), 1.0)).max()) < UNDEFINED:
        return True
    scaled = jacobian.copy()
    scaled[:, -2:] /= effects.max()
    if curve.orbits.by.growing:  # what grows on the way round makes it as good as singular
        return False
    values = np.linalg.svd(scaled, compute_uv=False)
    return bool(values[len(z) - 2] < UNDEFINED * values[0])


def _no_locus(curve: LocusEquations, z: Array, reason: str) -> InputError:
    first, second = plane_of(curve.orbits)
    a, b = curve.place(z)
    return InputError(
        f"the {curve.condition} at {first} = {a:.6g}, {second} = {b:.6g} has no locus in {first} "
        f"and {second}: {reason}; choose other parameters or another special point"
    )


def passing(
    curve: LocusEquations, found: Found, types: Sequence[str], settings: Settings
) -> Iterator[LocusStart]:
    """Return the loci of other types that pass a point of codimension two, or end there."""
    point, orbits = found.point, curve.orbits
    for other in CROSSING.get(found.type, ()):
        if other == curve.condition or other not in types:
            continue
        try:
            start = regular_start(LocusEquations(orbits, other), point.z, settings, found.type)
        except InputError:
            continue
        if found.type in DOUBLED and other in PAIRED:
            yield from _complex_side(start, settings)
        else:
            yield start


def of_each_pair(curve: LocusEquations, z: Array, settings: Settings) -> Iterator[LocusStart]:
    """Return the two loci of a type that cross where two pairs are critical.

    There the equations do not say which of the pairs they mean: at a point beside it they do.
    """
    newton = settings.newton
    for along in curve.pair_tangents(z):
        tangent = along if along[-2:].sum() >= 0 else -along  # its sign is arbitrary
        guess = z + BESIDE * tangent
        found = correct(curve, guess, tangent, newton.tolerance, newton.iterations, BESIDE / 2)
        if found.converged:
            point = curve.point(found, 0.0)
            yield LocusStart(curve, _rising_first(point, curve.turned(point)))


def _complex_side(start: LocusStart, settings: Settings) -> Iterator[LocusStart]:
    """Return the direction in which a pair that meets on the real axis is complex."""
    sides = []
    for point in start.points:
        first = next(iter(walk(start.curve, [point], BIRTH, (), settings)))
        if not isinstance(first, Failure) and is_complex(first):
            sides.append(point)
    if sides:
        yield replace(start, points=tuple(sides), crosses="")


def is_complex(point: OrbitPoint) -> bool:
    """Whether the critical pair of a point of a torus locus is complex."""
    tests = point.tests
    return tests["BT"] > 0 if "BT" in tests else tests["R1"] > 0 < tests["R2"]
