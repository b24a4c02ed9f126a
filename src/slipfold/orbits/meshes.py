"""Meshes of orbits: segments whose lengths fit the orbit, and repeat with it."""

from __future__ import annotations

from abc import abstractmethod
from math import isfinite
from typing import Self

import numpy as np

from slipfold.arrays import Array
from slipfold.collocation_points import CollocationPoints
from slipfold.flow.equations import Constants
from slipfold.models.model import Model
from slipfold.orbits.discretization import Discretization

INTERVALS = 16
"""Minimum number of segments of the part of a mesh that is repeated, and their first number."""

GRADE = 4.0
"""Ratio of the lengths of neighbors from a steep part of an orbit to a slow one."""

FLOOR = 0.15
"""Density of a mesh where nothing happens, as a fraction of the mean."""


class MeshDiscretization(Discretization):
    """A discretization with segments of different lengths, which may be many.

    The mesh repeats itself, so that an orbit started a part of its period later has the same one.
    So have doubled orbits and their symmetric images, and the two halves of a cycle.
    """

    growing = True

    @property
    def mesh(self) -> Array:
        """Edges of the mesh: those of the segments."""
        return self.edges

    @property
    def copies(self) -> int:
        """Number of times that the mesh repeats itself in the period."""
        return mesh_copies(self.model, self.period)

    @abstractmethod
    def on(self, edges: Array) -> Self:
        """Return the same on another mesh over the whole period. Shapes: edges (m + 1,)."""

    def with_period(self, period: int) -> Self:
        """Return the same for orbits of another period: the mesh is repeated, or its half taken."""
        wanted = mesh_copies(self.model, period)
        own = self.period / self.copies
        pattern = self.mesh[: (len(self.mesh) - 1) // self.copies + 1]
        if wanted * own == period:
            return self.on(repeated(pattern, wanted))
        # Of a cycle the mesh is that of half a round; of a forced orbit that of a whole one.
        if wanted * own < period:
            return self.on(repeated(repeated(pattern, round(period / (wanted * own))), wanted))
        return self.on(even_mesh(self.model, period))

    def pattern(self, density: Array) -> tuple[Array, Array]:
        """Return the part of the mesh that is repeated, and a density that serves all copies.

        A segment takes half of what its neighbors need. Shapes: density (m,); returns edges
        (m / copies + 1,), density (m / copies,).
        """
        density = density.reshape(self.copies, -1).max(axis=0)
        density = np.maximum(density, (np.roll(density, 1) + np.roll(density, -1)) / 2)
        return self.mesh[: len(density) + 1], density

    def evenly(self, nodes: Array, constants: Constants, count: int = 0) -> Array:
        """Return the states at equidistant phases from that of the first node, shape (M, n).

        Their number is a power of two, at least that requested, and that of the nodes. Shapes:
        nodes (m, n).
        """
        total = 8
        while total < max(self.segments, count):
            total *= 2
        phases: Array = self.phase + np.arange(total, dtype=float) * (self.period / total)
        return self.states(nodes, constants, phases)


def mesh_copies(model: Model, period: int) -> int:
    """Return how often the mesh of an orbit repeats itself."""
    return period if model.forced or period % 2 == 0 else 2 * period


def even_mesh(model: Model, period: int, count: int = 0) -> Array:
    """Return the edges of a uniform mesh of at least so many segments, shape (m + 1,)."""
    copies = mesh_copies(model, period)
    each = max(INTERVALS, -(-count // copies))
    return np.linspace(0.0, period, each * copies + 1)


def repeated(pattern: Array, times: int) -> Array:
    """Return the edges of a mesh that repeats a pattern. Shapes: pattern (k + 1,)."""
    own = pattern[-1] - pattern[0]
    parts = [pattern[:-1] - pattern[0] + turn * own for turn in range(times)]
    return np.append(np.concatenate(parts), times * own)


def spread(edges: Array, density: Array, count: int, parts: int = 1) -> Array:
    """Return a mesh of so many segments, all of which have the same integral of a density.

    The same in each of so many parts, which have as many segments and keep their ends. The density
    is raised by `FLOOR` of its mean. Shapes: edges (N + 1,); density (N,); returns (count + 1,).
    """
    lengths = np.diff(edges)
    total = float(density @ lengths)
    if not isfinite(total):
        raise ArithmeticError("the orbit that a mesh would fit is not known")
    raised = density + (FLOOR * total / (edges[-1] - edges[0]) if total > 0 else 1.0)
    cumulated = np.concatenate([[0.0], np.cumsum(raised * lengths)])
    ends = cumulated[:: len(lengths) // parts]
    wanted = np.interp(np.arange(count + 1) / (count // parts), np.arange(parts + 1), ends)
    return np.interp(wanted, cumulated, edges)


def graded(edges: Array) -> Array:
    """Return a mesh that repeats, cut until none of its segments is much longer than the next."""
    while True:
        lengths = np.diff(edges)
        before, after = (GRADE * np.roll(lengths, by) for by in (1, -1))
        cuts = np.where(lengths > before, edges[:-1] + before, edges[1:] - after)
        cut = lengths > 1.5 * np.minimum(before, after)
        if not cut.any():
            return edges
        edges = np.sort(np.concatenate([edges, cuts[cut]]))


def steepness(edges: Array, slopes: Array, gauss: CollocationPoints) -> Array:
    r"""Return the density that a mesh needs on each interval, shape (N,).

    The error on an interval of length h is :math:`h^{m + 1} |x^{(m + 1)}|` for degree m; returned
    is the root of order m + 1 of that derivative, estimated from neighbors (de Boor 1973; Russell
    and Christiansen, SIAM Journal on Numerical Analysis 15 (1978) 59-80).

    Shapes: edges (N + 1,); slopes (N, m, n).
    """
    m = len(gauss.points)
    lengths = np.diff(edges)
    highest = np.einsum("k,ikn->in", gauss.highest, slopes) / lengths[:, None] ** (m - 1)
    # The orbit is closed: the last interval is the neighbor of the first.
    gaps = (lengths + np.roll(lengths, -1)) / 2
    jumps = np.abs(np.roll(highest, -1, axis=0) - highest).max(axis=1) / gaps
    return np.asarray(np.maximum(jumps, np.roll(jumps, 1)) ** (1 / (m + 1)))
