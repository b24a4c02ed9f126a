"""First points of loci: from special points of branches and of other loci."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.closed_branches import asymmetry
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
from slipfold.orbits.births import Newborn, cycle_of_no_amplitude, passed_twice
from slipfold.orbits.crossing import critical_direction
from slipfold.orbits.discretisations.segments import Segments
from slipfold.orbits.equilibria import Equilibria
from slipfold.orbits.orbit_point import OrbitPoint
from slipfold.orbits.spectrum.degeneracy import PAIRED
from slipfold.orbits.spectrum.eigenvalues import Cayley
from slipfold.orbits.spectrum.floquet import floquet_multipliers

__all__ = ["LocusStart", "parent_start", "regular_start", "starts_at"]

Array = NDArray[np.float64]

UNDEFINED = 1e-9
"""Smallest singular value, over the largest, of a Jacobian that defines a curve."""

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
    "BT": ("LP", "HB"),
    "ZH": ("LP", "HB"),
}
"""Types of the loci that pass through a point of codimension two, or end there."""


@dataclass(frozen=True, eq=False)
class LocusStart(Start[OrbitPoint]):
    """Where a locus is to be followed from."""

    # Whether its orbits are there those of half the period, passed twice, or equilibria
    doubled: bool = False
    # Type of the point of codimension two that it passes there; empty if it passes none
    crosses: str = ""


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
    return LocusStart(curve, both, departs=bool(crosses), crosses=crosses)


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


def parent_start(curve: LocusEquations, point: OrbitPoint, settings: Settings) -> LocusStart | None:
    """Return the period doubling or Hopf point at which a locus of orbits born there ends."""
    orbits = curve.orbits
    nodes = orbits.nodes(point.z)
    if orbits.period % 2:
        resting = Equilibria(orbits.model, orbits.varied, Cayley())
        z = resting.pack(nodes.mean(axis=0, keepdims=True), orbits.values(point.z))
        parent = LocusEquations(resting, "HB")
    else:
        half = orbits.with_period(orbits.period // 2)
        assert isinstance(orbits.by, Segments)
        assert isinstance(half.by, Segments)
        rounds = [half.by.start, half.by.start + half.period]
        halves = orbits.by.states(nodes, orbits.constants(point.z), np.concatenate(rounds))
        both = halves.reshape(2, half.segments, -1)
        z = half.join(both.mean(axis=0), orbits.free_values(point.z))
        parent = LocusEquations(half, "PD")
    try:
        return regular_start(parent, z, settings)
    except InputError:
        return None


def starts_at(curve: LocusEquations, found: Found, settings: Settings) -> Iterator[LocusStart]:
    """Return the loci that begin or pass at a point of codimension two, but its own.

    At GPD the folds of the doubled orbits are born; through LPPD, LPNS, PDNS, R1 and R2 pass loci
    of two types, that of tori ending at the resonances; at R2 a locus of tori of the doubled orbits
    may be born as well. At a generalised Hopf point folds of cycles are born.
    """
    point, orbits, condition = found.point, curve.orbits, curve.condition
    if found.type == "GH" and isinstance(orbits, Equilibria):
        yield from _born(cycle_of_no_amplitude(orbits, point.z), "LP", point, settings)
    if found.type == "GPD":
        yield from _born(passed_twice(orbits, point.z), "LP", point, settings)
    for other in CROSSING.get(found.type, ()):
        if other == condition:
            continue
        if (found.type, other) == ("DP", "LP"):
            yield from _folds_at(curve, point, settings)
            continue
        try:
            start = regular_start(LocusEquations(orbits, other), point.z, settings, found.type)
        except InputError:
            continue
        if found.type in DOUBLED and other in PAIRED:
            yield from _complex_side(start, settings)
        else:
            yield start
    if found.type == "R2" and condition == "PD":
        yield from _born(passed_twice(orbits, point.z), "NS", point, settings)


def _complex_side(start: LocusStart, settings: Settings) -> Iterator[LocusStart]:
    """Return the direction in which a pair that meets on the real axis is complex."""
    sides = []
    for point in start.points:
        first = next(iter(walk(start.curve, [point], BIRTH, (), settings)))
        if not isinstance(first, Failure) and _is_complex(first):
            sides.append(point)
    if sides:
        yield replace(start, points=tuple(sides), crosses="")


def _is_complex(point: OrbitPoint) -> bool:
    """Whether the critical pair of a point of a torus locus is complex."""
    tests = point.tests
    return tests["BT"] > 0 if "BT" in tests else tests["R1"] > 0 < tests["R2"]


def _folds_at(curve: LocusEquations, point: OrbitPoint, settings: Settings) -> Iterator[LocusStart]:
    """Return the folds that leave a degenerate pitchfork: half of them mirrors the other.

    Their equations hold on all the branch points as well; they leave along the critical vector.
    """
    tangent = np.append(critical_direction(curve.orbits, point.z), np.zeros(2))
    folds = LocusEquations(curve.orbits, "LP")
    start = _leaving(folds, point.z, tangent, point.monodromy, point.residual)
    if start is None:
        return
    after = next(iter(walk(folds, [start], BIRTH, (), settings)))
    if not isinstance(after, Failure) and abs(float((after.z - point.z) @ tangent)) > 0.5 * BIRTH:
        yield LocusStart(folds, (start,), departs=True, crosses="DP")


def _leaving(
    curve: LocusEquations, z: Array, tangent: Array, monodromy: Array, residual: float
) -> OrbitPoint | None:
    """Return the first point of a locus that leaves another one, where its equations are singular.

    None if its orbit cannot be integrated. Shapes: monodromy (n, n).
    """
    linearisation = curve.orbits.linearise(z)
    if not np.isfinite(linearisation.blocks).all():
        return None
    multipliers = floquet_multipliers(monodromy)
    return OrbitPoint(
        z,
        tangent,
        0.0,
        curve.tests(z, linearisation, multipliers, tangent),
        0,
        residual,
        piece=curve.orbits.piece(z),
        curve=curve,
        monodromy=monodromy,
        multipliers=multipliers,
    )


def _born(
    first: Newborn, condition: str, parent: OrbitPoint, settings: Settings
) -> Iterator[LocusStart]:
    """Return the locus of orbits that are born at a point, unless it leads to their parents."""
    curve = LocusEquations(first.orbits, condition)
    start = _leaving(curve, first.z, first.tangent, first.monodromy, parent.residual)
    if start is None:
        return
    after = next(iter(walk(curve, [start], BIRTH, (), settings)))
    if isinstance(after, Failure) or np.linalg.norm(asymmetry(first.orbits, after.z)) < 0.5 * BIRTH:
        return
    if condition == "LP" or _is_complex(after):
        yield LocusStart(curve, (start,), departs=True, doubled=True)
