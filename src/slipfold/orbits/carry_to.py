"""An orbit carried to other values of parameters."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from dataclasses import replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.continuation.newton import correct
from slipfold.continuation.settings import Stepping, Steps
from slipfold.continuation.walk import Failure, walk
from slipfold.orbits.discretisations.discretisation import Discretisation
from slipfold.orbits.linearisation import Conditions, Linearisation
from slipfold.orbits.orbit_curve import OrbitCurve, Orbits
from slipfold.orbits.orbit_point import OrbitPoint

Values = NDArray[np.complex128]

FIRST = 0.01
"""First step, as a share of the parameter's scale."""

CARRYING = Stepping(steps=Steps(smallest=1e-4, points=500))
"""An orbit that has to creep does not arrive. Where a contact begins to stick, each orbit found by
steps of 1e-6 takes tens of thousands of steps of the integrator, to no end."""


def hold_parameter(size: int) -> Array:
    """Return the constraint that keeps the parameter at its guess."""
    row = np.zeros(size + 1)
    row[-1] = 1.0
    return row


def carry_to(
    curve: OrbitCurve,
    z: Array,
    target: float,
    refuse: Callable[[OrbitPoint], str | None],
    stepping: Stepping = CARRYING,
) -> OrbitPoint | Failure:
    """Follow a curve from an orbit to where its last parameter has another value, round its folds.

    `refuse` says what is wrong with an orbit on the way, if anything is.
    """
    width = float(curve.orbits.width)
    begin, end = float(z[-1]), target / width
    correction = correct(curve, z, hold_parameter(len(z) - 1) * (np.sign(end - begin) or 1.0))
    if not correction.converged:
        return Failure("failed", correction.failure)
    start = curve.point(correction, 0.0)
    if begin == end:
        return start
    reached = None
    for point in walk(curve, [start], FIRST, [(-1, min(begin, end), max(begin, end))], stepping):
        if isinstance(point, Failure):
            return point
        wrong = refuse(point)
        if wrong is not None:
            return Failure("limit", wrong)
        reached = point
    if reached is None or reached.z[-1] != end:
        return Failure("turned", "it turns back before")
    return reached


class Straight(OrbitCurve):
    """Orbits in two parameters that lie on a straight line.

    `begin` and `end` are two places on it, in the units of the parameters.
    """

    def __init__(self, orbits: Orbits, begin: Array, end: Array) -> None:
        self.orbits = orbits
        self._begin = begin / orbits.widths
        x, y = end / orbits.widths - self._begin
        self._across = np.array([-y, x]) / np.hypot(x, y)

    def _beside(self, z: Array) -> float:
        return float(self._across @ (z[-2:] - self._begin))

    def defect(self, z: Array) -> Array:
        """Return what Newton's method brings to zero."""
        return np.append(self.orbits.defect(z), self._beside(z))

    def linearise(self, z: Array) -> Linearisation:
        """Return the defect with its derivatives."""
        gradient = np.zeros((1, len(z)))
        gradient[0, -2:] = self._across
        conditions = Conditions(np.array([self._beside(z)]), gradient)
        return replace(self.orbits.linearise(z), conditions=conditions)

    def described_by(self, by: Discretisation) -> Self:
        """Return the same in terms of another discretisation."""
        other = copy(self)
        other.orbits = self.orbits.described_by(by)
        return other

    def shifted(self, z: Array, tangent: Array) -> tuple[Self, Array, Array]:
        """Return the same orbit and direction, so described that all errors are others."""
        other = copy(self)
        other.orbits, moved, direction = self.orbits.shifted(z, tangent)
        return other, moved, direction

    def tests(
        self, z: Array, linearisation: Linearisation, multipliers: Values, tangent: Array
    ) -> dict[str, float]:
        """Return what tells a fold; stability is looked at point by point."""
        return {"LP": float(tangent[-1])}
