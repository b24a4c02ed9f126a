"""Orbits continued to other parameter values, by collocation, or across sticking phases."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple, TypeVar

import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.continuation.newton import LeastSquares, SquareMatrix, correct
from slipfold.continuation.settings import Stepping, Steps
from slipfold.continuation.walk import CurveSteps, Failure
from slipfold.errors import BREAKDOWNS
from slipfold.flow.batches import TOLERANCE
from slipfold.flow.modes import limits_of_contacts
from slipfold.newton import Rule, find_root
from slipfold.orbits.collocation import Collocation
from slipfold.orbits.discretization import STAGES, Discretization
from slipfold.orbits.kinds import STANDING
from slipfold.orbits.limits import LIMIT, limit_met, margins_at
from slipfold.orbits.linearization import Conditions, Linearization
from slipfold.orbits.marginal import MarginalShooting
from slipfold.orbits.meshes import INTERVALS
from slipfold.orbits.orbit_curve import MESHES, OrbitCurve, OrbitPoint, Orbits, no_mesh_fits
from slipfold.orbits.shooting import SEGMENT_GROWTH, MeshShooting, Shooting, growth_within
from slipfold.orbits.switched_shooting import SwitchedShooting

MEETING = Rule(close=1e-9, longest=0.01, iterations=10)
"""A marginal stop has converged after a step this short: the next one is of the order of its
square."""

CONTINUING = Stepping(steps=Steps(smallest=1e-4, points=500))
"""Continuation with very short steps is given up. Where a contact begins to stick, steps of 1e-6
would take tens of thousands of steps of the integrator each."""


SPREADS = 6
"""Times a mesh is spread until none of its intervals holds a jump that lasts 1e-6 of a round."""

ROUNDING = float(np.finfo(float).eps)


def parameter_rounding(
    bordered: SquareMatrix, z: Array, residual: float | Array = 0.0, row: Array | None = None
) -> float:
    """Return what rounding of the segments' ends can do to the last unknown, the parameter.

    Or to what has the derivatives `row`. Where each equation may have a larger error, `residual`,
    that counts.
    """
    row = hold_parameter(len(z) - 1) if row is None else row
    weights = np.abs(bordered.solve_transposed(row))
    sizes = np.ones(len(weights))  # there may be more equations than unknowns
    sizes[: len(z)] = np.maximum(1.0, np.abs(z))
    return float(weights @ np.maximum(ROUNDING * sizes, residual))


def hold_parameter(size: int) -> Array:
    """Return the constraint that keeps the parameter at its guess."""
    row = np.zeros(size + 1)
    row[-1] = 1.0
    return row


def continue_to(
    curve: OrbitCurve,
    z: Array,
    target: float,
    refuse: Callable[[OrbitPoint], str | None],
    stepping: Stepping = CONTINUING,
) -> OrbitPoint | Failure:
    """Follow a curve from an orbit to where its last parameter has another value, round its folds.

    `refuse` says what is wrong with an orbit on the way, if anything is.
    """
    width = float(curve.orbits.width)
    begin, end = float(z[-1]), target / width
    correction = correct(curve, z, hold_parameter(len(z) - 1) * (np.sign(end - begin) or 1.0))
    if not correction.converged:
        return Failure("failed", correction.failure)
    start = curve.point(correction, 0.0)
    if begin == end:
        return start
    reached = None
    bounds = [(-1, min(begin, end), max(begin, end))]
    for point in CurveSteps(curve, [start], 0.01, bounds, stepping).points():
        if isinstance(point, Failure):
            return point if reached is None else _by_a_limit(start, reached) or point
        wrong = refuse(point)
        if wrong is not None:
            return Failure("limit", wrong)
        reached = point
    if reached is None or reached.z[-1] != end:
        return Failure("turned", "it turns back before")
    return reached


def _by_a_limit(first: OrbitPoint, last: OrbitPoint) -> Failure | None:
    """Return the limit that a curve ends at: of the first orbit's margin next to none is left."""
    orbits = last.curve.orbits
    limits = orbits.model.limits
    if not limits or not orbits.by.smooth:
        return None
    margins, left = margins_at(first), margins_at(last)
    met = limit_met(left, margins)
    if not left[met] < LIMIT.near * margins[met]:
        return None
    return Failure("limit", limits[met].reason.format(value=left[met] + limits[met].bound))


class Met(NamedTuple):
    """An orbit that only just meets changes of contacts."""

    point: OrbitPoint
    rounding: float  # of the last unknown, by errors of steps and what is left of the equations


