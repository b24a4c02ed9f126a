"""First points of loci: from special points of branches and of other loci."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.closing import asymmetry
from slipfold.branches.field_map import FieldMap
from slipfold.branches.settings import Settings
from slipfold.continuation.follow import BIRTH
from slipfold.continuation.newton import correct
from slipfold.continuation.search import Found
from slipfold.continuation.walk import Failure, walk
from slipfold.errors import BREAKDOWNS, InputError, breakdown
from slipfold.loci.cycle_locus import CycleLocus
from slipfold.loci.equilibrium_locus import EquilibriumLocus
from slipfold.loci.locus_problem import LocusProblem
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["Start", "parent_starts", "regular_start", "starts_at"]

Array = NDArray[np.float64]

SINGULAR = 1e-9
"""Smallest singular value, over the largest, of a Jacobian that defines a curve."""

NEAR = 1e-3
"""A special point may be moved by this, in scaled variables, before it is another one."""

CROSSING = {
    "LPPD": ("LP", "PD"),
    "LPNS": ("LP", "NS"),
    "PDNS": ("PD", "NS"),
    "R1": ("LP", "NS"),
    "R2": ("PD", "NS"),
}
"""Types of the loci that pass through a point of codimension two, or end there."""


class Start:
    """Where a locus is to be followed from.

    Parameters
    ----------
    problem
        Its equations.
    point
        The first point.
    born
        Whether the locus begins there, at a point of codimension two.
    doubled
        Whether its orbits are there those of half the period, passed twice, or equilibria.
    crosses
        Type of the point of codimension two that it passes there; empty if it passes none.
    """

    def __init__(
        self,
        problem: LocusProblem,
        point: OrbitPoint,
        born: bool = False,
        doubled: bool = False,
        crosses: str = "",
    ) -> None:
        self.problem = problem
        self.point = point
        self.born = born
        self.doubled = doubled
        self.crosses = crosses

    def reversed(self) -> Start:
        """Return the same place with the opposite direction."""
        turned = self.problem.turned(self.point)
        return Start(self.problem, turned, self.born, self.doubled, self.crosses)


def regular_start(problem: LocusProblem, z: Array, settings: Settings) -> Start:
    """Return a point of a locus with its direction."""
    try:
        return _regular_start(problem, z, settings)
    except InputError:
        raise
    except BREAKDOWNS as error:
        raise _no_locus(problem, z, breakdown(error)) from None


def _regular_start(problem: LocusProblem, z: Array, settings: Settings) -> Start:
    linearised = problem.linearise(z)
    if not np.isfinite(linearised.jacobian).all():
        raise _no_locus(problem, z, "its orbit cannot be integrated")
    jacobian = linearised.jacobian
    if _is_singular(problem, jacobian, z):
        raise _no_locus(problem, z, "neither of them moves it")
    right = np.linalg.svd(jacobian)[2]
    newton = settings.newton
    correction = correct(problem, z, right[-1], newton.tolerance, newton.iterations)
    if not correction.converged or correction.distance > NEAR:
        reason = correction.failure or "Newton's method leads to another orbit"
        raise _no_locus(problem, z, reason)
    return Start(problem, problem.point(correction, 0.0))


def _is_singular(problem: LocusProblem, jacobian: Array, z: Array) -> bool:
    """Whether no curve is defined: neither parameter, changed by its window or itself, matters."""
    effects = np.linalg.norm(jacobian[:, -2:], axis=0)
    if float((effects * np.maximum(np.abs(z[-2:]), 1.0)).max()) < SINGULAR:
        return True
    scaled = jacobian.copy()
    scaled[:, -2:] /= effects.max()
    values = np.linalg.svd(scaled, compute_uv=False)
    return bool(values[-1] < SINGULAR * values[0])


def _no_locus(problem: LocusProblem, z: Array, reason: str) -> InputError:
    first, second = problem.vary
    a, b = problem.values(z)
    return InputError(
        f"the {problem.type} at {first} = {a:.6g}, {second} = {b:.6g} has no locus in {first} and "
        f"{second}: {reason}; choose other parameters or another special point"
    )


def parent_starts(problem: LocusProblem, point: OrbitPoint, settings: Settings) -> list[Start]:
    """Return the period doubling of the orbits that those of a locus are the doubles of."""
    if problem.period % 2:
        return _hopf_starts(problem, point, settings)
    parent = _sibling(problem, "PD", problem.period // 2)
    m = problem.segments
    halves = problem.halved(problem.nodes(point.z), problem.constants(point.z))
    z = parent.join(0.5 * (halves[:m] + halves[m:]), problem.free_values(point.z))
    try:
        start = regular_start(parent, z, settings)
    except InputError:
        return []
    return [start, start.reversed()]


def _hopf_starts(problem: LocusProblem, point: OrbitPoint, settings: Settings) -> list[Start]:
    first, second = map(float, problem.widths)
    parent = EquilibriumLocus(problem.model, "NS", problem.vary, 1, (first, second))
    middle = problem.nodes(point.z).mean(axis=0)
    try:
        start = regular_start(parent, parent.pack(middle[None], problem.values(point.z)), settings)
    except InputError:
        return []
    return [start, start.reversed()]


def starts_at(problem: LocusProblem, found: Found, settings: Settings) -> Iterator[Start]:
    """Return the loci that begin or pass at a point of codimension two, but its own.

    At GPD the folds of the doubled orbits are born; through LPPD, LPNS, PDNS, R1 and R2 pass loci
    of two types, that of tori ending at the resonances; at R2 a locus of tori of the doubled orbits
    may be born as well. At a generalised Hopf point folds of cycles are born.
    """
    z, kind = found.point.z, problem.kind
    if found.type == "CH" and isinstance(problem, EquilibriumLocus):
        yield from _folds_of_cycles(problem, found.point, settings)
    if found.type == "GPD":
        yield from _doubled(problem, found.point, "LP", settings)
    for other in CROSSING.get(found.type, ()):
        if other == kind:
            continue
        crossing = _sibling(problem, other, problem.period)
        try:
            start = regular_start(crossing, z, settings)
        except InputError:
            continue
        if found.type in ("R1", "R2") and other == "NS":
            yield from _complex_side(start, settings)
        else:
            here = Start(crossing, start.point, born=True, crosses=found.type)
            yield from (here, here.reversed())
    if found.type == "R2" and kind == "PD":
        yield from _doubled(problem, found.point, "NS", settings)


def _sibling(problem: LocusProblem, kind: str, period: int) -> LocusProblem:
    first, second = problem.widths
    widths = (float(first), float(second))
    return type(problem)(problem.model, kind, problem.vary, period, widths, problem.segments)


def _complex_side(start: Start, settings: Settings) -> Iterator[Start]:
    """Return the direction in which a pair that meets on the real axis is complex."""
    for side in (start, start.reversed()):
        first = next(iter(walk(side.problem, [side.point], BIRTH, (), settings)))
        if not isinstance(first, Failure) and _is_complex(first):
            yield Start(side.problem, side.point, born=True)


def _is_complex(point: OrbitPoint) -> bool:
    """Whether the critical pair of a point of a torus locus is complex; R2 is none of a Hopf's."""
    return point.tests["R1"] > 0 < point.tests.get("R2", 1.0)


