"""Multiple shooting: periodic orbits cut into segments that are integrated side by side."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipfold.continuation.curve import Curve
from slipfold.continuation.newton import Correction
from slipfold.flow import Flow, flow_of
from slipfold.flow.flow import Constants
from slipfold.flow.scaled import power_of_two
from slipfold.models.model import Model
from slipfold.orbits.floquet import floquet_multipliers
from slipfold.orbits.linearisation import Linearisation
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["SEGMENTS", "Shooting"]

Array = NDArray[np.float64]

SEGMENTS = 8
"""Segments an orbit is split into: one SIMD batch, and growth of 500 a period becomes 2.2 each."""


class Shooting(Curve[OrbitPoint]):
    r"""A curve of orbits of period k, given by their states at m phases.

    A subclass says which equations the orbits meet and what is watched along the curve. An unknown
    ``z`` begins with the scaled states, :math:`(x_0, ..., x_{m-1}) / (s \sqrt{m})` with the model's
    state scales s, so that its Euclidean length does not depend on m. The free parameters follow,
    each over its scale.

    Parameters
    ----------
    model
        The model.
    period
        Period in forcing periods.
    free
        Names of the free parameters.
    units
        Their scales, in their own units.
    segments
        Number of segments m.
    offset
        Phase of the first node, in segments.
    """

    varied = 1
    """How many parameters vary: the last ones of those that are free."""

    def __init__(
        self,
        model: Model,
        period: int,
        free: Sequence[str],
        units: Sequence[float],
        segments: int,
        offset: float = 0.0,
    ) -> None:
        self.model = model
        self.period = period
        self.free = tuple(free)
        self.units = np.array(units, dtype=float)
        self.indices = [model.parameter_index(name) for name in free]
        self._vector = model.vector
        self._constants: tuple[Array, Constants | None] = np.empty(0), None
        self.segments = segments
        self.flow: Flow = flow_of(model)
        self.scales = model.state_scales()
        self.flow_scales = power_of_two(self.scales)
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
    def begun_later(self) -> Self:
        """Return the same problem with its nodes half a segment later."""

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

    def residual(self, defect: Array) -> float:
        """Return the largest mismatch, in scaled states."""
        return float(np.abs(defect).max()) * float(np.sqrt(self.segments))

    def point(self, correction: Correction, arclength: float) -> OrbitPoint:
        """Return a converged correction as a point.

        The tangent points along the row of the correction's constraint. The bordered determinant
        has the same sign for that row as for the tangent, so one matrix gives both.
        """
        linearisation, bordered = correction.linearisation, correction.bordered
        tangent = bordered.tangent()
        multipliers = floquet_multipliers(linearisation.monodromy)
        return OrbitPoint(
            correction.z,
            tangent,
            arclength,
            self.tests(correction.z, linearisation, multipliers, tangent),
            bordered.sign,
            correction.residual,
            self.growth(linearisation) if np.abs(multipliers[0]) < 1 else np.inf,
            bordered.volume,
            monodromy=linearisation.monodromy,
            multipliers=multipliers,
        )

    def growth(self, linearisation: Linearisation) -> float:
        """Return an upper bound of the logarithms of the multipliers' moduli.

        It is infinite where one is on the unit circle anyway.
        """
        return np.inf

    def begun_near(self, z: Array, reference: Array) -> Array:
        """Return an orbit as it is compared with another one: forced orbits know their phase."""
        return z

    # -- what z means --------------------------------------------------------------------------

    def join(self, nodes: Array, values: Sequence[float] | Array) -> Array:
        """Scale an orbit and the values of the free parameters into an unknown.

        Shapes: nodes (m, n).
        """
        return np.concatenate([self.flat(nodes), np.asarray(values) / self.units])

    def free_values(self, z: Array) -> Array:
        """Return the values of the free parameters."""
        return z[self.size :] * self.units

    def place(self, z: Array) -> tuple[float, ...]:
        """Return the values of the parameters that vary."""
        return tuple(self.free_values(z)[-self.varied :].tolist())

    def vector(self, z: Array) -> Array:
        """Return the model's parameter vector."""
        vector = self._vector.copy()
        vector[self.indices] = self.free_values(z)
        return vector

    def model_at(self, z: Array) -> Model:
        """Return the model with the parameter values of an unknown."""
        return self.model.replace(
            **dict(zip(self.free, map(float, self.free_values(z)), strict=True))
        )

    def constants(self, z: Array) -> Constants:
        """Return the coefficients of the flow, evaluated once for each place in turn."""
        known, constants = self._constants
        if constants is None or known is not z:
            constants = self.flow.constants(self.vector(z), self.flow_scales)
            self._constants = z, constants
        return constants

    def flat(self, nodes: Array) -> Array:
        """Scale states at the nodes, shape (m, n), into the first part of an unknown.

        Shapes: nodes (m, n).
        """
        return nodes.ravel() / self._node_scales

    def nodes(self, z: Array) -> Array:
        """Return the states at the nodes, shape (m, n)."""
        return (z[: self.size] * self._node_scales).reshape(self.segments, -1)

    # -- derivatives ---------------------------------------------------------------------------

    def halved(self, nodes: Array, constants: Constants) -> Array:
        """Return the states at twice as many phases, shape (2 m, n).

        Shapes: nodes (m, n).
        """
        samples = self.flow.sample(nodes, self._start, self._end, 2, constants)
        return samples.reshape(2 * len(nodes), -1)

    def mismatch(self, nodes: Array, constants: Constants) -> Array:
        """Return by how much segments end beside the next node, in scaled states, shape (m, n).

        Shapes: nodes (m, n).
        """
        ends = self.flow.advance(nodes, self._start, self._end, constants)
        return (ends - nodes[self._following]) / self.scales

    def transitions(self, nodes: Array, constants: Constants) -> tuple[Array, Array, Array]:
        """Return the mismatch and the derivatives of the segments' ends, all in scaled states.

        Shapes: nodes (m, n); returns mismatch (m, n), blocks (m, n, n), along (m, n, k).
        """
        ends, matrices, vectors = self.flow.linearise(
            nodes, self._start, self._end, constants, constants.rates[:, self.indices]
        )
        mismatch = (ends - nodes[self._following]) / self.scales
        units = self.units / np.sqrt(self.segments)
        return mismatch, matrices * self._ratios, vectors * (units / self.scales[:, None])

    def shifted(self, z: Array, tangent: Array) -> tuple[Self, Array, Array]:
        """Return the same orbit with its nodes half a segment later.

        The steps of the integrator then fall elsewhere, so that what differs is its error.
        """
        other = self.begun_later()
        constants = self.constants(z)
        ends, matrices, vectors = self.flow.linearise(
            self.nodes(z), self._start, other._start, constants, constants.rates[:, self.indices]
        )
        moved = np.einsum("jab,jb->ja", matrices, self.nodes(tangent))
        moved += vectors @ self.free_values(tangent)
        direction = self.join(moved, self.free_values(tangent))
        return other, other.join(ends, self.free_values(z)), direction / np.linalg.norm(direction)

    def curvatures(self, nodes: Array, constants: Constants, vectors: Array) -> tuple[Array, Array]:
        """Return the derivatives of ``blocks @ vectors``, all in scaled states.

        Shapes: nodes (m, n); vectors (r, m, n); returns bent (r, m, n, n), pulled (r, m, n, k).
        """
        r, m, n = vectors.shape
        matrices, pulls = self.flow.curve(
            np.tile(nodes, (r, 1)),
            np.tile(self._start, r),
            np.tile(self._end, r),
            constants,
            constants.rates[:, self.indices],
            (vectors * self.scales).reshape(-1, n),
        )
        bent = (matrices * self._ratios).reshape(r, m, n, n)
        pulled = (pulls * (self.units / self.scales[:, None])).reshape(r, m, n, -1)
        return bent, pulled

    def cubes(self, nodes: Array, constants: Constants, vectors: Array) -> Array:
        """Return the third derivatives of the segments' ends along vectors, in scaled states.

        Shapes: nodes (m, n); vectors (r, m, n); returns (r, m, n).
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
