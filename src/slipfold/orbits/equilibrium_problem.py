"""Equilibria of an autonomous model in one parameter."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from slipfold.models.model import Model
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.linearisation import NO_CONDITIONS, Linearisation, defect_of
from slipfold.orbits.resting import Resting

__all__ = ["EquilibriumProblem", "transition", "unit_of_time"]

Array = NDArray[np.float64]

ANGLE = 0.8
"""What the fastest rate makes in the unit of time: angles far from the half turn that would look
like a period doubling, growth by little more than two."""

SLOWEST = 1e-3
"""Decay this much faster than everything else does not set the unit of time."""


class EquilibriumProblem(Resting, PeriodicProblem):
    r"""Equilibria in one free parameter.

    An unknown ``z`` holds the scaled state and the scaled parameter; the equations are those of the
    vector field itself, so nothing is integrated. The multipliers are those of the flow over a unit
    of time :math:`\tau`, :math:`e^{\lambda \tau}` of the eigenvalues: they leave the unit circle
    where eigenvalues cross the imaginary axis. So a Hopf point is a Neimark-Sacker point, a fold a
    fold, and what watches orbits serves equilibria. What has no counterpart, a multiplier at -1, is
    not watched.

    The unit of time keeps pace: where eigenvalues turn or grow faster than at the beginning of the
    branch it is shorter, so that no angle ever wraps.

    Parameters
    ----------
    model
        The model; its value of `vary` plays no part, its ``duration`` is the longest unit of time.
    vary
        Name of the free parameter.
    period
        Always 1.
    width
        Scale of the parameter, in its unit.
    segments
        Always 1.
    offset
        Not zero: with other scales of the states.
    """

    kind = "equilibrium"

    def __init__(
        self,
        model: Model,
        vary: str,
        period: int,
        width: float,
        segments: int = 1,
        offset: float = 0.0,
    ) -> None:
        super().__init__(model, vary, period, width, segments)
        if offset:
            self.take_other_scales()

    def vector(self, z: Array) -> Array:
        """Return the model's parameter vector, with the unit of time of this equilibrium."""
        vector = super().vector(z)
        jacobian = self.jacobian(z, self.flow.constants(vector))
        if np.isfinite(jacobian).all():
            values = np.linalg.eigvals(jacobian)
            fastest = max(float(np.abs(values.imag).max()), float(values.real.max()))
            vector[self.model.parameter_index("duration")] *= ANGLE / max(ANGLE, fastest)
        return vector

    def duration(self, z: Array) -> float:
        """Return the unit of time in seconds."""
        return float(self.vector(z)[self.model.parameter_index("duration")])

    def model_at(self, z: Array) -> Model:
        """Return the model with the parameter values of an unknown and its unit of time."""
        return super().model_at(z).replace(duration=self.duration(z))

    def defect(self, z: Array) -> Array:
        """Return what Newton's method brings to zero: the rates per unit of time, shape (n,)."""
        return defect_of(self.rates(z, self.constants(z)), NO_CONDITIONS.values)

    def linearise(self, z: Array) -> Linearisation:
        """Return the rates and their derivatives per unit of time.

        The unit may be taken as constant: where the rates are zero it plays no part.
        """
        constants = self.constants(z)
        return _RestLinearisation(
            self.rates(z, constants),
            (np.eye(len(self.scales)) + self.jacobian(z, constants))[None],
            self.pulls(z, constants)[None],
        )

    def in_phase(self, z: Array, like: Array) -> Array:
        """Return an equilibrium, which is the same at all times."""
        return z

    def tests(
        self,
        z: Array,
        linearisation: Linearisation,
        multipliers: NDArray[np.complex128],
        tangent: Array,
    ) -> dict[str, float]:
        """Return the functions that change sign at a bifurcation.

        Shapes: multipliers (n,).
        """
        tests = super().tests(z, linearisation, multipliers, tangent)
        del tests["PD"]
        return tests


def transition(jacobian: Array) -> Array:
    """Return the matrix of the flow over a time, shape (n, n).

    Shapes: jacobian (n, n).
    """
    from scipy.linalg import expm  # a tenth of a second to import, for equilibria alone

    if not np.isfinite(jacobian).all():
        return np.full_like(jacobian, np.nan)
    return np.asarray(expm(jacobian), dtype=float)


class _RestLinearisation(Linearisation):
    """Rates of an equilibrium and their derivatives per unit of time."""

    @cached_property
    def monodromy(self) -> Array:
        """The matrix of the flow over the unit of time."""
        return transition(self.blocks[0] - np.eye(self.blocks.shape[1]))


def unit_of_time(model: Model, jacobian: Array) -> float:
    """Return a time over which the multipliers of an equilibrium are well told apart, in s.

    Shapes: jacobian (n, n).
    """
    if not np.isfinite(jacobian).all():
        return 1.0
    values = np.linalg.eigvals(jacobian)
    turning, growing = float(np.abs(values.imag).max()), float(values.real.max())
    rate = max(turning, growing, float(np.sort(np.abs(values))[0]))
    rate = max(rate, min(float(np.abs(values).max()), rate / SLOWEST))
    return ANGLE / rate if rate > 0 and math.isfinite(rate) else 1.0
