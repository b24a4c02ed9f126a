"""A whole torus: what a model does on it, at all times and from all its states."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.flow import flow_of
from slipfold.models.model import Model
from slipfold.tori.harmonics import turned

PER_PERIOD = 64
"""Phases of a forcing period."""

STEPS = 4
"""Places looked at by Newton's method, from that of the largest sample on."""


@dataclass(frozen=True, eq=False)
class Surface:
    r"""Outputs over two angles, in both of which they are periodic with one turn.

    A motion has :math:`\psi = \psi_0 + \rho t/(k T)` and :math:`\tau = t/(k T)`: its values are
    sums of lines at the frequencies :math:`(l \rho + j) f/k`.
    """

    rotation: float
    period: int
    values: Array  # at equidistant angles psi, tau, shape (m, q, n_outputs)

    @property
    def lines(self) -> NDArray[np.complex128]:
        """Coefficients of exp(2 pi i (l psi + j tau)), shape (m, q, n_outputs)."""
        m, q, _ = self.values.shape
        return np.fft.fft2(self.values, axes=(0, 1)) / (m * q)

    def extremes(self) -> tuple[Array, Array]:
        """Return the smallest and the largest value of outputs anywhere on the torus, (k,) each."""
        outputs = [np.moveaxis(item, -1, 0) for item in (self.lines, self.values)]
        found = [
            [sign * _largest(sign * lines, sign * values) for sign in (-1, 1)]
            for lines, values in zip(*outputs, strict=True)
        ]
        low, high = np.array(found).reshape(-1, 2).T
        return low, high


def _largest(lines: NDArray[np.complex128], values: Array) -> float:
    """Return the largest value of a doubly periodic function, by Newton's method on its series."""
    highest = float(values.max())
    place = np.array(np.unravel_index(values.argmax(), values.shape)) / values.shape
    best, spacing = place, 1 / np.array(values.shape)
    turns = [2j * np.pi * np.fft.fftfreq(count, 1 / count) for count in values.shape]
    for _ in range(STEPS):
        # All derivatives by both angles up to the second.
        left, right = (
            np.exp(orders * at) * orders ** np.arange(3)[:, None]
            for orders, at in zip(turns, best, strict=True)
        )
        by = (left @ lines @ right.T).real
        bends = np.array([[by[2, 0], by[1, 1]], [by[1, 1], by[0, 2]]])
        if not np.linalg.det(bends) > 0:  # a corner, a ridge or a plain: samples have to do
            break
        best = best - np.linalg.solve(bends, [by[1, 0], by[0, 1]])
        if (np.abs(best - place) > spacing).any():
            break
        highest = max(highest, float(by[0, 0]))
    return highest


def surface_of(model: Model, circle: Array, rotation: float, period: int) -> Surface:
    """Return all of a torus from its circle at phase zero. Shapes: circle (m, n)."""
    flow, count = flow_of(model), PER_PERIOD * period
    constants, zero = flow.constants_of(model), np.zeros(len(circle))
    states = flow.sample(circle, zero, zero + period, count, constants)
    phases = np.arange(count) / PER_PERIOD % 1.0
    found = np.stack(
        [
            turned(
                flow.outputs(states[:, j], np.full(len(circle), phases[j]), constants),
                -rotation * j / count,
            )
            for j in range(count)
        ],
        axis=1,
    )
    return Surface(rotation, period, found)
