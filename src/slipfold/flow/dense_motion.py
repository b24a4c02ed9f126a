"""A motion known at every instant, as polynomials from step to step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from slipfold.arrays import Array


@dataclass(frozen=True, eq=False)
class DenseMotion:
    """A motion of an autonomous model over some steps of the integrator."""

    phases: Array  # where the steps begin and end, from zero on, shape (m,)
    polynomials: Any  # maps phases to states in units of the scales
    scales: Array  # units of the states
    implicit: bool = False  # whether it took implicit steps

    @property
    def end(self) -> float:
        """The last phase."""
        return float(self.phases[-1])

    def at(self, phases: Array) -> Array:
        """Return the states at some phases, as exact as the integration, shape (m, n).

        Shapes: phases (m,).
        """
        return np.array(self.polynomials(phases)) * self.scales


class StepPolynomials:
    """What lies between the ends of steps.

    What heyoka offers for this compiles code for each piece of motion, which takes longer than most
    pieces.
    """

    def __init__(self, times: Sequence[float], coefficients: Sequence[Array]) -> None:
        self.times = np.array(times)  # ends of the steps, shape (m + 1,)
        self.tcs = np.array(coefficients)  # of powers of the time in a step, shape (m, n, order)

    def __call__(self, times: Array) -> Array:
        """Return states at some times, shape (p, n). Shapes: times (p,)."""
        place = np.searchsorted(self.times, times, side="right") - 1
        place = np.minimum(np.maximum(place, 0), len(self.tcs) - 1)
        powers = np.vander(times - self.times[place], self.tcs.shape[2], increasing=True)
        return np.asarray((self.tcs[place] @ powers[:, :, None])[:, :, 0])

    def nodes(self, shares: Array) -> tuple[Array, Array, Array]:
        """Return states and times after shares of each step, and the rate of time with the share.

        Shapes: shares (p,); returns (m, p, n), (m, p), (m, p).
        """
        lengths = np.diff(self.times)[:, None]
        times = self.times[:-1, None] + lengths * shares
        powers = np.vander((lengths * shares).ravel(), self.tcs.shape[2], increasing=True)
        powers = powers.reshape(*times.shape, -1)
        return np.einsum("ink,ipk->ipn", self.tcs, powers), times, lengths + np.zeros_like(times)
