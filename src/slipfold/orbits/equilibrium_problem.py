"""Equilibria of an autonomous model in one parameter, as fixed points of its flow."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from slipfold.models.model import Model
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.linearisation import Linearisation

__all__ = ["EquilibriumProblem", "unit_of_time"]

Array = NDArray[np.float64]

ANGLE = 0.8
"""What the fastest rate makes in the unit of time: angles far from the half turn that would look
like a period doubling, growth by little more than two."""

SLOWEST = 1e-3
"""Decay this much faster than everything else does not set the unit of time."""


class EquilibriumProblem(PeriodicProblem):
    r"""Equilibria in one free parameter.

    An equilibrium is a fixed point of the flow over any time :math:`\tau`, with the multipliers
    :math:`e^{\lambda \tau}` of its eigenvalues: they leave the unit circle where eigenvalues cross
    the imaginary axis. So a Hopf point is a Neimark-Sacker point of the flow over
    :math:`\tau` = `duration`, a fold a fold, and everything made for orbits serves equilibria. What
    has no counterpart, a multiplier at -1, is not watched.
    """

    kind = "equilibrium"

    def in_phase(self, z: Array, like: Array) -> Array:
        """Return an equilibrium, which is the same at all times.

        Parameters
        ----------
        z
            The equilibrium.
        like
            Another one.
        """
        return z

    def tests(
        self,
        z: Array,
        linearisation: Linearisation,
        multipliers: NDArray[np.complex128],
        tangent: Array,
    ) -> dict[str, float]:
        """Return the functions that change sign at a bifurcation.

        Parameters
        ----------
        z
            An equilibrium.
        linearisation
            Its derivatives.
        multipliers
            Its multipliers, shape (n,).
        tangent
            Unit tangent of the branch.
        """
        tests = super().tests(z, linearisation, multipliers, tangent)
        del tests["PD"]
        return tests


def unit_of_time(model: Model, jacobian: Array) -> float:
    """Return a time over which the multipliers of an equilibrium are well told apart, in s.

    Parameters
    ----------
    model
        An autonomous model.
    jacobian
        Derivative of its rates at an equilibrium, in 1/s, shape (n, n).
    """
    values = np.linalg.eigvals(jacobian)
    turning, growing = float(np.abs(values.imag).max()), float(values.real.max())
    rate = max(turning, growing, float(np.sort(np.abs(values))[0]))
    rate = max(rate, min(float(np.abs(values).max()), rate / SLOWEST))
    return ANGLE / rate if rate > 0 and math.isfinite(rate) else 1.0
