"""Multiple shooting: periodic orbits cut into segments that are integrated side by side."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from slipfold.flow import Flow, flow_of
from slipfold.flow.flow import Constants
from slipfold.models.model import Model
from slipfold.orbits.linearisation import Linearisation

__all__ = ["SEGMENTS", "Shooting"]

Array = NDArray[np.float64]

SEGMENTS = 8
"""Segments an orbit is split into: one SIMD batch, and growth of 500 a period becomes 2.2 each."""


class Shooting(ABC):
    r"""A curve of orbits of period k, given by their states at m phases.

    A subclass says which equations the orbits meet and what is watched along the curve. An unknown
    ``z`` begins with the scaled states, :math:`(x_0, ..., x_{m-1}) / (s \sqrt{m})` with the model's
    state scales s, so that its Euclidean length does not depend on m. What follows in it are the
    free parameters.

    Parameters
    ----------
    model
        The model.
    period
        Period in forcing periods.
    segments
        Number of segments m.
    offset
        Phase of the first node, in segments.
    """

    def __init__(self, model: Model, period: int, segments: int, offset: float = 0.0) -> None:
        self.model = model
        self.period = period
        self.segments = segments
        self.flow: Flow = flow_of(model)
        self.scales = model.state_scales()
        self.size = segments * len(self.scales)
        self._node_scales = np.tile(self.scales, segments) * np.sqrt(segments)
        edges: Array = (np.arange(segments + 1, dtype=float) + offset) * (period / segments)
        self._start, self._end = edges[:-1], edges[1:]
        self._following = (np.arange(segments) + 1) % segments
        self._ratios = self.scales[None, :] / self.scales[:, None]

    @property
    def phase(self) -> float:
        """Phase of the first node."""
        return float(self._start[0])

    @abstractmethod
    def constants(self, z: Array) -> Constants:
        """Return the coefficients of the flow at an unknown."""

    @abstractmethod
    def defect(self, z: Array) -> Array:
        """Return what Newton's method brings to zero, one number less than there are unknowns."""

    @abstractmethod
    def linearise(self, z: Array) -> Linearisation:
        """Return the defect with its derivatives."""

    @abstractmethod
    def tests(
        self,
        z: Array,
        linearisation: Linearisation,
        multipliers: NDArray[np.complex128],
        tangent: Array,
    ) -> dict[str, float]:
        """Return the functions that change sign at special points of the curve, by name."""

    def flat(self, nodes: Array) -> Array:
        """Scale states at the nodes, shape (m, n), into the first part of an unknown.

        Parameters
        ----------
        nodes
            States, shape (m, n).
        """
        return nodes.ravel() / self._node_scales

    def nodes(self, z: Array) -> Array:
        """Return the states at the nodes, shape (m, n).

        Parameters
        ----------
        z
            The unknown.
        """
        return (z[: self.size] * self._node_scales).reshape(self.segments, -1)

    def halved(self, nodes: Array, constants: Constants) -> Array:
        """Return the states at twice as many phases, shape (2 m, n).

        Parameters
        ----------
        nodes
            States, shape (m, n).
        constants
            Coefficients of the flow.
        """
        samples = self.flow.sample(nodes, self._start, self._end, 2, constants)
        return samples.reshape(2 * len(nodes), -1)

    def mismatch(self, nodes: Array, constants: Constants) -> Array:
        """Return by how much segments end beside the next node, in scaled states, shape (m, n).

        Parameters
        ----------
        nodes
            States, shape (m, n).
        constants
            Coefficients of the flow.
        """
        ends = self.flow.advance(nodes, self._start, self._end, constants)
        return (ends - nodes[self._following]) / self.scales

    def transitions(
        self, nodes: Array, constants: Constants, indices: list[int]
    ) -> tuple[Array, Array, Array]:
        """Return the mismatch and the derivatives of the segments' ends, all in scaled states.

        Parameters
        ----------
        nodes
            States, shape (m, n).
        constants
            Coefficients of the flow.
        indices
            Places of k parameters in the model's parameter vector.

        Returns
        -------
        mismatch : ndarray, shape (m, n)
            By how much segments end beside the next node.
        blocks : ndarray, shape (m, n, n)
            Derivatives with respect to the states at their beginning.
        along : ndarray, shape (m, n, k)
            Derivatives with respect to the parameters.
        """
        ends, matrices, vectors = self.flow.linearise(
            nodes, self._start, self._end, constants, constants.rates[:, indices]
        )
        mismatch = (ends - nodes[self._following]) / self.scales
        return mismatch, matrices * self._ratios, vectors / self.scales[:, None]

    def curvatures(
        self, nodes: Array, constants: Constants, indices: list[int], vectors: Array
    ) -> tuple[Array, Array]:
        """Return the derivatives of ``blocks @ vectors``, all in scaled states.

        Parameters
        ----------
        nodes
            States, shape (m, n).
        constants
            Coefficients of the flow.
        indices
            Places of k parameters in the model's parameter vector.
        vectors
            Scaled perturbations of the states at the nodes, shape (r, m, n): r at each node.

        Returns
        -------
        bent : ndarray, shape (r, m, n, n)
            With respect to the states at the beginning of each segment.
        pulled : ndarray, shape (r, m, n, k)
            With respect to the parameters.
        """
        r, m, n = vectors.shape
        matrices, pulls = self.flow.curve(
            np.tile(nodes, (r, 1)),
            np.tile(self._start, r),
            np.tile(self._end, r),
            constants,
            constants.rates[:, indices],
            (vectors * self.scales).reshape(-1, n),
        )
        bent = (matrices * self._ratios).reshape(r, m, n, n)
        return bent, (pulls / self.scales[:, None]).reshape(r, m, n, -1)

    def cubes(self, nodes: Array, constants: Constants, vectors: Array) -> Array:
        """Return the third derivatives of the segments' ends along vectors, in scaled states.

        Parameters
        ----------
        nodes
            States, shape (m, n).
        constants
            Coefficients of the flow.
        vectors
            Scaled perturbations of the states at the nodes, shape (r, m, n).

        Returns
        -------
        ndarray, shape (r, m, n)
            ``D^3 phi [v, v, v]``.
        """
        r, m, n = vectors.shape
        jets = self.flow.jet(
            np.tile(nodes, (r, 1)),
            np.tile(self._start, r),
            np.tile(self._end, r),
            constants,
            (vectors * self.scales).reshape(-1, n),
        )
        return (jets[:, 2] / self.scales).reshape(r, m, n)
