"""Periodic orbits in one parameter as a boundary-value problem: multiple shooting, scaled."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property, reduce

import numpy as np
from numpy.typing import NDArray

from slipfold.flow import Flow, flow_of
from slipfold.flow.flow import Constants
from slipfold.models.model import Model

__all__ = ["SEGMENTS", "Linearisation", "PeriodicProblem"]

Array = NDArray[np.float64]

SEGMENTS = 8
"""Segments an orbit is split into: one SIMD batch, and growth of 500 a period becomes 2.2 each."""


class PeriodicProblem:
    r"""Orbits of period k in one free parameter.

    An unknown ``z`` holds the scaled states at m phases and the scaled parameter,

    .. math:: z = (x_0, ..., x_{m-1}) / (s \sqrt{m}), \quad z_{mn} = p / w

    with the model's state scales s and the width w of the parameter's span, so that its Euclidean
    length does not depend on m. The residual says that segment j ends where segment j + 1 begins.

    Parameters
    ----------
    model
        The model; the value of `vary` is a part of `z` instead.
    vary
        Name of the free parameter.
    period
        Period in forcing periods.
    width
        Scale of the parameter, in its unit.
    segments
        Number of segments m.
    offset
        Phase of the first node, in segments.
    """

    def __init__(
        self,
        model: Model,
        vary: str,
        period: int,
        width: float,
        segments: int = SEGMENTS,
        offset: float = 0.0,
    ) -> None:
        self.model = model
        self.vary = vary
        self.period = period
        self.width = width
        self.segments = segments
        self.flow: Flow = flow_of(model)
        self.index = model.parameter_index(vary)
        self.scales = model.state_scales()
        self.size = segments * len(self.scales)
        self._node_scales = np.tile(self.scales, segments) * np.sqrt(segments)
        edges: Array = (np.arange(segments + 1, dtype=float) + offset) * (period / segments)
        self._start, self._end = edges[:-1], edges[1:]
        self._following = (np.arange(segments) + 1) % segments
        self._ratios = self.scales[None, :] / self.scales[:, None]

    # -- what z means --------------------------------------------------------------------------

    def pack(self, nodes: Array, value: float) -> Array:
        """Scale an orbit and a parameter value into an unknown.

        Parameters
        ----------
        nodes
            Shape (m, n).
        value
            Value of the parameter.
        """
        return np.append(nodes.ravel() / self._node_scales, value / self.width)

    def nodes(self, z: Array) -> Array:
        """Return the states at the nodes, shape (m, n).

        Parameters
        ----------
        z
            The unknown.
        """
        return (z[:-1] * self._node_scales).reshape(self.segments, -1)

    def value(self, z: Array) -> float:
        """Return the parameter value.

        Parameters
        ----------
        z
            The unknown.
        """
        return float(z[-1] * self.width)

    def value_of(self, model: Model) -> float:
        """Return the value that a model gives the free parameter.

        Parameters
        ----------
        model
            A model of the same kind.
        """
        return model.values[self.vary]

    def vector(self, z: Array) -> Array:
        """Return the model's parameter vector.

        Parameters
        ----------
        z
            The unknown.
        """
        vector = self.model.vector.copy()
        vector[self.index] = self.value(z)
        return vector

    def constants(self, z: Array) -> Constants:
        """Return the coefficients of the flow.

        Parameters
        ----------
        z
            The unknown.
        """
        return self.flow.constants(self.vector(z))

    # -- residual and derivatives --------------------------------------------------------------

    def residual(self, z: Array) -> Array:
        """Return the mismatch at the nodes in scaled states, shape (m, n).

        Parameters
        ----------
        z
            The unknown.
        """
        nodes = self.nodes(z)
        ends = self.flow.advance(nodes, self._start, self._end, self.constants(z))
        return (ends - nodes[self._following]) / self.scales

    def linearise(self, z: Array) -> Linearisation:
        """Return the mismatch and its derivatives.

        Parameters
        ----------
        z
            The unknown.
        """
        nodes, constants = self.nodes(z), self.constants(z)
        ends, matrices, vectors = self.flow.linearise(
            nodes, self._start, self._end, constants, constants.rates[:, [self.index]]
        )
        residual = (ends - nodes[self._following]) / self.scales
        along = vectors[:, :, 0] * (self.width / (self.scales * np.sqrt(self.segments)))
        return Linearisation(residual, matrices * self._ratios, along)

    def shifted(self, z: Array, tangent: Array) -> tuple[PeriodicProblem, Array, Array]:
        """Return the same orbit with its nodes half a segment later.

        The steps of the integrator then fall elsewhere, so that what differs is its error.

        Parameters
        ----------
        z
            The unknown.
        tangent
            Tangent of the branch at `z`.

        Returns
        -------
        problem : PeriodicProblem
            The shifted problem.
        z, tangent : ndarray
            In the shifted problem.
        """
        other = PeriodicProblem(
            self.model, self.vary, self.period, self.width, self.segments, offset=0.5
        )
        constants = self.constants(z)
        ends, matrices, vectors = self.flow.linearise(
            self.nodes(z), self._start, other._start, constants, constants.rates[:, [self.index]]
        )
        moved = np.einsum("jab,jb->ja", matrices, self.nodes(tangent))
        moved += vectors[:, :, 0] * (tangent[-1] * self.width)
        direction = np.append(moved.ravel() / self._node_scales, tangent[-1])
        return (
            other,
            other.pack(ends, self.value(z)),
            direction / np.linalg.norm(direction),
        )


@dataclass(frozen=True, eq=False)
class Linearisation:
    """Mismatch of an orbit and its derivatives, in scaled variables.

    Parameters
    ----------
    residual
        Shape (m, n), in scaled states.
    blocks
        Transition matrices of the segments, shape (m, n, n).
    along
        Derivative of the segments' ends with respect to the scaled parameter, shape (m, n).
    """

    residual: Array
    blocks: Array
    along: Array

    @cached_property
    def monodromy(self) -> Array:
        """Product of the transition matrices, shape (n, n), in scaled states."""
        return reduce(lambda product, block: block @ product, self.blocks)

    def bordered(self, row: Array) -> Bordered:
        """Return the Jacobian with one more row.

        Block pattern for three segments (A transition matrix, b along, I identity)::

            [ A -I  .  b ]
            [ .  A -I  b ]
            [-I  .  A  b ]
            [ --- row -- ]

        Parameters
        ----------
        row
            Shape (m n + 1,).
        """
        m, n = self.along.shape
        matrix = np.zeros((m * n + 1, m * n + 1))
        places = _block_places(m, n)
        matrix.ravel()[places] = self.blocks.ravel()
        matrix[np.arange(m * n), (np.arange(m * n) + n) % (m * n)] -= 1.0
        matrix[:-1, -1] = self.along.ravel()
        matrix[-1] = row
        return Bordered(matrix)


@cache
def _block_places(m: int, n: int) -> NDArray[np.int64]:
    """Flat places of the diagonal blocks in a bordered matrix."""
    size = m * n + 1
    inside = np.arange(n)[:, None] * size + np.arange(n)[None, :]
    return (np.arange(m)[:, None, None] * n * (size + 1) + inside).ravel()


@dataclass(frozen=True, eq=False)
class Bordered:
    """Jacobian of an orbit with one more row, square.

    Parameters
    ----------
    matrix
        Shape (m n + 1, m n + 1).
    """

    matrix: Array

    @cached_property
    def inverse(self) -> Array:
        """Inverse, NaN if the matrix is singular.

        It is small and serves several right-hand sides; what rounding adds Newton's method
        removes.
        """
        try:
            return np.asarray(np.linalg.inv(self.matrix), dtype=float)
        except np.linalg.LinAlgError:
            return np.full_like(self.matrix, np.nan)

    @property
    def sign(self) -> int:
        """Sign of the determinant."""
        return int(np.linalg.slogdet(self.matrix)[0])

    def tangent(self) -> Array:
        """Return the unit vector of the kernel that the last row leaves, along that row."""
        tangent = self.inverse[:, -1]
        return tangent / np.linalg.norm(tangent)
