"""Equilibria of an autonomous model at a bifurcation in two free parameters."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.models.model import Model
from slipfold.orbits.critical_problem import CriticalProblem
from slipfold.orbits.degeneracy import Degeneracy
from slipfold.orbits.linearisation import Linearisation
from slipfold.orbits.resting import Resting

__all__ = ["CriticalEquilibrium", "eigenvalues_of"]

Array = NDArray[np.float64]


class CriticalEquilibrium(Resting, CriticalProblem):
    r"""Equilibria with an eigenvalue zero (LP) or an imaginary pair (NS), in two free parameters.

    An unknown ``z`` holds the scaled state and both scaled parameters; the equations are those of
    the vector field itself, so nothing is integrated. What multipliers are to an orbit, the
    eigenvalues of the Cayley transform are here,

    .. math:: M = (I - A)^{-1} (I + A), \quad A = J / (2 \, ||J||)

    with the Jacobian J in scaled states and its Frobenius norm: it maps zero to one, imaginary
    pairs to the unit circle, decay to its inside, and no frequency is too high for it.

    Parameters
    ----------
    model
        The model; its values of `vary` play no part.
    kind
        ``"LP"`` or ``"NS"``, which is the Hopf bifurcation.
    vary
        Names of the free parameters.
    period
        Always 1.
    widths
        Scales of the parameters, in their units.
    segments
        Always 1.
    offset
        Not zero: with other scales of the states.
    """

    def __init__(
        self,
        model: Model,
        kind: str,
        vary: tuple[str, str],
        period: int,
        widths: tuple[float, float],
        segments: int = 1,
        offset: float = 0.0,
    ) -> None:
        super().__init__(model, kind, vary, period, widths, segments)
        if offset:
            self.take_other_scales()

    def plain(self, z: Array) -> Linearisation:
        """Return the rates and their derivatives over the size of the Jacobian."""
        constants = self.constants(z)
        jacobian = self.jacobian(z, constants)
        size = float(np.linalg.norm(jacobian))
        return EquilibriumLinearisation(
            self.rates(z, constants) / size,
            (np.eye(len(self.scales)) + jacobian / size)[None],
            (self.pulls(z, constants) / size)[None],
        )

    def _gradient(self, found: Degeneracy, plain: Linearisation, z: Array) -> tuple[Any, Any, Any]:
        r"""Differentiate the degeneracy with :math:`dM = (I - A)^{-1} dA (I + M)`.

        The norm in A may be taken as constant: multiplied by any number, eigenvalues on the
        imaginary axis stay there.
        """
        state, constants = self.nodes(z), self.constants(z)
        size = 2 * float(np.linalg.norm(self.jacobian(z, constants)))
        identity = np.eye(len(self.scales))
        inside = (plain.blocks[0] - identity) / 2
        left = np.linalg.solve((identity - inside).T, found.left.T).T / size
        right = found.right @ (identity + plain.monodromy).T
        second, mixed = self.flow.curvatures(
            state[0], constants, right * self.scales, constants.rates[:, self.indices]
        )
        along_state = np.einsum("ra,rab->b", left, second * self._ratios)
        along_free = np.einsum("ra,rak->k", left, mixed * (self.units / self.scales[:, None]))
        return np.concatenate([along_state, along_free]), None, None


class EquilibriumLinearisation(Linearisation):
    """Rates of an equilibrium and their derivatives, over the size of the Jacobian."""

    @cached_property
    def monodromy(self) -> Array:
        """The Cayley transform of the Jacobian."""
        identity = np.eye(self.blocks.shape[1])
        inside = (self.blocks[0] - identity) / 2
        return np.linalg.solve(identity - inside, identity + inside)


def eigenvalues_of(jacobian: Array) -> NDArray[np.complex128]:
    """Return eigenvalues, largest real part first, the upper one of a pair before the lower.

    Shapes: jacobian (n, n).
    """
    values = np.linalg.eigvals(jacobian).astype(complex)
    # Real parts of a pair differ by rounding.
    real = np.round(values.real / (np.abs(values).max() or 1.0), 12)
    return values[np.lexsort((-values.imag, -real))]
