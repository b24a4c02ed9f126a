"""An elastic strip of many finite elements, at whose tip friction resists a harmonic force.

Steel of 0.3 m x 20 mm x 5 mm, clamped at one end, in its plane: elements of four nodes with plane
stress. Its lowest mode bends it. Beams of one row of elements are no example: beyond some hundred
of them rounding of their stiffness is visible. Everything scales with the lowest mode, so that
strips of all sizes do the same: damping of 1 %, friction of a quarter of the force, which rises
over a tenth of the velocity at resonance without it.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LENGTH, HEIGHT, DEPTH, YOUNG, POISSON, DENSITY = 0.3, 0.02, 0.005, 210e9, 0.3, 7850.0

MESHES = {20: (5, 1), 100: (10, 4), 1000: (50, 9), 10_000: (200, 24)}
"""Elements along and across, by degrees of freedom."""

DRY_SIZES = (100, 1000)
"""Those with dry friction."""

DAMPING, FORCE, FRICTION, RISE = 0.01, 1.0, 0.25, 0.1

BAND = (0.85, 1.15)
"""Frequencies of the response, over the lowest natural one."""

COMPARED = (0.95, 1.0, 1.05)
"""Those at which the first harmonic of the tip is compared."""


def element(wide: float, high: float) -> tuple[Array, Array]:
    """Mass and stiffness of one element, nodes counterclockwise, (u, v) of each."""
    elastic = np.array([[1, POISSON, 0], [POISSON, 1, 0], [0, 0, (1 - POISSON) / 2]])
    elastic *= YOUNG / (1 - POISSON**2)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    mass, stiffness = np.zeros((2, 8, 8))
    for x in (-(3**-0.5), 3**-0.5):
        for y in (-(3**-0.5), 3**-0.5):
            shapes = (1 + corners[:, 0] * x) * (1 + corners[:, 1] * y) / 4
            along = corners[:, 0] * (1 + corners[:, 1] * y) / (2 * wide)
            across = corners[:, 1] * (1 + corners[:, 0] * x) / (2 * high)
            strains = np.zeros((3, 8))
            strains[0, ::2], strains[1, 1::2] = along, across
            strains[2, ::2], strains[2, 1::2] = across, along
            area = DEPTH * wide * high / 4
            stiffness += area * strains.T @ elastic @ strains
            mass += area * DENSITY * np.kron(np.outer(shapes, shapes), np.eye(2))
    return mass, stiffness


@lru_cache
def matrices(size: int) -> tuple[Any, Any, int]:
    """Sparse mass and stiffness, and which displacement is that of the tip across."""
    from scipy.sparse import csc_array

    columns, rows = MESHES[size]
    small = element(LENGTH / columns, HEIGHT / rows)
    first = (np.arange(columns)[:, None] * (rows + 1) + np.arange(rows)).ravel()
    nodes = first[:, None] + [0, rows + 1, rows + 2, 1]
    places = (2 * nodes[:, :, None] + [0, 1]).reshape(len(first), 8)
    total, fixed = 2 * (columns + 1) * (rows + 1), 2 * (rows + 1)
    i, j = np.repeat(places, 8, axis=1).ravel(), np.tile(places, (1, 8)).ravel()
    mass, stiffness = (
        csc_array((np.tile(part.ravel(), len(first)), (i, j)), shape=(total, total))
        for part in small
    )
    return mass[fixed:, fixed:], stiffness[fixed:, fixed:], total - fixed - 2 * (rows // 2) - 1


@dataclass(frozen=True)
class Strip:
    """A strip with its numbers."""

    mass: Any
    stiffness: Any
    tip: int
    lowest: float  # circular frequency in rad/s
    beta: float  # of damping proportional to stiffness, in s
    rise: float  # of friction, in m/s


@lru_cache
def strip(size: int) -> Strip:
    """The strip of so many degrees of freedom."""
    from scipy.sparse.linalg import eigsh

    mass, stiffness, tip = matrices(size)
    squares, shapes = eigsh(stiffness, 1, mass, sigma=0.0, v0=np.ones(size))
    lowest = float(np.sqrt(squares[0]))
    velocity = FORCE * float(shapes[tip, 0]) ** 2 / (2 * DAMPING * lowest)
    return Strip(mass, stiffness, tip, lowest, 2 * DAMPING / lowest, RISE * velocity)
