"""Orbits at a bifurcation in two free parameters: what a locus consists of."""

from __future__ import annotations

from dataclasses import replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipfold.models.model import Model
from slipfold.orbits.degeneracy import UNKNOWN, Degeneracy, degeneracy
from slipfold.orbits.linearisation import Conditions, Linearisation, defect_of
from slipfold.orbits.shooting import SEGMENTS, Shooting

__all__ = ["CriticalProblem"]

Array = NDArray[np.float64]


class CriticalProblem(Shooting):
    r"""Orbits of period k with a critical multiplier, in two free parameters.

    An unknown ``z`` holds the scaled states at m phases and both scaled parameters,
    :math:`p_i / w_i`. The equations are those of the orbit and one more, that its monodromy matrix
    is at a bifurcation (see `slipfold.orbits.degeneracy`).

    Cycles and equilibria of autonomous models have their own unknowns and derivatives:
    `slipfold.orbits.critical_cycle` and `slipfold.orbits.critical_equilibrium`.

    Parameters
    ----------
    model
        The model; its values of `vary` play no part.
    kind
        ``"LP"``, ``"PD"`` or ``"NS"``.
    vary
        Names of the free parameters.
    period
        Period in forcing periods.
    widths
        Scales of the parameters, in their units.
    segments
        Number of segments m.
    offset
        Phase of the first node, in segments.
    """

    varied = 2

    def __init__(
        self,
        model: Model,
        kind: str,
        vary: tuple[str, str],
        period: int,
        widths: tuple[float, float],
        segments: int = SEGMENTS,
        offset: float = 0.0,
    ) -> None:
        super().__init__(
            model, period, *self._free(model, vary, widths), segments=segments, offset=offset
        )
        self.kind = kind
        self.vary = vary
        self.widths = np.array(widths)

    @staticmethod
    def _free(
        model: Model, vary: tuple[str, str], widths: tuple[float, float]
    ) -> tuple[list[str], list[float]]:
        """Names and scales of the free parameters, those of `vary` last."""
        return list(vary), list(widths)

    # -- what z means --------------------------------------------------------------------------

    def pack(self, nodes: Array, values: Array) -> Array:
        """Scale an orbit and two parameter values into an unknown.

        Shapes: nodes (m, n); values (2,).
        """
        return self.join(nodes, values)

    def values(self, z: Array) -> Array:
        """Return the values of the free parameters, shape (2,)."""
        return self.free_values(z)[-2:]

    def begun_later(self) -> Self:
        """Return the same problem with its nodes half a segment later."""
        first, second = map(float, self.widths)
        return type(self)(
            self.model, self.kind, self.vary, self.period, (first, second), self.segments, 0.5
        )

    def bounds(
        self, window: tuple[tuple[float, float], tuple[float, float]]
    ) -> list[tuple[int, float, float]]:
        """Return the places of the parameters in the unknown with their scaled bounds."""
        return [
            (place, low / width, high / width)
            for place, (low, high), width in zip((-2, -1), window, self.widths, strict=True)
        ]

    # -- residual and derivatives --------------------------------------------------------------

    def plain(self, z: Array) -> Linearisation:
        """Return the mismatch and its derivatives, without the condition of the bifurcation."""
        return Linearisation(*self.transitions(self.nodes(z), self.constants(z)))

    def defect(self, z: Array) -> Array:
        """Return what Newton's method brings to zero, one number less than there are unknowns."""
        plain = self.plain(z)
        value = self._degeneracy(plain).value
        return defect_of(plain.residual, np.append(plain.conditions.values, value))

    def linearise(self, z: Array) -> Linearisation:
        """Return the mismatch and its derivatives."""
        plain = self.plain(z)
        found = self._degeneracy(plain)
        value = np.append(plain.conditions.values, found.value)
        if np.isfinite(found.value):
            gradient, carried, bent = self._gradient(found, plain, z)
        else:
            gradient, carried, bent = np.full(len(z), np.nan), None, None
        above = plain.conditions.gradients
        gradients = gradient[None] if above is None else np.vstack([above, gradient])
        return replace(plain, conditions=Conditions(value, gradients, carried, bent))

    def _degeneracy(self, linearisation: Linearisation) -> Degeneracy:
        if not np.isfinite(linearisation.blocks).all():
            return UNKNOWN
        return degeneracy(self.kind, linearisation.monodromy)

    def _gradient(
        self, found: Degeneracy, plain: Linearisation, z: Array
    ) -> tuple[Array, Array, Array]:
        r"""Differentiate the degeneracy with respect to the unknown.

        With :math:`M = A_{m-1} ... A_0` a term :math:`p^T dM q` is the sum over the segments of
        :math:`p_j^T dA_j q_j`, where q is carried forward to segment j and p backward to its end,
        and a change of :math:`A_j q_j` is a second derivative of the flow along q_j.

        Returns shape gradient (m n + k,).
        """
        gradient = np.zeros(len(z))
        forward, backward = _carried(plain.blocks, found.left, found.right)
        bent, pulled = self.curvatures(self.nodes(z), self.constants(z), forward)
        gradient[: self.size] = np.einsum("rja,rjab->jb", backward, bent).ravel()
        gradient[: self.size] *= np.sqrt(self.segments)
        gradient[self.size :] = np.einsum("rja,rjak->k", backward, pulled)
        return gradient, forward, bent


def _carried(blocks: Array, left: Array, right: Array) -> tuple[Array, Array]:
    """Carry r vectors forward to the start of each segment, r backward to each end: (r, m, n)."""
    forward, backward = [right], [left]
    for block in blocks[:-1]:
        forward.append(forward[-1] @ block.T)
    for block in blocks[:0:-1]:
        backward.append(backward[-1] @ block)
    return np.stack(forward, axis=1), np.stack(backward[::-1], axis=1)
