"""A steel cantilever of fifteen elements, at whose tip a contact slides on a belt.

Steel of 0.3 m x 20 mm x 2 mm; the tip is pressed with 2 N on a belt whose friction falls with the
speed.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ELEMENTS = 15

LENGTH, WIDTH, HEIGHT, YOUNG, DENSITY = 0.3, 0.02, 0.002, 210e9, 7850.0

OF_MASS, OF_STIFFNESS = 1.0, 1e-6
"""Factors of proportional damping."""

LOAD, MU_S, MU_K, VS = 2.0, 0.4, 0.2, 0.3


def matrices(elements: int = ELEMENTS) -> tuple[Array, Array]:
    """Mass and stiffness of Euler-Bernoulli elements: deflection and slope at each node."""
    l = LENGTH / elements  # noqa: E741
    bent = [[12, 6 * l, -12, 6 * l], [6 * l, 4 * l**2, -6 * l, 2 * l**2]]
    bent += [[-12, -6 * l, 12, -6 * l], [6 * l, 2 * l**2, -6 * l, 4 * l**2]]
    moved = [[156, 22 * l, 54, -13 * l], [22 * l, 4 * l**2, 13 * l, -3 * l**2]]
    moved += [[54, 13 * l, 156, -22 * l], [-13 * l, -3 * l**2, -22 * l, 4 * l**2]]
    mass, stiffness = np.zeros((2, 2 * elements + 2, 2 * elements + 2))
    bending = YOUNG * WIDTH * HEIGHT**3 / 12
    for first in range(0, 2 * elements, 2):
        own = slice(first, first + 4)
        stiffness[own, own] += bending / l**3 * np.array(bent)
        mass[own, own] += DENSITY * WIDTH * HEIGHT * l / 420 * np.array(moved)
    return mass[2:, 2:], stiffness[2:, 2:]


@lru_cache
def modes() -> tuple[list[float], list[float]]:
    """Squared frequencies, and what the tip has of each mode."""
    from scipy.linalg import eigh

    mass, stiffness = matrices()
    squares, vectors = eigh(stiffness, mass)
    return squares.tolist(), vectors[-2].tolist()


def rates(q: Sequence[Any], speed: Any) -> list[Any]:
    """The equations in modal coordinates, those in which rounding matters least."""
    squares, tip = modes()
    count = len(tip)
    moves = tip[0] * q[count]
    for i in range(1, count):
        moves = moves + tip[i] * q[count + i]
    push = LOAD * (MU_K + (MU_S - MU_K) * math.exp(-(speed - moves) / VS))
    return [
        *(q[count + i] for i in range(count)),
        *(
            tip[i] * push - (OF_MASS + OF_STIFFNESS * squares[i]) * q[count + i] - squares[i] * q[i]
            for i in range(count)
        ),
    ]


def rest(speed: float) -> tuple[float, ...]:
    """Where the tip slides and nothing vibrates."""
    squares, tip = modes()
    push = LOAD * (MU_K + (MU_S - MU_K) * math.exp(-speed / VS))
    return (*(part * push / square for part, square in zip(tip, squares, strict=True)),
            *(0.0 for _ in tip))  # fmt: skip
