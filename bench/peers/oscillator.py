"""The sliding oscillator as the peers get it: scaled states, scaled time, base case.

Displacements are in units of L, rates in units of 2 pi f L and time in forcing periods, so that
every unknown is of order one and a period-k orbit has period k.
"""

import math
from typing import Any, NamedTuple

TAU = 2 * math.pi

FREQUENCY = 12.5  # Hz
SPEED = 0.6  # m/s
DIRECTION = math.pi / 3  # rad, from the x axis
STEADY_LOAD = 1.0  # N
FRICTION = 0.5
LENGTH = 5e-3  # m
SPRING = 1000.0  # N/m

RATE = TAU * FREQUENCY * LENGTH
"""One unit of scaled rate, in m/s."""

PLATE = (SPEED * math.cos(DIRECTION), SPEED * math.sin(DIRECTION))
"""Velocity of the plate along x and y, in m/s."""

REST = (0.117402977126, 0.061106649797)
"""The static point (x/L, y/L) at Nd = 0, where the period-1 branch begins."""


class Mode(NamedTuple):
    """One direction's own oscillator: stiffness in N/m, mass in kg, damping in N s/m."""

    stiffness: float
    mass: float
    damping: float

    @classmethod
    def of(cls, stiffness: float, frequency: float, ratio: float) -> "Mode":
        """The mode of a given stiffness, natural frequency in Hz and damping ratio."""
        mass = stiffness / (TAU * frequency) ** 2
        return cls(stiffness, mass, 2 * TAU * ratio * mass * frequency)

    @property
    def inertia(self) -> float:
        """Force in N that changes the scaled rate by one in one forcing period."""
        return self.mass * RATE * FREQUENCY


HORIZONTAL = Mode.of(362.58, 6.59, 0.0057)
VERTICAL = Mode.of(317.98, 6.12, 0.006)


def rates(
    x: Any, y: Any, vx: Any, vy: Any, cosine: Any, nd: Any, plate: tuple[float, float] = PLATE
) -> tuple[Any, Any, Any, Any]:
    """Return the scaled rates of change of (x, y, vx, vy).

    Only arithmetic is used, so the arguments may be floats or the symbols of a tracer.

    Parameters
    ----------
    x, y, vx, vy
        Scaled displacements and rates.
    cosine
        The forcing cos(2 pi f t) at this instant.
    nd
        Amplitude of the dynamic load in N.
    plate
        Velocity of the plate along x and y in m/s.
    """
    slip_x = plate[0] - RATE * vx
    slip_y = plate[1] - RATE * vy
    grip = FRICTION * (STEADY_LOAD + nd * cosine) / (slip_x * slip_x + slip_y * slip_y) ** 0.5
    pull = SPRING * LENGTH * (1 - 1 / ((1 + y) * (1 + y) + x * x) ** 0.5)
    force_x = (
        grip * slip_x
        - HORIZONTAL.damping * RATE * vx
        - HORIZONTAL.stiffness * LENGTH * x
        - pull * x
    )
    force_y = (
        grip * slip_y
        - VERTICAL.damping * RATE * vy
        - VERTICAL.stiffness * LENGTH * y
        - pull * (1 + y)
    )
    return TAU * vx, TAU * vy, force_x / HORIZONTAL.inertia, force_y / VERTICAL.inertia
