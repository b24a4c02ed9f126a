"""Kinds of orbits: periodic orbits of forced models, cycles and equilibria of autonomous ones."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from slipfold.arrays import Array, Complex, Indices
from slipfold.continuation.newton import NEWTON
from slipfold.errors import InputError
from slipfold.flow.equations import Constants
from slipfold.flow.scales import rounded_jacobians
from slipfold.models.model import Model
from slipfold.orbits.discretization import Cut, Discretization
from slipfold.orbits.eigenvalues import Cayley, Eigenvalues, Paced, eigenvalues_of
from slipfold.orbits.linearization import MANY, Conditions, Linearization
from slipfold.orbits.multipliers import CycleMultipliers, Multipliers
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.orbits.shooting import SEGMENTS, Shooting
from slipfold.orbits.test_functions import Degeneracy


class VectorField(Discretization):
    """The rates of one state, per unit of time in scaled states, and their derivatives."""

    noise = 100 * NEWTON.still
    """What derivatives that are those near a solution make of test functions."""

    remainder = 1e-12
    """Nothing is integrated, and so errors are those of rounding."""

    def __init__(self, model: Model, free: Mapping[str, float]) -> None:
        super().__init__(model, free, 1, np.array([0.0, 1.0]))

    def with_period(self, period: int) -> VectorField:
        """Return the same: equilibria repeat after any time."""
        return self

    def with_other_errors(self, nodes: Array, constants: Constants) -> VectorField:
        """Return this discretization with other state scales, so that rounding errors differ."""
        other = VectorField(self.model, self.free)
        factors = 1.3 ** np.arange(len(self.scales))  # no powers of two, so that rounding differs
        other.measure_in(self.scales * factors)
        return other

    def mismatch(self, nodes: Array, constants: Constants) -> Array:
        """Return the rates, shape (1, n)."""
        return self.rates(nodes, constants)

    def transitions(self, nodes: Array, constants: Constants) -> tuple[Array, Array, Array]:
        """Return the rates and their derivatives, those by the states as changes of the states."""
        rates, slopes, by_parameters = self.changing_rates(nodes, constants)
        return rates, np.eye(len(self.scales)) + slopes, by_parameters

    def jacobian(self, nodes: Array, constants: Constants) -> Array:
        """Return the derivatives of the rates by the scaled states, shape (n, n)."""
        return self.flow.jacobians(nodes, self.start, constants)[0] * self.ratios

    def states(self, nodes: Array, constants: Constants, phases: Array) -> Array:
        """Return the same state at any phases, shape (q, n)."""
        return np.repeat(nodes, len(phases), axis=0)

    def propagate_to(
        self, nodes: Array, constants: Constants, phases: Array
    ) -> tuple[Indices, Array, Array, Array]:
        """Return the same state at any phases, with its derivatives."""
        count, n = len(phases), nodes.shape[1]
        vectors = np.zeros((count, n, len(self.units)))
        states = self.states(nodes, constants, phases)
        return np.zeros(count, dtype=np.intp), states, np.tile(np.eye(n), (count, 1, 1)), vectors

    def curvatures(self, nodes: Array, constants: Constants, vectors: Array) -> tuple[Array, Array]:
        """Return the derivatives of ``jacobian @ vectors``."""
        r, _, n = vectors.shape
        states, along = np.tile(nodes, (r, 1)), constants.rates[:, self.indices]
        second, mixed = self.flow.curvatures(
            states, np.zeros(r), constants, vectors.reshape(r, n) * self.scales, along
        )
        return (second * self.ratios)[:, None], (mixed * self.parameter_units)[:, None]

    def cubes(self, nodes: Array, constants: Constants, vectors: Array) -> Array:
        """Return the third derivatives of the rates along vectors, in scaled states."""
        r, _, n = vectors.shape
        along, states = vectors.reshape(r, n) * self.scales, np.tile(nodes, (r, 1))
        third = self.flow.powers(states, np.zeros(r), constants, along)[1]
        return np.asarray((third / self.scales)[:, None])


class PeriodicOrbits(Orbits):
    """Orbits that repeat after a time.

    `by` makes the discretization of model, free parameters, period and number of segments.
    """

    def __init__(
        self,
        model: Model,
        vary: Mapping[str, float],
        period: int = 1,
        segments: int = SEGMENTS,
        by: Cut = Shooting,
    ) -> None:
        own = {"duration": model.values["duration"]} if self.free_phase else {}
        spectrum = CycleMultipliers() if self.free_phase else Multipliers()
        super().__init__(model, vary, by(model, {**own, **vary}, period, segments), spectrum)


class ForcedOrbits(PeriodicOrbits):
    """Orbits whose duration is known, as the forcing's period is."""

    def slope(self, found: Degeneracy, part: Linearization, z: Array) -> tuple[Array, Array, Array]:
        """Return the gradient of a function of the monodromy matrix."""
        forward, backward = found.propagated(part.blocks)
        return self.by.changed(forward, backward, self.nodes(z), self.constants(z))

    def in_phase(self, z: Array, like: Array) -> Array:
        """Shift the orbit by whole forcing periods, so that it is closest to another."""
        nodes, constants = self.nodes(z), self.constants(z)
        started = [z]
        for turn in range(1, self.period):
            moved = self.by.states(nodes, constants, self.by.start + turn)
            started.append(np.concatenate([self.flat(moved), z[self.size :]]))
        started = [self.beside(copy, like) for copy in started]
        return min(started, key=lambda copy: float(np.linalg.norm(copy - like)))


