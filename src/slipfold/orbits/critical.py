"""Orbits at a bifurcation: what a locus consists of, and the first orbits that emanate there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.continuation.interpolation import POINTS
from slipfold.orbits.bifurcation_types import PAIRED
from slipfold.orbits.discretization import Cut
from slipfold.orbits.eigenvalues import transition
from slipfold.orbits.kinds import Cycles, Equilibria
from slipfold.orbits.linearization import MANY, Conditions, Linearization, defect_of
from slipfold.orbits.marginal import MarginalShooting
from slipfold.orbits.multipliers import on_quotient
from slipfold.orbits.orbit_curve import OrbitCurve, OrbitPoint, Orbits
from slipfold.orbits.shooting import SEGMENT_GROWTH, MeshShooting, Shooting
from slipfold.orbits.test_functions import (
    UNKNOWN,
    Degeneracy,
    critical_pair,
    critical_places,
    degeneracy,
    floquet_multipliers,
)

PARAMETERS = 2
"""Parameters that vary: the last columns of the Jacobian."""

FOURTH = 3e-4
"""Step in scaled variables: truncation leaves 1e-12 then, noise of orbits of 1e-13 5e-10."""


def crossing_values(plain: Linearization) -> Array:
    r"""Return the three numbers that vanish where two families of orbits cross, shape (3,).

    Over two parameters orbits are a surface. Two surfaces cross in a curve, as those of symmetric
    and of other orbits do, where a vector psi is orthogonal to all derivatives of the equations,

    .. math:: \psi^T F_z = 0 .

    Only along the kernel K of the other derivatives this is not met by itself: it leaves three
    numbers, of which with the equations two are more than a curve needs. They are compatible on it
    and solved by least squares. Else a branch point is met in one parameter alone.
    """
    psi, kernel = _crossing(plain)
    return kernel @ (psi @ plain.jacobian) / _size(plain)


def crossing_conditions(orbits: Orbits, plain: Linearization, z: Array) -> Conditions:
    """Return those numbers with their gradients, each a second derivative along one direction."""
    psi, kernel = _crossing(plain)
    gradients = [psi @ _along(orbits, z, direction) for direction in kernel]
    return Conditions(crossing_values(plain), np.array(gradients) / _size(plain))


def crossing_gap(orbits: Orbits, z: Array) -> float:
    """Return the largest of those numbers: how far an orbit is from such a crossing."""
    return float(np.abs(crossing_values(orbits.linearize(z))).max())


def critical_direction(orbits: Orbits, z: Array) -> Array:
    """Return the unit vector along which the states at a crossing may move, parameters held."""
    right = np.linalg.svd(orbits.linearize(z).jacobian[:, :-PARAMETERS])[2][-1]
    return np.asarray(_sign(right) * right)


def _crossing(plain: Linearization) -> tuple[Array, Array]:
    """Return psi and an orthonormal basis of K, both smooth. Shapes: (n,), (3, u).

    Unlike the null vectors of the derivatives by the states, they stay so where a fold is met too.
    """
    left, _, right = np.linalg.svd(plain.jacobian)
    psi, kernel = left[:, -1], right[-1 - PARAMETERS :]
    # Of vectors along no axis of anything, the parts in the kernel turn as it does.
    places = np.outer(np.arange(1.0, kernel.shape[1] + 1), 1 + np.arange(len(kernel)))
    turned, triangle = np.linalg.qr(kernel.T @ (kernel @ np.cos(places)))
    return _sign(psi) * psi, (turned * np.sign(np.diag(triangle))).T


def _sign(vector: Array) -> float:
    """Return the sign that makes a vector smooth where it turns: that along no axis of anything."""
    return float(np.sign(vector @ np.cos(np.arange(1.0, len(vector) + 1)))) or 1.0


def _size(plain: Linearization) -> float:
    return float(np.hypot(1.0, np.linalg.norm(plain.jacobian)))


def _along(orbits: Orbits, z: Array, direction: Array) -> Array:
    """Return the derivative of the Jacobian along a direction, by differences of fourth order."""
    length = float(np.linalg.norm(direction))
    step = FOURTH / length * direction
    near, far = (
        orbits.linearize(z + times * step).jacobian - orbits.linearize(z - times * step).jacobian
        for times in (1, 2)
    )
    return np.asarray((8 * near - far) * (length / (12 * FOURTH)))


class Critical(OrbitCurve):
    """Orbits that are at a bifurcation: with two parameters that vary a curve, a locus.

    The equations are those of the orbits and one more, that the matrix of their spectrum has a
    critical eigenvalue (see `slipfold.orbits.test_functions`), that two families of them
    cross (see `slipfold.orbits.critical`), or that a change of contacts is only just met (see
    `slipfold.orbits.marginal`); an unknown is that of an orbit.

    `condition` is ``"LP"``, ``"PD"``, ``"NS"``, ``"BP"``, ``"GRAZE"``, ``"LIFT"``, ``"STICK"``, or
    ``"HB"`` of equilibria.
    """

    def __init__(self, orbits: Orbits, condition: str) -> None:
        self.orbits = orbits
        self.condition = condition

    def defect(self, z: Array) -> Array:
        """Return what Newton's method brings to zero, one number less than there are unknowns."""
        plain = self.orbits.linearize(z)
        values = np.concatenate([plain.conditions.values, self._values(plain, z)])
        return defect_of(plain.residual, values)

    def linearize(self, z: Array) -> Linearization:
        """Return the defect with its derivatives."""
        plain = self.orbits.linearize(z)
        added = self._conditions(plain, z)
        assert added.gradients is not None
        above = plain.conditions.gradients
        gradients = added.gradients if above is None else np.vstack([above, added.gradients])
        values = np.concatenate([plain.conditions.values, added.values])
        return replace(plain, conditions=replace(added, values=values, gradients=gradients))

    def _values(self, plain: Linearization, z: Array) -> Array:
        """Return how far the condition is from being met, shape (d,)."""
        if self.condition == "BP":
            return crossing_values(plain)
        if isinstance(self.orbits.by, MarginalShooting):
            return self._margin(self.orbits.by, z).values
        logarithm = self._log_multiplier(z)
        return np.array([self._degeneracy(plain).value if logarithm is None else logarithm])

    def _conditions(self, plain: Linearization, z: Array) -> Conditions:
        """Return the condition with its derivatives."""
        if self.condition == "BP":
            return crossing_conditions(self.orbits, plain, z)
        if isinstance(self.orbits.by, MarginalShooting):
            return self._margin(self.orbits.by, z)
        return self._critical_eigenvalue(plain, z)

    def _margin(self, by: MarginalShooting, z: Array) -> Conditions:
        value, by_nodes, by_free = by.condition(self.orbits.nodes(z), self.orbits.constants(z))
        return Conditions(np.array([value]), np.append(by_nodes, by_free)[None])

    def _critical_eigenvalue(self, plain: Linearization, z: Array) -> Conditions:
        logarithm = self._log_multiplier(z)
        slope = None if logarithm is None else self.orbits.log_multiplier_slope(z)
        if logarithm is not None and slope is not None:
            return Conditions(np.array([logarithm]), slope[None])
        found = self._degeneracy(plain)
        gradient, propagated, bent = np.full(len(z), np.nan), None, None
        if np.isfinite(found.value):
            gradient, propagated, bent = self.orbits.slope(found, plain, z)
        return Conditions(np.array([found.value]), gradient[None], propagated, bent)

    def _log_multiplier(self, z: Array) -> float | None:
        """Return what is zero at a fold of cycles in a plane, if it is known directly."""
        return self.orbits.log_multiplier(z) if self.condition == "LP" else None

    def _degeneracy(self, plain: Linearization) -> Degeneracy:
        if not np.isfinite(plain.blocks).all():
            return UNKNOWN
        found = self._measured(plain)
        if len(plain.blocks) <= MANY or not np.isfinite(found.value):
            return found
        # Rounding at each node enters it as its vectors have grown up to there and grow from there.
        factors = self.orbits.spectrum.factors(plain)
        forward, backward = found.propagated(factors)
        ends = np.einsum("jab,rjb->rja", factors, forward)
        grown = np.linalg.norm(ends, axis=2) * np.linalg.norm(backward, axis=2)
        size = float(np.sqrt(1 + (grown**2).sum()))
        return Degeneracy(found.value / size, found.left / size, found.right)

    def _measured(self, plain: Linearization) -> Degeneracy:
        """Return how far the matrix is from being critical."""
        return degeneracy(self.condition, plain.monodromy, self._pair(plain))

    def _pair(self, plain: Linearization) -> tuple[int, int] | None:
        """Return the places of the critical pair where others stand beside it, else None."""
        standing = self.orbits.standing
        if standing is None or self.condition not in PAIRED:
            return None
        places = critical_places(self.condition, floquet_multipliers(plain.monodromy), standing)
        return (int(places[0]), int(places[1])) if len(places) else None

    def critical_multiplier(self, plain: Linearization) -> complex | None:
        """Return the upper multiplier of that pair."""
        pair = self._pair(plain)
        return None if pair is None else complex(floquet_multipliers(plain.monodromy)[pair[0]])

    def renewed(self, points: Sequence[OrbitPoint]) -> tuple[Any, list[OrbitPoint]] | None:
        """Return the last points as described by what fits the last one, None if this does.

        What stands is known by where it was last, as it lies beside the critical pair.
        """
        found, last = super().renewed(points), points[-1]
        standing = last.curve.orbits.standing
        moved = None if standing is None else standing.moved(last.multipliers)
        if found is not None or moved is None:
            return found
        other = last.curve.with_orbits(last.curve.orbits.leaving_out(moved))
        own = [item for item in points[-POINTS:] if item.resembles(last)]
        return other, [replace(item, curve=other) for item in own]

    def pair_tangents(self, z: Array) -> list[Array]:
        """Return the tangents of the two loci that cross where two pairs are critical.

        Nothing where there is one pair only. Shapes: z (u,); returns (u,).
        """
        plain = self.orbits.linearize(z)
        multipliers = floquet_multipliers(plain.monodromy)
        places, pairs = np.arange(len(multipliers)), list[tuple[int, int]]()
        for _ in range(2):
            pair = critical_pair(multipliers[places])
            if pair is None:
                return []
            pairs.append((int(places[pair[0]]), int(places[pair[1]])))
            places = np.delete(places, pair)
        found = [degeneracy(self.condition, plain.monodromy, pair) for pair in pairs]
        slopes = [self.orbits.slope(item, plain, z)[0] for item in found]
        return [np.linalg.svd(np.vstack([plain.jacobian, slope]))[2][-1] for slope in slopes]

    def aligned(self, guess: Array, known: Array) -> Array:
        """Return a guess whose phase is that of an orbit nearby."""
        return self.orbits.aligned(guess, known)


