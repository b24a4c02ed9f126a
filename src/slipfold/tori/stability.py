"""Whether a torus attracts: how fast perturbations across it grow on average."""

from __future__ import annotations

import numpy as np

from slipfold.arrays import Array
from slipfold.long_term.birkhoff import Average, average
from slipfold.tori.harmonics import slopes

STARTS = 15
"""Equidistant angles from which perturbations set out; means over angles converge fast."""

RETURNS = 64
"""Returns of the map over which growth is averaged; as many go before, for directions to turn."""


def growth_across(
    matrices: Array, circle: Array, rotation: float, scales: Array, rates: Array | None = None
) -> Average:
    """Return exponents a return of what is across the torus, the largest first.

    Along the circle perturbations neither grow nor decay, nor do they along the flow of an
    autonomous model; what they have along these does not count. The derivatives of the map between
    the angles are those of their Fourier series.

    Shapes: matrices (m, n, n), circle, rates (m, n).
    """
    (m, n), scaled = circle.shape, matrices * (scales / scales[:, None])
    within = [part / scales for part in (slopes(circle), rates) if part is not None]
    series = np.fft.rfft(np.concatenate([scaled.reshape(m, -1), *within], axis=1), axis=0) / m
    series[1:] *= 2
    returns = np.arange(2 * RETURNS + 1)[:, None]
    angles = (np.arange(STARTS) / STARTS + rotation * returns) % 1.0
    waves = np.exp(2j * np.pi * angles[..., None] * np.arange(len(series)))
    passed = (waves @ series).real
    tangents = passed[..., n * n :].reshape(*angles.shape, -1, n).swapaxes(-1, -2)
    planes = np.concatenate([tangents, np.broadcast_to(np.eye(n), (*angles.shape, n, n))], axis=-1)
    across = np.linalg.qr(planes)[0][..., len(within) :]  # bases of what is across, by columns
    maps = passed[:-1, :, : n * n].reshape(-1, STARTS, n, n)
    steps = across[1:].swapaxes(-1, -2) @ maps @ across[:-1]
    left = n - len(within)
    frame, growth = np.eye(left), np.empty((2 * RETURNS, left))
    for step, row in zip(steps, growth, strict=True):
        frame, factors = np.linalg.qr(step @ frame)
        sizes = np.abs(np.diagonal(factors, axis1=-2, axis2=-1))
        row[:] = np.log(np.maximum(sizes, np.finfo(float).tiny)).mean(axis=0)
    found = average(growth[RETURNS:])
    order = np.argsort(-found.values, kind="stable")
    return Average(found.values[order], found.errors[order])