STANDING = 1e-9
"""A cycle whose nodes differ by less, in scaled states, is an equilibrium: it has no phase."""


def _log_determinant(factors: Array) -> float:
    """Return the logarithm of the determinant of a product of matrices in a plane.

    Each determinant is a difference of products that are known to rounding. A sum within what that
    leaves is zero: the multiplier of a conservative system is one. Shapes: factors (m, 2, 2).

    >>> _log_determinant(np.array([[[1e4, 1.0], [1e4, 1.0 + 1e-4 * (1 + 1e-9)]]]))
    0.0
    """
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        logarithms = np.linalg.slogdet(factors)[1]
        sizes = np.linalg.norm(factors, axis=(1, 2)) ** 2 / np.exp(logarithms)
        total, noise = float(logarithms.sum()), float(np.finfo(float).eps * sizes.sum())
    return 0.0 if abs(total) <= noise < 1 else total


class Cycles(PeriodicOrbits):
    """Orbits with the duration of one round as a free parameter, and with no phase of their own.

    A cycle may be started anywhere on it: Newton's steps and tangents are kept orthogonal to the
    flow, which fixes the phase without a condition to be met.

    The model's ``duration`` sets the scale of the duration; `period` is the number of rounds.
    """

    spectrum: CycleMultipliers
    free_phase, gauges = True, 1

    def duration(self, z: Array) -> float:
        """Return the duration of one round in seconds."""
        return float(self.free_values(z)[0])

    def conditions(self, z: Array) -> Conditions:
        """Return the phase condition: steps are orthogonal to the flow. Its residual is zero."""
        return Conditions(np.zeros(1), self.flow_direction(z)[None])

    def eigenvalues(self, z: Array, linearization: Linearization) -> Complex:
        """Return the multipliers besides that of the flow's direction, largest modulus first.

        In a plane it is one, and by Liouville's formula it is the exponential of the divergence
        integrated over a round: known also where a segment lasts many times the fastest decay.
        Where it is not integrated, it is the product of the transitions' determinants.
        """
        logarithm = self.log_multiplier(z)
        if logarithm is None and len(self.scales) == 2:
            logarithm = _log_determinant(linearization.factors)
        if logarithm is None:
            return super().eigenvalues(z, linearization)
        with np.errstate(over="ignore"):
            return np.array([np.exp(logarithm)], dtype=complex)

    def log_multiplier(self, z: Array) -> float | None:
        """Return the logarithm of the only multiplier besides that of the flow, if it is known."""
        if len(self.scales) != 2:
            return None
        return self.by.divergence(self.nodes(z), self.constants(z))

    def log_multiplier_slope(self, z: Array) -> Array | None:
        """Return its gradient, shape (m n + k,); None if it is not known."""
        slopes = self.by.divergence_slope(self.nodes(z), self.constants(z))
        if slopes is None:
            return None
        by_nodes, by_free = slopes
        return np.concatenate([by_nodes.ravel() * np.sqrt(self.segments), by_free])

    def flow_direction(self, z: Array) -> Array:
        """Return the unit vector of a phase shift; zero at an equilibrium."""
        rates = self.by.rates(self.nodes(z), self.constants(z))
        with np.errstate(over="ignore", invalid="ignore"):  # far away rates or squares overflow
            size = float(np.linalg.norm(rates)) or 1.0
            return np.concatenate([rates.ravel() / size, np.zeros(len(self.units))])

    def slope(self, found: Degeneracy, part: Linearization, z: Array) -> tuple[Array, Array, Array]:
        """Return the gradient of a function of the matrix on the quotient, whose basis turns."""
        nodes, constants = self.nodes(z), self.constants(z)
        if len(nodes) > MANY:
            forward, backward, weights = self.spectrum.propagated(found, part)
        else:
            lifted, weights = self.spectrum.lifted(found, part)
            forward, backward = lifted.propagated(part.blocks)
        gradient, propagated, bent = self.by.changed(forward, backward, nodes, constants)
        rates, slopes, by_parameters = self.by.changing_rates(nodes[: len(weights)], constants)
        turned = weights / np.linalg.norm(rates, axis=1)[:, None]
        by_nodes = np.einsum("ja,jab->jb", turned, slopes).ravel() * np.sqrt(self.segments)
        gradient[: len(by_nodes)] -= by_nodes
        gradient[self.size :] -= np.einsum("ja,jak->k", turned, by_parameters)
        return gradient, propagated, bent

    def aligned(self, guess: Array, known: Array) -> Array:
        """Return a guess whose phase is that of a cycle nearby.

        Corrections leave the phase as it is in the guess, and extrapolation would magnify small
        differences from one cycle to the next. Between aligned cycles lies no shift along the
        flow, to the third order of their distance.
        """
        for _ in range(3):  # each leaves the square of the last
            direction = self.flow_direction(0.5 * (guess + known))
            guess = guess - (direction @ (guess - known)) * direction
        return guess

    def stands(self, z: Array) -> bool:
        """Whether a cycle has no amplitude: it is an equilibrium."""
        nodes = self.nodes(z)
        apart = np.ptp(nodes / self.scales, axis=0)
        if len(nodes) == 1:  # of one segment, which contacts that change cut further
            apart = np.abs(self.by.rates(nodes, self.constants(z)))
        return bool(apart.max() < STANDING)

    def started_near(self, z: Array, reference: Array) -> Array:
        """Return the same cycle started where it lies nearest to another."""
        if self.stands(z):
            return z
        nodes = self.by.started_near(self.nodes(z), self.constants(z), self.nodes(reference))
        return self.join(nodes, self.free_values(z))


