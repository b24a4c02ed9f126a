"""A cycle as a closed line in scaled states, and how far states are from it."""

from __future__ import annotations

import numpy as np

from slipfold.arrays import Array
from slipfold.models.turns import without_turns
from slipfold.orbits.periodic_orbit import PeriodicOrbit

SAMPLES = 1024
"""Samples between which the line is straight."""


class CycleLine:
    """Straight pieces from sample to sample."""

    def __init__(self, orbit: PeriodicOrbit, scales: Array) -> None:
        self.samples = orbit.sample(SAMPLES)[1]
        self._scales, self._whole = scales, orbit.model.whole_turns
        self._along = self._apart(np.roll(self.samples, -1, axis=0), self.samples)
        self._squares = np.einsum("sa,sa->s", self._along, self._along)

    def distance(self, states: Array) -> Array:
        """Return the distance of states from the line. Shapes: (..., n), returns (...)."""
        flat = states.reshape(-1, states.shape[-1])
        return np.array([self._from(state) for state in flat]).reshape(states.shape[:-1])

    def _from(self, state: Array) -> float:
        apart = self._apart(state, self.samples)
        shares = np.clip(np.einsum("sa,sa->s", apart, self._along) / self._squares, 0.0, 1.0)
        beside = apart - shares[:, None] * self._along
        return float(np.sqrt(np.einsum("sa,sa->s", beside, beside).min()))

    def _apart(self, states: Array, points: Array) -> Array:
        return without_turns(states - points, self._whole) / self._scales
