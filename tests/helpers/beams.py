"""Matrices of beams of cubic elements."""

import numpy as np


def free_beam(count, *, length=1.0, stiffness=1.0, density=1.0):
    """Mass and stiffness of a free Euler-Bernoulli beam: deflection and rotation of each node."""
    h = length / count
    bend = np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2],
                     [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h**2, -6 * h, 4 * h**2]])  # fmt: skip
    move = np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h**2, 13 * h, -3 * h**2],
                     [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h**2, -22 * h, 4 * h**2]]
                    )  # fmt: skip
    m, k = np.zeros((2, 2 * count + 2, 2 * count + 2))
    for first in range(0, 2 * count, 2):
        own = slice(first, first + 4)
        k[own, own] += stiffness * bend / h**3
        m[own, own] += density * move * h / 420
    return m, k