def doubled_orbit(orbits: Orbits, z: Array, residual: float) -> OrbitPoint:
    """Return an orbit at a period doubling, passed twice, with the direction of doubled ones.

    That is the critical direction, which changes sign from one period to the next. To first order
    no parameter changes.
    """
    part = orbits.linearize(z)
    values, vectors = np.linalg.eig(part.product)
    direction = vectors[:, np.argmin(np.abs(values + 1))].real
    along = [direction]
    for block in part.blocks[:-1]:
        along.append(block @ along[-1])
    nodes, moved, scales = orbits.nodes(z), np.array(along), orbits.scales
    child = orbits.with_period(2 * orbits.period)
    longer = np.linalg.norm(np.roll(part.blocks, -1, axis=0) @ part.blocks, axis=(1, 2))
    if type(orbits.by) is Shooting and longer.max() > SEGMENT_GROWTH:
        child = orbits.described_by(MeshShooting.with_scales_of(child.by))
        given = nodes, orbits.constants(z), moved * scales, np.zeros(len(orbits.units))
        nodes, moved = orbits.by.moved_to(child.by, *given)
        moved /= scales
    else:  # a segment of the child is two of the parent, or one of either round
        own = child.by.start % orbits.period
        same = np.abs(orbits.by.start[None, :] - own[:, None]).argmin(axis=1)
        nodes, moved = nodes[same], moved[same]
    moved[child.by.start >= orbits.period] *= -1.0
    tangent = np.concatenate([moved.ravel(), np.zeros(len(orbits.units))])
    # The largest component starts positive: of the two copies always the same one.
    tangent *= np.sign(direction[np.abs(direction).argmax()])
    doubled = child.join(nodes, orbits.free_values(z))
    if isinstance(child, Cycles):  # tangents are orthogonal to the flow; one node may lead along
        flow = child.flow_direction(doubled)
        tangent -= (flow @ tangent) * flow
    tangent /= np.linalg.norm(tangent)
    return child.derived_point(doubled, tangent, 0.0, part.monodromy @ part.monodromy, residual)


