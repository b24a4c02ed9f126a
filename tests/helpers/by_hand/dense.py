"""Segments of orbits, integrated by SciPy on the equations written by hand."""

import numpy as np
from scipy.integrate import solve_ivp

from helpers.by_hand.sliding import BASE, rhs


def carry(state, values, start, end, *, phases=None):
    """Carry a state between two phases; with `phases`, return the states there, shape (m, 4)."""
    p = {**BASE, **values}
    solution = solve_ivp(
        lambda phase, q: rhs(phase / p["f"], q, p) / p["f"],
        (start, end),
        np.asarray(state, dtype=float),
        method="DOP853",
        rtol=1e-12,
        atol=1e-14,
        t_eval=phases,
    )
    assert solution.success
    return solution.y[:, -1] if phases is None else solution.y.T


def scales(values):
    """Displacements count in L, their rates in L times the circular frequency."""
    rate = 2 * np.pi * values["f"]
    return np.array([1.0, 1.0, rate, rate])