def locate_marginal_stops(
    orbits: Orbits, point: OrbitPoint, kind: str | None = "MEET"
) -> Met | None:
    """Return the orbit near another on which friction only just holds contacts that stop.

    An orbit that is its own symmetric image has several such stops at once. It may be neutral to
    perturbations that separate them, so that only all conditions together locate it. Without a kind
    the nearest stop is tried however near it is. None if there is none.
    """
    by = orbits.by
    assert isinstance(by, SwitchedShooting)
    nodes, constants = orbits.nodes(point.z), orbits.constants(point.z)
    kind = by.met.kind if isinstance(by, MarginalShooting) else kind
    stops = MarginalShooting.stops_of(by, nodes, constants, kind)
    found = [stop for near, stop in stops if near < 1e-3]  # of what friction can hold
    found = found or [stop for _, stop in stops[: kind is None]]
    for some in (found, found[:1]) if len(found) > 1 else (found,):
        met = solve_marginal(orbits, point, some) if some else None
        if met is not None:
            return met
    return None


def solve_marginal(
    orbits: Orbits, point: OrbitPoint, stops: Sequence[MarginalShooting]
) -> Met | None:
    """Return the orbit near another that only just meets changes of contacts, None if none is.

    The equations are smooth on both sides of it, and the parameter is an unknown.
    """
    curve = orbits.described_by(stops[0])
    guess, row = curve.moved(point)

    def linearized(z: Array) -> tuple[Linearization, Array, Array]:
        part, nodes, constants = curve.linearize(z), curve.nodes(z), curve.constants(z)
        met = [stop.condition_of(stops[0], nodes, constants) for stop in stops]
        rows = [np.concatenate(slopes) for _, *slopes in met]
        defect = np.append(part.defect, [value for value, *_ in met])
        return part, defect, np.vstack([part.jacobian, *rows])

    def step(z: Array) -> Array:
        _, defect, jacobian = linearized(z)
        if not (np.isfinite(defect).all() and np.isfinite(jacobian).all()):
            return np.full(len(z), np.nan)
        return np.asarray(-np.linalg.lstsq(jacobian, defect, rcond=None)[0])

    z = find_root(step, guess, MEETING)
    if z is None:
        return None
    part, defect, jacobian = linearized(z)
    residual = float(np.abs(defect).max())
    if not residual <= MEETING.close:  # stops that are met at different places, or nowhere
        return None
    try:  # the tangent at a point this near may be that of the other side
        tangent = part.bordered(row).tangent()
        rounding = parameter_rounding(LeastSquares(jacobian), z, max(residual, TOLERANCE))
    except BREAKDOWNS:
        return None
    met = curve.derived_point(z, tangent, point.arclength, part.monodromy, residual)
    return Met(met, rounding)


class Straight(OrbitCurve):
    """Orbits in two parameters that lie on a straight line.

    `begin` and `end` are two places on it, in the units of the parameters.
    """

    def __init__(self, orbits: Orbits, begin: Array, end: Array) -> None:
        self.orbits = orbits
        self._begin = begin / orbits.widths
        x, y = end / orbits.widths - self._begin
        self._across = np.array([-y, x]) / np.hypot(x, y)

    def _beside(self, z: Array) -> float:
        return float(self._across @ (z[-2:] - self._begin))

    def defect(self, z: Array) -> Array:
        """Return what Newton's method brings to zero."""
        return np.append(self.orbits.defect(z), self._beside(z))

    def linearize(self, z: Array) -> Linearization:
        """Return the defect with its derivatives."""
        gradient = np.zeros((1, len(z)))
        gradient[0, -2:] = self._across
        conditions = Conditions(np.array([self._beside(z)]), gradient)
        return replace(self.orbits.linearize(z), conditions=conditions)

    def tests(
        self, z: Array, linearization: Linearization, multipliers: Complex, tangent: Array
    ) -> dict[str, float]:
        """Return what detects a fold; stability is examined point by point."""
        return {"LP": float(tangent[-1])}


C = TypeVar("C", bound=OrbitCurve)


def by_collocation(curve: C, point: OrbitPoint) -> tuple[C, OrbitPoint] | None:
    """Return a curve by collocation on a mesh that fits, and a point of it; None if that fails."""
    orbits = curve.orbits
    if isinstance(orbits.by, Collocation):
        return _fitted(curve, point)
    nodes, constants = orbits.nodes(point.z), orbits.constants(point.z)
    scheme = orbits.by.scheme(nodes, constants)
    count = 4 * INTERVALS * orbits.period
    by = Collocation(orbits.model, orbits.by.free, orbits.period, count, scheme=scheme)
    for _ in range(SPREADS):
        states = orbits.by.states(nodes, constants, by.mesh) / orbits.scales
        changes = np.abs(orbits.by.apart(states[1:], states[:-1]))
        by = by.spread_over((changes / (np.ptp(states, axis=0) + ROUNDING)).max(axis=1))
    return _described_by(by, curve, point)


