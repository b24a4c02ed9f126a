"""Closed curves through equidistant points, by their Fourier series."""

from __future__ import annotations

import numpy as np

from slipfold.arrays import Array


def turned(points: Array, turns: float) -> Array:
    """Return the curve's points some turns farther on. Shapes: points (m, n), m odd.

    >>> import numpy as np
    >>> angles = 2 * np.pi * np.arange(5)[:, None] / 5
    >>> bool(np.allclose(turned(np.cos(angles), 0.1), np.cos(angles + 0.2 * np.pi)))
    True
    """
    orders = np.arange(len(points) // 2 + 1)[:, None]
    series = np.fft.rfft(points, axis=0) * np.exp(2j * np.pi * turns * orders)
    return np.fft.irfft(series, len(points), axis=0)


def slopes(points: Array) -> Array:
    """Return the curve's derivatives by the number of turns at its points, shape (m, n)."""
    orders = np.arange(len(points) // 2 + 1)[:, None]
    return np.fft.irfft(np.fft.rfft(points, axis=0) * 2j * np.pi * orders, len(points), axis=0)


def turning(count: int, turns: float) -> Array:
    """Return the matrix that gives points some turns farther on, shape (m, m)."""
    first = turned(np.eye(count, 1), turns)[:, 0]
    places = np.arange(count)
    return first[(places[:, None] - places) % count]


def resampled(points: Array, count: int) -> Array:
    """Return another odd number of equidistant points of the curve, shape (count, n)."""
    series = np.fft.rfft(points, axis=0)
    kept = np.zeros((count // 2 + 1, points.shape[1]), complex)
    size = min(len(series), len(kept))
    kept[:size] = series[:size]
    return np.fft.irfft(kept, count, axis=0) * (count / len(points))


def tail(points: Array) -> float:
    """Return how large the last tenth of the curve's harmonics are beside the largest of all."""
    sizes = np.abs(np.fft.rfft(points, axis=0)[1:]).max(axis=1)
    last = max(2, len(sizes) // 10)
    return float(sizes[-last:].max() / sizes.max())
