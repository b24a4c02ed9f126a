"""Orbits of one branch that are carried side by side, with what is watched along them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.orbits.kinds import ForcedOrbits
from slipfold.orbits.orbit_batch import TESTS, Corrected


@dataclass(frozen=True, eq=False)
class CarriedCurve:
    """Orbits of one branch in order, with what is watched along them."""

    orbits: ForcedOrbits  # what the branch consists of
    z: Array  # the orbits as unknowns, shape (k, ...)
    tangents: Array  # unit tangents of the branch, shape (k, ...)
    multipliers: NDArray[np.complex128]  # their multipliers, shape (k, n)
    tests: dict[str, Array]  # test functions at each of them, by name
    reach: float  # arclength up to which the known branch could be carried
    whole: bool  # whether that is all of it

    @property
    def arclength(self) -> Array:
        """Chords added up, shape (k,)."""
        steps = np.linalg.norm(np.diff(self.z, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)])

    @property
    def unstable(self) -> NDArray[np.int64]:
        """Multipliers outside the unit circle, shape (k,)."""
        return (np.abs(self.multipliers) > 1).sum(axis=1)


def curve_through(
    orbits: ForcedOrbits,
    found: Corrected,
    rows: list[int] | slice = slice(None),
    reach: float = np.inf,
    whole: bool = True,
) -> CarriedCurve:
    """Return some corrected orbits with what is watched along them."""
    tests = {name: found.tests[rows, TESTS.index(name)] for name in ("PD", "NS", "LP")}
    z, tangents = found.z[rows], found.tangents[rows]
    return CarriedCurve(orbits, z, tangents, found.multipliers[rows], tests, reach, whole)
