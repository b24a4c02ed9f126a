"""What settles the equations of an orbit where they leave something open."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.collocation.vector_field import VectorField


@dataclass(frozen=True, eq=False)
class Reference:
    r"""States of a nearby orbit at equidistant phases, which are edges of every mesh.

    They settle which of a cycle's phase shifts is meant, :math:`\int <x - x_r, x_r'> dt = 0`, with
    the integral by the trapezoidal rule, which converges faster than any power for periodic
    functions. At a fold or branch point they settle in the same way which of the orbits is meant
    that the equations can hardly tell apart.
    """

    states: Array  # scaled, shape (M, n)
    # Of a cycle their time derivatives, of length one together, shape (M, n); None where the
    # forcing sets the phase
    rates: Array | None
    singular: bool  # whether the orbit is at a fold or branch point

    def places(self, edges: Array) -> NDArray[np.intp]:
        """Return where its phases are among the edges of a mesh, shape (M,).

        Shapes: edges (N + 1,).
        """
        phases = np.linspace(edges[0], edges[-1], len(self.states) + 1)[:-1]
        return np.abs(edges[:-1, None] - phases[None, :]).argmin(axis=0)

    def spread(self, edges: Array) -> Array:
        """Return its states among zeros at the other edges, shape (N, n).

        Shapes: edges (N + 1,).
        """
        result = np.zeros((len(edges) - 1, self.states.shape[1]))
        result[self.places(edges)] = self.states
        return result


def reference_of(field: VectorField, states: Array, singular: bool) -> Reference:
    """Make the reference of a forced orbit or of a cycle. Shapes: states (M, n)."""
    if field.forced:
        return Reference(states, None, singular)
    rates = field.linear(states, np.zeros(len(states)))[0]
    return Reference(states, rates / (np.linalg.norm(rates) or 1.0), singular)
