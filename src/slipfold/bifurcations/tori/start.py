"""The first circle: beside a Neimark-Sacker point, or where a trajectory converges."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import ArrayLike

from slipfold.arrays import Array, Complex
from slipfold.bifurcations.tori.circles import (
    MAX_ANGLES,
    MIN_ANGLES,
    TORUS,
    Circles,
    tail,
)
from slipfold.continuation.curve import Point
from slipfold.flow.flow import flow_of
from slipfold.flow.simulate import SmoothIntegration, initial_state
from slipfold.long_term.exponents import bump, rotation_of
from slipfold.models.angles import wrap_angles
from slipfold.models.model import Model

RADII = tuple(0.02 / 2**k for k in range(8))
"""Radii of the first circle that are tried, in scaled states."""


def first_circle(model: Model, vary: str, width: float, state: Array, period: int) -> Point | None:
    r"""Return a small circle round an orbit with multipliers :math:`e^{\pm 2 \pi i \rho}`.

    To first order it is an ellipse in the plane of their eigenvectors; continuation leads to larger
    circles. Return None if Newton's method fails, for example at a strong resonance.

    Shapes: state (n,), at phase zero.
    """
    rotation, vector = _critical(model, state, period)
    scales = model.state_scales()
    turn = np.exp(2j * np.pi * np.arange(MIN_ANGLES) / MIN_ANGLES)
    ellipse = np.real(turn[:, None] * vector / np.linalg.norm(vector / scales))
    for size in RADII:
        reference = state + size * ellipse
        circles = Circles(model, vary, width, period, reference)
        others = circles.others(rotation, model)
        row = circles.join(ellipse, 0 * others)
        found = circles.nearest(circles.join(reference, others), row / np.linalg.norm(row))
        if found is not None:
            return found
    return None


def _critical(model: Model, state: Array, period: int) -> tuple[float, Complex]:
    """Return the rotation number of the critical pair, in revolutions, and its eigenvector."""
    flow = flow_of(model)
    constants, zero = flow.constants_of(model), np.zeros(1)
    still = np.zeros((len(constants.values), 0))
    matrix = flow.linearize(state[None], zero, zero + period, constants, still)[1][0]
    values, vectors = np.linalg.eig(matrix)
    turning = np.where(values.imag > 0, np.abs(np.abs(values) - 1), np.inf)
    which = int(turning.argmin())
    return float(np.angle(values[which]) / (2 * np.pi)), vectors[:, which]


PERIODS = (2_000, 6_000, 18_000)
"""Lengths of a trajectory in forcing periods, tried in this order. Its second half is taken to lie
on the torus."""


def circle_from_trajectory(
    model: Model, vary: str, width: float, state: ArrayLike | Mapping[str, float]
) -> Point | None:
    """Return the circle that a trajectory visits at phase zero; None if there is none.

    Its harmonics are averages along the trajectory; Newton's method makes them exact.
    """
    motion = SmoothIntegration(model, initial_state(model, state))
    for periods in PERIODS:
        motion.advance(periods - motion.periods)
        if motion.stopped is not None:
            return None
        states = motion.states[periods // 2 :]
        rotation = rotation_of(states, motion.model.state_scales(), model.angle_periods)
        if rotation is None:
            continue
        states = states[:: rotation.period]
        for circle in _circles(states, rotation.number, model.angle_periods):
            result = _corrected(motion.model, vary, width, rotation.period, circle, rotation.number)
            if result is not None:
                return result
    return None


def _circles(states: Array, rotation: float, angle_periods: Array) -> Iterator[Array]:
    """Yield closed curves through states, with more and more harmonics. Shapes: states (k, n)."""
    base = states[0]
    states = base + wrap_angles(states - base, angle_periods)
    weights, times = bump(len(states))[:, None] * states, np.arange(len(states))
    count = MIN_ANGLES
    while count <= MAX_ANGLES:
        orders = np.arange(count // 2 + 1)
        waves = np.exp(-2j * np.pi * np.outer(orders, times) * rotation)
        yield np.fft.irfft(waves @ weights * count, count, axis=0)
        count = 2 * count | 1


def _corrected(
    model: Model, vary: str, width: float, period: int, circle: Array, rotation: float
) -> Point | None:
    """Return the invariant circle near a curve at the same parameter, if it is resolved."""
    circles = Circles(model, vary, width, period, circle)
    guess = circles.join(circle, circles.others(rotation, model))
    row = np.zeros(len(guess))
    row[-1] = 1.0
    found = circles.nearest(guess, row)
    resolved = found is not None and tail(circles.states(found.z)) <= TORUS.tail
    return found if resolved else None
