"""An equilibrium and its multipliers from the equations alone, without any flow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.collocation.collocated_orbit import CollocatedOrbit
from slipfold.collocation.vector_field import VectorField
from slipfold.models.model import Model

ITERATIONS = 20

STILL = 1e-13
"""Steps this short, in scaled states, are rounding."""

SINGULAR = 1e-4
"""Singular values below this share of the largest, or of one in the time of the multipliers, are
not divided by at a fold: of one state there is no other."""

CLOSED = 1e-9
"""The state may change by this in the time of the multipliers, in scaled states."""


def exact_equilibrium(
    model: Model,
    guess: NDArray[np.float64],
    anchors: int,
    period: int = 1,
    *,
    singular: bool = False,
) -> CollocatedOrbit:
    r"""Find the equilibrium near a guess; it needs no mesh.

    Its multipliers over the time :math:`\tau` are :math:`e^{\lambda \tau}` with the eigenvalues
    of the Jacobian.

    Shapes: guess (n_states,).
    """
    field = VectorField(model)
    state, step = guess / field.scales, np.inf
    zero = np.zeros(())
    for _ in range(ITERATIONS):
        rates, jacobian = field.linear(state, zero)
        size = float(np.linalg.norm(jacobian)) * field.period
        if singular:
            least = SINGULAR / min(max(size, SINGULAR), 1.0)
            move = np.asarray(-np.linalg.pinv(jacobian, rcond=least) @ rates, dtype=float)
        else:
            move = -np.linalg.lstsq(jacobian, rates, rcond=None)[0]
        previous, step = step, float(np.abs(move).max())
        state = state + move
        if step < STILL or step > previous:
            break
    rates, jacobian = field.linear(state, zero)
    duration = period * field.period
    values = np.exp(np.linalg.eigvals(jacobian).astype(complex) * duration)
    states = np.tile(state * field.scales, (anchors, 1))
    mismatch = float(np.abs(rates).max() * duration)
    return CollocatedOrbit(
        model,
        period,
        np.linspace(0.0, period, anchors + 1),
        states,
        states.copy(),
        duration,
        values[np.argsort(-np.abs(values), kind="stable")],
        mismatch,
        step,
        mismatch < CLOSED,
    )