def _doubled(
    problem: LocusProblem, point: OrbitPoint, kind: str, settings: Settings
) -> Iterator[Start]:
    """Return a locus of orbits of twice the period that is born where these have no amplitude.

    Its tangent is the critical direction, which changes sign from one period to the next, and the
    parameters do not change to first order.
    """
    m = problem.segments
    linearised = problem.linearise(point.z)
    blocks = linearised.blocks
    values, vectors = np.linalg.eig(linearised.product)
    direction = vectors[:, np.argmin(np.abs(values + 1))].real
    along = [direction]
    for block in blocks[:-1]:
        along.append(block @ along[-1])
    child = _sibling(problem, kind, 2 * problem.period)
    # A segment of the child is two of the parent.
    every_second = np.arange(0, 2 * m, 2) % m
    sign = np.where(np.arange(0, 2 * m, 2) < m, 1.0, -1.0)
    moved = (np.array(along)[every_second] * sign[:, None]).ravel()
    tangent = np.concatenate([moved, np.zeros(len(problem.units))])
    tangent *= np.sign(direction[np.abs(direction).argmax()]) / np.linalg.norm(tangent)
    nodes = problem.nodes(point.z)[every_second]
    z = child.join(nodes, problem.free_values(point.z))
    linearisation = child.linearise(z)
    if not np.isfinite(linearisation.blocks).all():
        return
    multipliers = np.sort_complex(point.multipliers**2)[::-1]
    multipliers = multipliers[np.argsort(-np.abs(multipliers), kind="stable")]
    tests = child.tests(z, linearisation, multipliers, tangent)
    start = OrbitPoint(
        z,
        tangent,
        0.0,
        tests,
        0,
        point.residual,
        monodromy=linearisation.monodromy,
        multipliers=multipliers,
    )
    first = next(iter(walk(child, [start], BIRTH, (), settings)))
    if isinstance(first, Failure) or np.linalg.norm(asymmetry(child, first.z)) < 0.5 * BIRTH:
        return
    if kind == "LP" or _is_complex(first):
        yield Start(child, start, born=True, doubled=True)


def _folds_of_cycles(
    problem: EquilibriumLocus, point: OrbitPoint, settings: Settings
) -> Iterator[Start]:
    """Return the locus of folds of cycles that is born at a generalised Hopf point.

    Its tangent is the critical eigenvector turning once; neither the parameters nor the duration
    change to first order.
    """
    jacobian: Array = FieldMap(problem, point.z).jacobian
    values, vectors = np.linalg.eig(jacobian)
    critical = int(np.where(values.imag > 0, np.abs(values.real), np.inf).argmin())
    duration = 2 * np.pi / float(values[critical].imag)
    first, second = map(float, problem.widths)
    model = problem.model.replace(duration=duration)
    child = CycleLocus(model, "LP", problem.vary, 1, (first, second))
    turns = np.exp(2j * np.pi * np.arange(child.segments) / child.segments)
    turning = np.real(vectors[:, critical] * turns[:, None]).ravel()
    tangent = np.concatenate([turning, np.zeros(len(child.units))]) / np.linalg.norm(turning)
    nodes = np.repeat(problem.nodes(point.z), child.segments, axis=0)
    z = child.join(nodes, [duration, *problem.values(point.z)])
    # Of all multipliers of the equilibrium the critical pair is one and one: the fold's, and that
    # of the flow, which is left out.
    others = np.delete(values, [critical, int(np.abs(values - values[critical].conj()).argmin())])
    multipliers = np.append(1.0, np.exp(others * duration)).astype(complex)
    multipliers = multipliers[np.argsort(-np.abs(multipliers), kind="stable")]
    linearisation = child.plain(z)
    tests = child.tests(z, linearisation, multipliers, tangent)
    start = OrbitPoint(
        z,
        tangent,
        0.0,
        tests,
        0,
        point.residual,
        monodromy=linearisation.monodromy,
        multipliers=multipliers,
    )
    after = next(iter(walk(child, [start], BIRTH, (), settings)))
    if isinstance(after, Failure):
        return
    if np.linalg.norm((after.z - z)[: child.size]) > 0.5 * BIRTH:
        yield Start(child, start, born=True, doubled=True)
