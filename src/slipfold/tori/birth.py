"""The first circle beside a Neimark-Sacker point."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.continuation.newton import correct
from slipfold.errors import BREAKDOWNS
from slipfold.flow.flow import flow_of
from slipfold.models.model import Model
from slipfold.tori.circles import FEWEST, CirclePoint, Circles

SIZES = tuple(0.02 / 2**k for k in range(8))
"""Radii of the first circle that are tried, in scaled states."""


def born(model: Model, vary: str, width: float, state: Array, period: int) -> CirclePoint | None:
    r"""Return a small circle round an orbit with multipliers :math:`e^{\pm 2 \pi i \rho}`.

    It is an ellipse in the plane of their eigenvectors, to first order. The curve goes on to
    larger ones. None where Newton's method finds none: at a strong resonance, say.

    Shapes: state (n,), at phase zero.
    """
    rotation, vector = _critical(model, state, period)
    scales = model.state_scales()
    turn = np.exp(2j * np.pi * np.arange(FEWEST) / FEWEST)
    ellipse = np.real(turn[:, None] * vector / np.linalg.norm(vector / scales))
    for size in SIZES:
        reference = state + size * ellipse
        circles = Circles(model, vary, width, period, reference)
        others = circles.others(rotation, model)
        row = circles.join(ellipse, 0 * others)
        try:
            guess = circles.join(reference, others)
            correction = correct(circles, guess, row / np.linalg.norm(row))
        except BREAKDOWNS:
            continue
        if correction.converged:
            return circles.point(correction, 0.0)
    return None


def _critical(model: Model, state: Array, period: int) -> tuple[float, NDArray[np.complex128]]:
    """Return by which part of a turn the map turns a plane, and its eigenvector."""
    flow = flow_of(model)
    constants, zero = flow.constants_of(model), np.zeros(1)
    still = np.zeros((len(constants.values), 0))
    matrix = flow.linearise(state[None], zero, zero + period, constants, still)[1][0]
    values, vectors = np.linalg.eig(matrix)
    turning = np.where(values.imag > 0, np.abs(np.abs(values) - 1), np.inf)
    which = int(turning.argmin())
    return float(np.angle(values[which]) / (2 * np.pi)), vectors[:, which]