class Equilibria(Orbits):
    """Equilibria: their equations are those of the vector field itself.

    The rates are taken per unit of time, which the spectrum chooses. The model's ``duration`` is
    that unit, or the longest one; results state eigenvalues as multipliers over it.
    """

    by: VectorField
    spectrum: Eigenvalues
    kind = "equilibrium"

    def __init__(
        self, model: Model, vary: Mapping[str, float], spectrum: Eigenvalues | None = None
    ) -> None:
        super().__init__(model, vary, VectorField(model, vary), spectrum or Paced())

    def vector(self, z: Array) -> Array:
        """Return the model's parameter vector, with the unit of time of this equilibrium."""
        vector = super().vector(z)
        jacobian = self.by.jacobian(self.nodes(z), self.flow.constants(vector))
        vector[self.model.parameter_index("duration")] *= self.spectrum.unit(jacobian)
        return vector

    def frequency(self, z: Array, multiplier: complex) -> float:
        """Return the frequency in rad/s that a multiplier on the unit circle stands for."""
        return self.spectrum.turn(multiplier) / self.unit(z)

    def multiplier(self, z: Array, frequency: float) -> complex:
        """Return the multiplier on the unit circle that stands for a frequency in rad/s."""
        return self.spectrum.turned(frequency * self.unit(z))

    def unit(self, z: Array) -> float:
        """Return the unit of time in seconds."""
        return float(self.vector(z)[self.model.parameter_index("duration")])

    def duration(self, z: Array) -> float | None:
        """Return the unit of time in seconds, where results state multipliers over it."""
        return self.unit(z) if self.spectrum.gives_unit else None

    def model_at(self, z: Array) -> Model:
        """Return the model with the parameter values of an unknown and its unit of time."""
        model, duration = super().model_at(z), self.duration(z)
        return model if duration is None else model.replace(duration=duration)

    def jacobian(self, z: Array) -> Array:
        """Return the derivatives of the rates per unit of time, shape (n, n), in scaled states."""
        return self.by.jacobian(self.nodes(z), self.constants(z))

    def magnified(self, z: Array) -> Array:
        """Return how fast each rate changes, where that is more than once in the unit of time."""
        return np.maximum(1.0, np.abs(self.jacobian(z)).sum(axis=1))

    def fastest(self, z: Array) -> float:
        """Return the fastest rate per unit of time, at least one: the Jacobian's size if balanced.

        That is what rounding errors of the multipliers' exponents are relative to.
        """
        return max(1.0, float(np.abs(eigenvalues_of(self.jacobian(z))).max()))

    def rounding(self, z: Array) -> float:
        """Return what rounding of the Jacobian does to the pair of eigenvalues nearest critical."""
        at = self.nodes(z), self.by.start, self.constants(z)
        jacobians = self.flow.jacobians(*at)
        change = rounded_jacobians(self.flow, *at, jacobians) * self.by.ratios
        values, right = np.linalg.eig(jacobians[0] * self.by.ratios)
        left, nearest = np.linalg.pinv(right), int(np.abs(values.real).argmin())
        return float(2 * np.abs(left[nearest]) @ change @ np.abs(right[:, nearest]))

    def multipliers(self, point: OrbitPoint) -> Complex:
        """Return the multipliers that results list, shape (n,)."""
        if self.spectrum.gives_unit:
            return point.multipliers
        units = self.model.values["duration"] / self.unit(point.z)
        return np.exp(eigenvalues_of(self.jacobian(point.z)) * units)

    def slope(self, found: Degeneracy, part: Linearization, z: Array) -> tuple[Array, None, None]:
        """Return the gradient of a function of Cayley's transform: others have no derivative."""
        assert isinstance(self.spectrum, Cayley)
        backward, forward = (item[:, None] for item in self.spectrum.lifted(found, part))
        return self.by.changed(forward, backward, self.nodes(z), self.constants(z))[0], None, None


def orbits_of(
    model: Model,
    vary: Mapping[str, float],
    period: int,
    segments: int,
    *,
    resting: bool = False,
    by: Cut = Shooting,
) -> Orbits:
    """Return the orbits of a model: forced orbits, or of an autonomous one cycles or equilibria."""
    if model.forced:
        return ForcedOrbits(model, vary, period, segments, by)
    return Equilibria(model, vary) if resting else Cycles(model, vary, period, segments, by)


def orbits_at(
    model: Model, period: int = 1, segments: int = SEGMENTS, *, by: Cut = Shooting
) -> Orbits:
    """Return orbits of a model at its own parameter values: the choice does not matter."""
    return orbits_of(model, {any_parameter(model): 1.0}, period, segments, by=by)


def any_parameter(model: Model) -> str:
    """Return a parameter to find orbits with, or raise."""
    for item in model.parameters:
        if model.forced or item.name != "duration":
            return item.name
    raise InputError(f"{model.name} has no parameter; give it one, used or not")
