"""The grid of the map of thresholds, and those of its points that other programs get."""

import math
import random

SIZE = 100

SPEEDS, DIRECTIONS = (0.3, 1.2), (math.radians(20), math.radians(80))
"""Ends of the axes: Vd in m/s, alpha in rad."""

LAST = 0.98
"""Nd in N up to which a threshold is sought."""


def places(size: int) -> tuple[list[float], list[float]]:
    """Values of Vd and alpha."""

    def between(ends: tuple[float, float]) -> list[float]:
        return [ends[0] + (ends[1] - ends[0]) * i / (size - 1) for i in range(size)]

    return between(SPEEDS), between(DIRECTIONS)


def picked(count: int, size: int = SIZE) -> list[tuple[int, int]]:
    """Indices of points picked at random, the same every time."""
    source = random.Random(0)
    return [(source.randrange(size), source.randrange(size)) for _ in range(count)]