def by_mesh_shooting(curve: C, point: OrbitPoint) -> tuple[C, OrbitPoint] | None:
    """Return a curve by shooting over a mesh, and a point of it; None if that fails.

    None too where it is no more exact: where perturbations grow little from segment to segment, or
    motion is stiff.
    """
    orbits, part = curve.orbits, point.linearization
    by, nodes, constants = orbits.by, orbits.nodes(point.z), orbits.constants(point.z)
    if isinstance(by, Collocation):
        if by.points.damps or by.flow.is_stiff(nodes[0], constants):
            return None
        return _described_by(MeshShooting.with_scales_of(by, by.edges), curve, point)
    if type(by) is not Shooting or part is None or growth_within(part.blocks) < SEGMENT_GROWTH:
        return None
    return _described_by(MeshShooting.with_scales_of(by), curve, point)


def _described_by(by: Discretization, curve: C, point: OrbitPoint) -> tuple[C, OrbitPoint] | None:
    orbits, other = curve.orbits, curve.described_by(by)
    size = np.ptp(orbits.nodes(point.z) / orbits.scales, axis=0).max()
    if orbits.free_phase and size < STANDING:
        return (
            (other, _vanishing_cycle(other, orbits, point)) if isinstance(other, Orbits) else None
        )
    again = other.converted(point)
    return None if again is None else _fitted(other, again)


def on_mesh(orbits: Orbits, z: Array, stages: int = STAGES) -> tuple[Orbits, Array]:
    """Describe an orbit by collocation on a mesh that fits it; nothing is corrected."""
    scheme = orbits.by.scheme(orbits.nodes(z), orbits.constants(z), stages)
    count = max(orbits.segments, 4 * INTERVALS * orbits.period)
    by = Collocation(orbits.model, orbits.by.free, orbits.period, count, scheme=scheme)
    other = orbits.described_by(by)
    return fitted(other, other.adopt(orbits, z))


def fitted(orbits: Orbits, z: Array) -> tuple[Orbits, Array]:
    """Describe an orbit on a mesh that fits it, or raise; nothing is corrected."""
    for _ in range(MESHES + 1):
        by = orbits.by.better(orbits.nodes(z), orbits.constants(z))
        if by is None:
            return orbits, z
        other = orbits.described_by(by)
        orbits, z = other, other.adopt(orbits, z)
    raise no_mesh_fits(orbits, z)


def _fitted(curve: C, point: OrbitPoint) -> tuple[C, OrbitPoint]:
    for _ in range(MESHES + 1):
        following = curve.renewed([point])
        if following is None:
            return curve, point
        curve, (point,) = following
    raise no_mesh_fits(curve.orbits, point.z)


def _vanishing_cycle(other: Orbits, orbits: Orbits, point: OrbitPoint) -> OrbitPoint:
    """Return a cycle of no amplitude, the direction of which turns once, at other phases."""
    turns = np.exp(2j * np.pi * np.arange(orbits.segments) / orbits.segments)
    critical = turns.conj() @ orbits.nodes(point.tangent) * (2 / orbits.segments)
    later = np.exp(2j * np.pi * np.arange(other.segments) / other.segments)
    nodes = np.tile(orbits.nodes(point.z)[:1], (other.segments, 1))
    z = other.join(nodes, orbits.free_values(point.z))
    tangent = other.join(np.real(later[:, None] * critical), orbits.free_values(point.tangent))
    tangent /= np.linalg.norm(tangent)
    return other.derived_point(z, tangent, point.arclength, point.monodromy, point.residual)


def through_stick(
    curve: C, point: OrbitPoint, before: OrbitPoint | None
) -> tuple[C, OrbitPoint] | None:
    """Return a curve through stick and slip instead of one that ends at a limit, and its point.

    It is the point before where rounding put this one beyond the change of contacts. None where the
    limit, which the point before shows, is none of a contact that may stick.
    """
    orbits = curve.orbits
    beyond = limits_of_contacts(orbits.model)
    limits = orbits.model.limits
    if not beyond or not limits or orbits.kind == "equilibrium":  # which ends where slip does
        return None
    earlier = None if before is None else margins_at(before)
    if limits[limit_met(margins_at(point), earlier)].name not in beyond:
        return None
    other = curve.described_by(SwitchedShooting(orbits.model, orbits.by.free, orbits.period))
    first = other.converted(point)
    if first is None:
        return None
    if before is not None and not _slips(first):
        first = next(filter(_slips, filter(None, [other.converted(before)])), first)
    renewed = other.renewed([first])
    return (other, first) if renewed is None else (renewed[0], renewed[1][0])


def _slips(point: OrbitPoint) -> bool:
    """Whether no contact changes along an orbit."""
    return point.piece is not None and all(len(modes) == 1 for modes in point.piece)
