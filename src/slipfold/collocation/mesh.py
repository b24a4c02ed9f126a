"""Where the intervals of a collocated orbit end: the same error on each of them."""

from __future__ import annotations

import numpy as np

from slipfold.arrays import Array
from slipfold.collocation_points import CollocationPoints

FLOOR = 0.1
"""Density of the mesh where nothing happens, as a share of the mean: the estimate may miss what
the mesh is too coarse to show."""

NEAR = 0.4
"""An edge nearer to an anchor than this share of an interval gives way to it."""


def uniform(period: int, count: int, anchors: int) -> Array:
    """Return the edges of equal intervals, shape (N + 1,)."""
    return np.linspace(0.0, period, -(-count // anchors) * anchors + 1)


def halve(edges: Array) -> Array:
    """Return a mesh with each interval cut in two. Shapes: edges (N + 1,)."""
    return np.sort(np.concatenate([edges, (edges[:-1] + edges[1:]) / 2]))


def equidistribute(
    edges: Array, slopes: Array, gauss: CollocationPoints, count: int, anchors: int
) -> Array:
    r"""Return a mesh on which the estimated error is the same on each interval.

    Shapes: edges (N + 1,); slopes (N, m, n); returns (N' + 1,).
    """
    density = steepness(edges, slopes, gauss)
    lengths = np.diff(edges)
    mean = float(density @ lengths) / (edges[-1] - edges[0])
    density = density + (FLOOR * mean if mean > 0 else 1.0)
    return _anchored(spread(edges, density, count), anchors)


def steepness(edges: Array, slopes: Array, gauss: CollocationPoints) -> Array:
    r"""Return how fine a mesh has to be on each interval, shape (N,).

    The error on an interval of length h is :math:`h^{m + 1} |x^{(m + 1)}|` for polynomials of
    degree m; returned is the root of order m + 1 of the derivative. The highest derivative of the
    polynomial is constant on an interval; the next one is estimated from how it differs between
    neighbours (de Boor 1973; Russell and Christiansen, SIAM Journal on Numerical Analysis 15 (1978)
    59-80).

    Shapes: edges (N + 1,); slopes (N, m, n).
    """
    m = len(gauss.points)
    lengths = np.diff(edges)
    highest = np.einsum("k,ikn->in", gauss.highest, slopes) / lengths[:, None] ** (m - 1)
    # The orbit is closed: the last interval is the neighbour of the first.
    gaps = (lengths + np.roll(lengths, -1)) / 2
    jumps = np.abs(np.roll(highest, -1, axis=0) - highest).max(axis=1) / gaps
    return np.asarray(np.maximum(jumps, np.roll(jumps, 1)) ** (1 / (m + 1)))


def spread(edges: Array, density: Array, count: int) -> Array:
    """Return a mesh of so many intervals, all of which have the same share of a density.

    Shapes: edges (N + 1,); density (N,); returns (N' + 1,).
    """
    cumulated = np.concatenate([[0.0], np.cumsum(density * np.diff(edges))])
    return np.interp(np.linspace(0.0, cumulated[-1], count + 1), cumulated, edges)


def _anchored(edges: Array, anchors: int) -> Array:
    """Add the anchors, and take away edges of the mesh that come too near to them."""
    kept = np.linspace(edges[0], edges[-1], anchors + 1)
    inner = edges[1:-1]
    spacing = np.minimum(np.diff(edges)[:-1], np.diff(edges)[1:])
    distance = np.abs(inner[:, None] - kept[None, :]).min(axis=1)
    return np.sort(np.concatenate([kept, inner[distance > NEAR * spacing]]))
