"""Orbits at a bifurcation: what a locus consists of."""

from __future__ import annotations

from dataclasses import replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.orbits.crossing import crossing_conditions, crossing_values
from slipfold.orbits.discretisations.discretisation import Discretisation
from slipfold.orbits.linearisation import MANY, Conditions, Linearisation, defect_of
from slipfold.orbits.orbit_curve import OrbitCurve, Orbits
from slipfold.orbits.spectrum.degeneracy import (
    UNKNOWN,
    Degeneracy,
    critical_pair,
    degeneracy,
)
from slipfold.orbits.spectrum.floquet import floquet_multipliers
from slipfold.orbits.stick_slip.marginal_shooting import MarginalShooting

Values = NDArray[np.complex128]


class Critical(OrbitCurve):
    """Orbits that are at a bifurcation: with two parameters that vary a curve, a locus.

    The equations are those of the orbits and one more, that the matrix of their spectrum has a
    critical eigenvalue (see `slipfold.orbits.spectrum.degeneracy`), that two families of them
    cross (see `slipfold.orbits.crossing`), or that a change of contacts is only just met (see
    `slipfold.orbits.stick_slip.marginal_shooting`); an unknown is that of an orbit.

    `condition` is ``"LP"``, ``"PD"``, ``"NS"``, ``"BP"``, ``"GRAZE"``, ``"LIFT"``, ``"STICK"``, or
    ``"HB"`` of equilibria.
    """

    def __init__(self, orbits: Orbits, condition: str) -> None:
        self.orbits = orbits
        self.condition = condition

    def defect(self, z: Array) -> Array:
        """Return what Newton's method brings to zero, one number less than there are unknowns."""
        plain = self.orbits.linearise(z)
        if self.condition == "BP":
            values = crossing_values(plain)
        elif isinstance(self.orbits.by, MarginalShooting):
            values = self._margin(self.orbits.by, z).values
        else:
            logarithm = self._log_multiplier(z)
            value = self._degeneracy(plain).value if logarithm is None else logarithm
            values = np.array([value])
        return defect_of(plain.residual, np.append(plain.conditions.values, values))

    def linearise(self, z: Array) -> Linearisation:
        """Return the defect with its derivatives."""
        plain = self.orbits.linearise(z)
        if self.condition == "BP":
            added = crossing_conditions(self.orbits, plain, z)
        elif isinstance(self.orbits.by, MarginalShooting):
            added = self._margin(self.orbits.by, z)
        else:
            added = self._critical_eigenvalue(plain, z)
        assert added.gradients is not None
        above = plain.conditions.gradients
        gradients = added.gradients if above is None else np.vstack([above, added.gradients])
        values = np.append(plain.conditions.values, added.values)
        return replace(plain, conditions=replace(added, values=values, gradients=gradients))

    def _margin(self, by: MarginalShooting, z: Array) -> Conditions:
        value, by_nodes, by_free = by.condition(self.orbits.nodes(z), self.orbits.constants(z))
        return Conditions(np.array([value]), np.append(by_nodes, by_free)[None])

    def _critical_eigenvalue(self, plain: Linearisation, z: Array) -> Conditions:
        logarithm = self._log_multiplier(z)
        if logarithm is not None:
            slope = self.orbits.log_multiplier_slope(z)
            return Conditions(np.array([logarithm]), slope[None])
        found = self._degeneracy(plain)
        gradient, carried, bent = np.full(len(z), np.nan), None, None
        if np.isfinite(found.value):
            gradient, carried, bent = self.orbits.slope(found, plain, z)
        return Conditions(np.array([found.value]), gradient[None], carried, bent)

    def _log_multiplier(self, z: Array) -> float | None:
        """Return what is zero at a fold of cycles in a plane, if it is known directly."""
        return self.orbits.log_multiplier(z) if self.condition == "LP" else None

    def _degeneracy(self, plain: Linearisation) -> Degeneracy:
        if not np.isfinite(plain.blocks).all():
            return UNKNOWN
        found = degeneracy(self.condition, plain.monodromy)
        if len(plain.blocks) <= MANY or not np.isfinite(found.value):
            return found
        # Rounding at each node enters it as its vectors have grown up to there and grow from there.
        factors = self.orbits.spectrum.factors(plain)
        forward, backward = found.carried(factors)
        ends = np.einsum("jab,rjb->rja", factors, forward)
        grown = np.linalg.norm(ends, axis=2) * np.linalg.norm(backward, axis=2)
        size = float(np.sqrt(1 + (grown**2).sum()))
        return Degeneracy(found.value / size, found.left / size, found.right)

    def pair_tangents(self, z: Array) -> list[Array]:
        """Return the tangents of the two loci that cross where two pairs are critical.

        Nothing where there is one pair only. Shapes: z (u,); returns (u,).
        """
        plain = self.orbits.linearise(z)
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

    def shifted(self, z: Array, tangent: Array) -> tuple[Self, Array, Array]:
        """Return the same orbit and direction, so described that all errors are others."""
        orbits, moved, direction = self.orbits.shifted(z, tangent)
        return type(self)(orbits, self.condition), moved, direction

    def described_by(self, by: Discretisation) -> Self:
        """Return the same in terms of another discretisation."""
        return type(self)(self.orbits.described_by(by), self.condition)

    def aligned(self, guess: Array, known: Array) -> Array:
        """Return a guess whose phase is that of an orbit nearby."""
        return self.orbits.aligned(guess, known)

    def tests(
        self, z: Array, linearisation: Linearisation, multipliers: Values, tangent: Array
    ) -> dict[str, float]:
        """Return no functions: nothing is watched unless someone says what."""
        return {}
