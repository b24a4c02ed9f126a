"""Curves of orbits: the meaning of an unknown, and how a solution becomes a point."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Hashable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from slipfold.arrays import Array, Complex, Indices
from slipfold.continuation.curve import Curve, Point
from slipfold.continuation.interpolation import POINTS, arc_between
from slipfold.continuation.locate import LostCurveError
from slipfold.continuation.newton import Correction, correct
from slipfold.errors import BREAKDOWNS, InputError
from slipfold.flow.equations import Constants
from slipfold.models.angles import wrap_angles
from slipfold.models.model import Model
from slipfold.orbits.discretization import Discretization
from slipfold.orbits.linearization import MANY, NO_CONDITIONS, Conditions, Linearization, defect_of
from slipfold.orbits.multipliers import Multipliers
from slipfold.orbits.shooting import Shooting
from slipfold.orbits.switched_shooting import SwitchedShooting
from slipfold.orbits.test_functions import (
    Degeneracy,
    Standing,
    critical_places,
    evaluate_each,
    evaluate_tests,
    floquet_multipliers,
    others_of,
)
from slipfold.text import outside

MESHES = 8
"""Meshes that are tried in turn until one fits an orbit: of those that fit, three at most were."""


def no_mesh_fits(orbits: Orbits, z: Array) -> InputError:
    """Return the error of an orbit for which each mesh in turn was too coarse."""
    model = orbits.model_at(z)
    ways = "choose other parameters, less steep friction, or more damping of fast modes"
    return InputError(
        f"no mesh fits the orbit of {model!r}: each of {MESHES} in turn was too coarse for it; "
        + "; ".join(filter(None, (ways, model.advice)))
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class OrbitPoint(Point):
    """An accepted orbit with what continuation needs to know of it.

    The tests of a branch are ``PD``, ``NS``, ``LP`` (the tangent's component along the parameter)
    and ``fold`` (zero at LP and BP alike), its growth is that of the largest multiplier at most.
    """

    monodromy: Array  # monodromy matrix in scaled states, shape (n, n)
    multipliers: Complex  # Floquet multipliers, shape (n,)
    # Fraction of the period in which a contact sticks, NaN if none may; the trajectory is at hand
    stuck_fraction: float = np.nan

    def resembles(self, other: Point) -> bool:
        """Whether the unknown of another orbit means the same."""
        own, its = self.curve.orbits, other.curve.orbits
        if self.curve is other.curve or not own.by.adapts or own.spectrum is not its.spectrum:
            return self.curve is other.curve
        parts = own.by.edges, own.scales, own.units
        return all(map(np.array_equal, parts, (its.by.edges, its.scales, its.units)))

    @cached_property
    def growth(self) -> float:
        """Upper bound of the logarithms of the multipliers' moduli, if all are inside the circle.

        Computed where it is requested: that takes as long as the multipliers.
        """
        if self.linearization is None or not (np.abs(self.multipliers) < 1).all():
            return np.inf
        return float(self.curve.growth(self.linearization))

    @cached_property
    def moving(self) -> Complex:
        """The multipliers that do not stand on the unit circle all along, in their order."""
        standing, values = self.curve.orbits.standing, self.multipliers
        return values if standing is None else values[standing.moving(values)]

    def critical(self, kind: str) -> Indices:
        """Return the places of the multipliers that make a bifurcation of some kind of it."""
        return critical_places(kind, self.multipliers, self.curve.orbits.standing)

    def beside(self, kind: str) -> Complex:
        """The multipliers that neither are these nor stand, in their order."""
        standing, values = self.curve.orbits.standing, self.multipliers
        return values[others_of(kind, values, standing)]

    @cached_property
    def unstable(self) -> int:
        """Number of multipliers outside the unit circle."""
        return int(np.count_nonzero(outside(self.moving)))


class OrbitCurve(Curve[OrbitPoint]):
    """A curve whose solutions are orbits: individually, or at a bifurcation."""

    orbits: Orbits
    """What the orbits are, and what an unknown means."""

    @property
    def sort(self) -> tuple[Hashable, ...]:
        """Kind, and period if it is known: only curves that agree in them may be one."""
        return self.orbits.kind, 0 if self.orbits.free_phase else self.orbits.period

    @abstractmethod
    def linearize(self, z: Array) -> Linearization:
        """Return the defect with its derivatives."""

    def shifted(self, z: Array, tangent: Array) -> tuple[Self, Array, Array]:
        """Return the same orbit and direction, so described that all errors are others."""
        orbits, moved, direction = self.orbits.shifted(z, tangent)
        return self.with_orbits(orbits), moved, direction

    def tests(
        self, z: Array, linearization: Linearization, multipliers: Complex, tangent: Array
    ) -> dict[str, float]:
        """Return the functions that change sign at special points of the curve, by name.

        None where nothing is watched. Shapes: multipliers (n,).
        """
        return {}

    def derived_point(
        self,
        z: Array,
        tangent: Array,
        arclength: float,
        monodromy: Array,
        residual: float,
        linearization: Any = None,
    ) -> OrbitPoint:
        """Return a point that is no correction, as where another curve passes and this is singular.

        Test functions of branches need no linearization. Shapes: monodromy (n, n).
        """
        multipliers = floquet_multipliers(monodromy)
        return OrbitPoint(
            z,
            tangent,
            arclength,
            self.tests(z, linearization, multipliers, tangent),
            0,  # the bordered determinant is zero, or not known
            residual,
            piece=self.orbits.piece(z),
            curve=self,
            monodromy=monodromy,
            multipliers=multipliers,
            stuck_fraction=self.orbits.stuck_fraction(z),
        )

    def described_by(self, by: Discretization, spectrum: Multipliers | None = None) -> Self:
        """Return the same in terms of another discretization, or with another spectrum."""
        return self.with_orbits(self.orbits.described_by(by, spectrum))

    def with_orbits(self, orbits: Orbits) -> Self:
        """Return the same condition on other orbits."""
        other = copy(self)
        other.orbits = orbits
        return other

    def renewed(self, points: Sequence[OrbitPoint]) -> tuple[Any, list[OrbitPoint]] | None:
        """Return the last points as described by what fits the last one, None if this does."""
        orbits, last, part = self.orbits, points[-1].z, points[-1].linearization
        at, own = (orbits.nodes(last), orbits.constants(last)), points[-1].curve
        blocks = None if part is None else part.blocks
        by = None if orbits.by.adapts else orbits.by.better(*at, blocks)
        spectrum = orbits.spectrum.better(part) if by is None else None
        if by is None and spectrum is None:
            return (own, [points[-1]]) if orbits.by.adapts and own is not self else None
        other, moved = self.described_by(by or own.orbits.by, spectrum), list[OrbitPoint]()
        for point in [item for item in points[-POINTS:] if item.resembles(points[-1])][::-1]:
            again = other.converted(point)
            if again is None:
                break
            if moved:
                again = replace(again, arclength=moved[0].arclength - arc_between(again, moved[0]))
            moved.insert(0, again)
        return (other, moved) if moved else None

    def converted(self, point: OrbitPoint) -> OrbitPoint | None:
        """Return a point of a curve that describes its orbits otherwise, None if it fails."""
        try:
            correction = correct(self, *self.moved(point))
            return self.point(correction, point.arclength) if correction.converged else None
        except BREAKDOWNS:
            return None

    def moved(self, point: OrbitPoint) -> tuple[Array, Array]:
        """Return the unknown and the tangent of a point of such a curve; nothing is corrected."""
        orbits, known = self.orbits, point.curve.orbits
        nodes, along = known.by.moved_to(
            orbits.by,
            known.nodes(point.z),
            known.constants(point.z),
            known.nodes(point.tangent),
            known.free_values(point.tangent),
        )
        row = orbits.join(along, known.free_values(point.tangent))
        return orbits.join(nodes, known.free_values(point.z)), row / np.linalg.norm(row)

    def growth(self, linearization: Linearization) -> float:
        """Return an upper bound of the logarithms of the multipliers' moduli."""
        return np.inf

    def ahead(self, points: Sequence[OrbitPoint]) -> float:
        """Return the arclength to where an output is zero, if its limit lies a little before that.

        Outputs follow the tangents of parabolas through their margins, as far as these are known:
        they approach a singularity ever more slowly.
        """
        limits, last = self.orbits.model.limits, points[-POINTS:]
        known = [vars(point).get("margins") for point in last]
        if not limits or len(last) < POINTS or any(margins is None for margins in known):
            return np.inf
        bounds = np.array([limit.bound for limit in limits])
        (a, b, c), outputs = (point.arclength for point in last), np.array(known) + bounds
        with np.errstate(invalid="ignore"):  # margins of orbits with stick are infinite
            first, second = (outputs[1] - outputs[0]) / (b - a), (outputs[2] - outputs[1]) / (c - b)
            slopes = second + (second - first) * ((c - b) / (c - a))
        falls = (bounds > 0) & (slopes < 0)
        return float((outputs[2][falls] / -slopes[falls]).min(initial=np.inf))

    def residual(self, z: Array, defect: Array) -> float:
        """Return the largest mismatch, in the scales of the states."""
        missed, finer = np.abs(defect), self.orbits.finer
        missed[: len(finer)] *= finer / self.orbits.magnified(z)
        return float(missed.max()) * float(np.sqrt(self.orbits.segments))

    def place(self, z: Array) -> tuple[float, ...]:
        """Return the values of the parameters that vary."""
        return tuple(self.orbits.values(z).tolist())

    def blended(self, known: Sequence[Linearization], weights: Array) -> Linearization | None:
        """Return a weighted sum of derivatives at several points, None if chords do not pay."""
        return Linearization.blend(known, weights) if self.chords else None

    @property
    def chords(self) -> bool:
        """Whether mismatches cost much less than their derivatives."""
        return self.orbits.by.chords

    @property
    def undefined(self) -> str:
        """Why equations may have no finite values, as a clause."""
        return self.orbits.by.undefined

    def point(self, correction: Correction, arclength: float, meshes: int = MESHES) -> OrbitPoint:
        """Return a converged correction as a point.

        The tangent points along the row of the correction's constraint. The bordered determinant
        has the same sign for that row as for the tangent, so one matrix gives both.
        """
        orbits, z = self.orbits, correction.z
        at = orbits.nodes(z), orbits.constants(z)
        by = orbits.by.better(*at) if orbits.by.adapts else None
        if by is not None:  # it has a curve of its own, whose unknowns mean the same
            if not meshes:
                raise no_mesh_fits(orbits, z)
            fitting = self.described_by(by)
            again = correct(fitting, z, correction.row)
            if not again.converged:
                raise LostCurveError(again.failure)
            return fitting.point(again, arclength, meshes - 1)
        linearization, bordered = correction.linearization, correction.bordered
        piece = orbits.piece(z)
        if linearization.piece != piece:  # the last step led from one piece to the next
            linearization = self.linearize(correction.z)
            bordered = linearization.bordered(bordered.tangent())
        tangent = bordered.tangent()
        multipliers = self.orbits.eigenvalues(correction.z, linearization)
        return OrbitPoint(
            correction.z,
            tangent,
            arclength,
            self.tests(correction.z, linearization, multipliers, tangent),
            bordered.sign,
            correction.residual,
            bordered.volume,
            linearization,
            piece=piece,
            curve=self,
            monodromy=linearization.monodromy,
            multipliers=multipliers,
            stuck_fraction=orbits.stuck_fraction(z),
        )


class Orbits(OrbitCurve):
    r"""Orbits of a model in free parameters: with one of them a curve, a branch.

    What the orbits are is composed: of a discretization, which has the equations, and of a
    spectrum, which says how perturbations grow. An unknown ``z`` begins with the scaled states,
    :math:`(x_0, ..., x_{m-1}) / (s \sqrt{m})` with the model's state scales s, so that its
    Euclidean length does not depend on the number of phases m. The free parameters follow, each
    over its scale, last those that vary.

    `vary` has those that vary, each with its scale in its own unit; the model's values of what is
    free play no part.
    """

    odd = ("LP",)
    crossing = ("fold", "LP")

    kind = "periodic"
    """What results call them, ``"periodic"`` or ``"equilibrium"``."""

    free_phase = False
    """Whether an orbit may be started anywhere, as a cycle may."""

    gauges = 0
    """Number of conditions that are always met and only direct steps."""

    standing: Standing | None = None
    """Multipliers that test functions leave out."""

    def __init__(
        self, model: Model, vary: Mapping[str, float], by: Discretization, spectrum: Multipliers
    ) -> None:
        self.orbits = self
        self.model = model
        self.spectrum = spectrum
        self._vector = model.vector
        self._let_vary(vary)
        self._describe_by(by)

    def _let_vary(self, vary: Mapping[str, float]) -> None:
        self.varied = dict(vary)
        self.widths = np.array(list(vary.values()), dtype=float)
        self.vary, self.width = list(vary)[-1], float(self.widths[-1])  # of a branch, the one

    def _describe_by(self, by: Discretization) -> None:
        self.by = by
        self.period, self.segments, self.phase = by.period, by.segments, by.phase
        self.flow, self.scales, self.flow_scales = by.flow, by.scales, by.flow_scales
        self.noise = by.noise
        self.free, self.units, self.indices = tuple(by.free), by.units, by.indices
        self.size = self.segments * len(self.scales)
        self._node_scales = np.tile(self.scales, self.segments) * np.sqrt(self.segments)
        self.finer = np.tile(self.scales / by.sizes, self.segments)
        self._constants: tuple[Array | None, Constants | None] = None, None

    def shifted(self, z: Array, tangent: Array) -> tuple[Self, Array, Array]:
        """Return the same orbit and direction, so described that all errors are others."""
        nodes, along, rates = self.nodes(z), self.nodes(tangent), self.free_values(tangent)
        by, nodes, along = self.by.shifted(nodes, self.constants(z), along, rates)
        other = self.described_by(by)
        direction = other.join(along, rates)
        moved = other.join(nodes, self.free_values(z))
        return other, moved, direction / np.linalg.norm(direction)

    def with_period(self, period: int) -> Self:
        """Return the same for orbits of another period."""
        return self.described_by(self.by.with_period(period))

    def described_by(self, by: Discretization, spectrum: Multipliers | None = None) -> Self:
        """Return the same in terms of another discretization, or with another spectrum."""
        other = self._with(spectrum=spectrum or self.spectrum)
        other._describe_by(by)
        return other

    def leaving_out(self, standing: Standing | None) -> Self:
        """Return the same orbits with test functions that leave some multipliers out."""
        return self._with(standing=standing)

    def varying(self, vary: Mapping[str, float]) -> Self:
        """Return the same orbits where other parameters vary."""
        own = {name: unit for name, unit in self.by.free.items() if name not in self.varied}
        other = self._with()
        other._let_vary(vary)
        other._describe_by(self.by.freeing({**own, **vary}))
        return other

    def at_values_of(self, model: Model) -> Self:
        """Return the same orbits where what is not free has the values of a model."""
        return self._with(model=model, _vector=model.vector, _constants=(None, None))

    def _with(self, **changed: Any) -> Self:
        """Return the same orbits with other attributes."""
        other = copy(self)
        vars(other).update(changed, orbits=other)
        return other

    def log_multiplier(self, z: Array) -> float | None:
        """Return the logarithm of the only multiplier that may change, if it is known itself."""
        return None

    def log_multiplier_slope(self, z: Array) -> Array | None:
        """Return its gradient, shape (m n + k,); None if it is not known."""
        return None

    def conditions(self, z: Array) -> Conditions:
        """Return the equations besides those of the discretization."""
        return NO_CONDITIONS

    def magnified(self, z: Array) -> float | Array:
        """Return how many times larger than errors of the states mismatches are, shape (m n,)."""
        return 1.0

    def defect(self, z: Array) -> Array:
        """Return what Newton's method brings to zero, shape (m n + `gauges`,)."""
        return defect_of(self.by.mismatch(self.nodes(z), self.constants(z)), np.zeros(self.gauges))

    def linearize(self, z: Array) -> Linearization:
        """Return the mismatch and its derivatives."""
        nodes, constants = self.nodes(z), self.constants(z)
        transitions = self.by.transitions(nodes, constants)
        settled = self.by.settled(transitions[1], nodes, constants)
        watched = None if self.spectrum.of_product else self.spectrum.matrix
        return Linearization(*transitions, self.conditions(z), watched, settled, self.piece(z))

    @abstractmethod
    def slope(
        self, found: Degeneracy, part: Linearization, z: Array
    ) -> tuple[Array, Array | None, Array | None]:
        """Return the gradient of a function of the watched matrix where it is zero.

        Also along what second derivatives were taken for it, and these, if they were.
        """

    # -- what z means --------------------------------------------------------------------------

    def join(self, nodes: Array, values: float | Sequence[float] | Array) -> Array:
        """Scale an orbit and the values of the free parameters into an unknown.

        Shapes: nodes (m, n).
        """
        return np.concatenate([self.flat(nodes), np.asarray(values) / self.units])

    def unknown(self, nodes: Array, model: Model) -> Array:
        """Return the unknown of an orbit of a model. Shapes: nodes (m, n)."""
        return self.join(nodes, [model.values[name] for name in self.free])

    def adopt(self, other: Orbits, z: Array) -> Array:
        """Return the unknown of an orbit that is described in other scales, or at other phases."""
        nodes = self.by.taken(other.by, other.nodes(z), other.constants(z))
        return self.join(nodes, other.vector(z)[self.indices])

    def free_values(self, z: Array) -> Array:
        """Return the values of the free parameters."""
        return z[self.size :] * self.units

    def values(self, z: Array) -> Array:
        """Return the values of the parameters that vary."""
        return z[-len(self.widths) :] * self.widths

    def value(self, z: Array) -> float:
        """Return the value of the one parameter that varies along a branch."""
        return float(z[-1] * self.width)

    def vector(self, z: Array) -> Array:
        """Return the model's parameter vector."""
        vector = self._vector.copy()
        vector[self.indices] = self.free_values(z)
        return vector

    def model_at(self, z: Array) -> Model:
        """Return the model with the parameter values of an unknown."""
        return self.model.replace(
            **dict(zip(self.free, map(float, self.free_values(z)), strict=True))
        )

    def duration(self, z: Array) -> float | None:
        """Return the duration in seconds where it belongs to the orbit, not to the case."""
        return None

    def durations(self, points: Sequence[OrbitPoint]) -> Array | None:
        """Return the durations along a curve, None where the parameters give them."""
        found = [point.curve.orbits.duration(point.z) for point in points]
        return None if None in found else np.array(found, dtype=float)

    def constants(self, z: Array) -> Constants:
        """Return the coefficients of the flow, evaluated once for each place in turn."""
        known, constants = self._constants
        if constants is None or known is not z:
            constants = self.flow.constants(self.vector(z), self.flow_scales)
            self._constants = z, constants
        return constants

    def flat(self, nodes: Array) -> Array:
        """Scale states at the nodes, shape (m, n), into the first part of an unknown.

        Shapes: nodes (m, n).
        """
        return nodes.ravel() / self._node_scales

    def nodes(self, z: Array) -> Array:
        """Return the states at the nodes, shape (m, n)."""
        return (z[: self.size] * self._node_scales).reshape(self.segments, -1)

    def evenly(self, z: Array, count: int = 0) -> Array:
        """Return the states at equidistant phases, shape (M, n): those at the nodes, or more."""
        nodes = self.nodes(z)
        if type(self.by) is Shooting and count <= len(nodes):  # they are the nodes themselves
            return nodes
        return self.by.evenly(nodes, self.constants(z), count)

    def stuck_fraction(self, z: Array) -> float:
        """Return the fraction of the period in which a contact sticks, NaN if none may."""
        if not isinstance(self.by, SwitchedShooting):
            return np.nan
        return self.by.stuck_fraction(self.nodes(z), self.constants(z))

    def grazing_margin(self, point: OrbitPoint) -> float | None:
        """Return the distance from grazing of slip in the plane; None if no slip is slow."""
        assert isinstance(self.by, SwitchedShooting)
        return self.by.grazing_margin(self.nodes(point.z), self.constants(point.z))

    def piece(self, z: Array) -> Hashable:
        """Return the smooth piece of the curve that an orbit lies on; None if there is only one."""
        return None if self.by.smooth else self.by.piece(self.nodes(z), self.constants(z))

    def bounds(self, *spans: tuple[float, float]) -> list[tuple[int, float, float]]:
        """Return the places of the parameters that vary in the unknown, with scaled bounds."""
        ends = zip(spans, self.widths.tolist(), strict=True)
        return [
            (place, min(span) / width, max(span) / width)
            for place, (span, width) in enumerate(ends, -len(spans))
        ]

    # -- one orbit and another -----------------------------------------------------------------

    def started_near(self, z: Array, reference: Array) -> Array:
        """Return an orbit as it is compared with another one: forced orbits know their phase."""
        return self.beside(z, reference)

    def beside(self, z: Array, reference: Array) -> Array:
        """Return the same orbit with as many turns of its angles as lead nearest to another."""
        if not self.by.angle_periods.any():
            return z
        near, own = self.nodes(reference) / self.scales, self.nodes(z) / self.scales
        gap = wrap_angles(own - near, self.by.angle_periods)
        return self.join((near + gap) * self.scales, self.free_values(z))

    def in_phase(self, z: Array, like: Array) -> Array:
        """Return the same orbit started where it lies nearest to another."""
        return self.started_near(z, like)

    def distance(self, z: Array, like: Array) -> float:
        """Return how far apart two orbits are, wherever they are started, in scaled variables."""
        return float(np.linalg.norm(self.in_phase(z, like) - like))

    # -- perturbations -------------------------------------------------------------------------

    def growth(self, linearization: Linearization) -> float:
        """Return an upper bound of the logarithms of the multipliers' moduli."""
        return self.spectrum.growth(linearization)

    def eigenvalues(self, z: Array, linearization: Linearization) -> Complex:
        """Return the eigenvalues of the matrix that is watched, largest modulus first."""
        return self.spectrum.values(linearization)

    def multipliers(self, point: OrbitPoint) -> Complex:
        """Return the multipliers that results list, shape (n,)."""
        return self.spectrum.whole(point.multipliers)

    def tests(
        self, z: Array, linearization: Linearization, multipliers: Complex, tangent: Array
    ) -> dict[str, float]:
        """Return the functions that change sign at a bifurcation of a branch."""
        tests = evaluate_tests(multipliers, self.spectrum.tests, self.standing)
        return {**tests, "LP": float(tangent[-1])}

    def extrapolated(self, points: Sequence[OrbitPoint], weights: Array) -> Array | None:
        """Return the test functions of the multipliers that weighted sums of transitions have.

        Transitions of segments turn by a fraction of what multipliers do over the period, and
        functions of all multipliers by many times as much. On meshes only those of one can be
        compared, and of cycles there are too many.
        """
        # With the twenty multipliers of a chain a third of the points is saved, with four no time.
        if len(points[0].multipliers) < 8 or self.segments == 1 or self.standing is not None:
            return None
        if self.segments > MANY and (
            self.free_phase or any(point.curve is not points[0].curve for point in points)
        ):
            return None
        parts = [point.linearization for point in points if point.linearization is not None]
        if len(parts) < len(points):
            return None
        try:
            matrices = Linearization.blended_monodromies(parts, weights)
            multipliers = np.linalg.eigvals(matrices).astype(complex)
        except np.linalg.LinAlgError:
            return None
        names = list(points[0].tests)
        found = np.full((len(weights), len(names)), np.nan)
        columns = [names.index(name) for name in self.spectrum.tests]
        found[:, columns] = evaluate_each(multipliers, self.spectrum.tests)
        return found
