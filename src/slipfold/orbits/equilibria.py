"""Equilibria of an autonomous model."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from slipfold.arrays import Array
from slipfold.models.model import Model
from slipfold.orbits.discretisations.vector_field import VectorField
from slipfold.orbits.linearisation import NO_CONDITIONS, Linearisation, defect_of
from slipfold.orbits.orbit_curve import Orbits, Values
from slipfold.orbits.orbit_point import OrbitPoint
from slipfold.orbits.spectrum.degeneracy import Degeneracy
from slipfold.orbits.spectrum.eigenvalues import Eigenvalues, Paced, eigenvalues_of


class Equilibria(Orbits):
    """Orbits that stand still: their equations are those of the vector field itself.

    The rates are taken per unit of time, which the spectrum chooses: where they are zero it plays
    no part.

    The model's ``duration`` is that unit, or the longest one. Along a branch eigenvalues are seen
    as multipliers over it.
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

    def unit(self, z: Array) -> float:
        """Return the unit of time in seconds."""
        return float(self.vector(z)[self.model.parameter_index("duration")])

    def duration(self, z: Array) -> float | None:
        """Return the unit of time in seconds, where results state multipliers over it."""
        return self.unit(z) if self.spectrum.tells_unit else None

    def model_at(self, z: Array) -> Model:
        """Return the model with the parameter values of an unknown and its unit of time."""
        model, duration = super().model_at(z), self.duration(z)
        return model if duration is None else model.replace(duration=duration)

    def jacobian(self, z: Array) -> Array:
        """Return the derivatives of the rates per unit of time, shape (n, n), in scaled states."""
        return self.by.jacobian(self.nodes(z), self.constants(z))

    def multipliers(self, point: OrbitPoint) -> Values:
        """Return the multipliers that results list, shape (n,)."""
        if self.spectrum.tells_unit:
            return point.multipliers
        units = self.model.values["duration"] / self.unit(point.z)
        return np.exp(eigenvalues_of(self.jacobian(point.z)) * units)

    def defect(self, z: Array) -> Array:
        """Return what Newton's method brings to zero: the rates per unit of time, shape (n,)."""
        return defect_of(self.by.rates(self.nodes(z), self.constants(z)), NO_CONDITIONS.values)

    def linearise(self, z: Array) -> Linearisation:
        """Return the rates and their derivatives per unit of time."""
        nodes, constants = self.nodes(z), self.constants(z)
        return Linearisation(
            self.by.rates(nodes, constants),
            (np.eye(len(self.scales)) + self.by.jacobian(nodes, constants))[None],
            self.by.pulls(nodes, constants)[None],
            watched=self.spectrum.matrix,
        )

    def slope(self, found: Degeneracy, part: Linearisation, z: Array) -> tuple[Array, None, None]:
        """Return the gradient of a function of the matrix that the spectrum watches."""
        left, right = self.spectrum.lifted(found, part)
        second, mixed = self.by.curvatures(self.nodes(z), self.constants(z), right)
        along_state = np.einsum("ra,rab->b", left, second)
        along_free = np.einsum("ra,rak->k", left, mixed)
        return np.concatenate([along_state, along_free]), None, None