def hopf_cycle(
    orbits: Equilibria,
    z: Array,
    residual: float,
    method: Callable[[Array], Cut] = lambda jacobian: Shooting,
    *,
    pair: int = 0,
    frequency: float | None = None,
    vector: Complex | None = None,
) -> OrbitPoint:
    """Return an equilibrium at a Hopf point as a cycle, with the direction of emanating cycles.

    That is the critical eigenvector turning once. `method` says how the cycle is cut, from the
    derivatives of the rates a round. Pairs are numbered by their distance from the imaginary axis;
    a frequency in rad/s selects one of several that are equally near, and where pairs share it a
    combination of their vectors may be given, shape (n,).
    """
    unit, jacobian = orbits.unit(z), orbits.jacobian(z)
    values, vectors = np.linalg.eig(jacobian)
    away = np.abs(values.real if frequency is None else values - 1j * frequency * unit)
    critical = int(np.where(values.imag > 0, away, np.inf).argsort()[pair])
    turn = 2 * np.pi / float(values[critical].imag)
    paced = orbits.model.replace(duration=unit * turn)
    child = Cycles(paced, orbits.varied, by=method(jacobian * turn))
    q, m = vectors[:, critical] if vector is None else vector, child.segments
    turns = np.exp(2j * np.pi * np.arange(m) / m)  # both discretizations begin with equal segments
    turning = np.real(q * turns[:, None]).ravel()
    tangent = np.concatenate([turning, np.zeros(len(child.units))])
    nodes = np.tile(orbits.nodes(z), (m, 1))
    return child.derived_point(
        child.join(nodes, [unit * turn, *orbits.values(z)]),
        tangent / np.linalg.norm(tangent),
        0.0,
        on_quotient(transition(jacobian * turn), np.real(1j * q)),
        residual,
    )
