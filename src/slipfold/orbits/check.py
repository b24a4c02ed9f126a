"""An orbit computed again by a method that shares no code with the first."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.collocation import CollocatedOrbit, collocate, exact_equilibrium
from slipfold.flow import flow_of
from slipfold.models.model import Model
from slipfold.text.one_line import OneLine
from slipfold.text.printed_table import PrintedTable

Multipliers = NDArray[np.complex128]

SAMPLES = 128
"""Samples a forcing period that make the guess; Newton's method does the rest."""

REST = 1e-8
"""Where the scaled states of an autonomous model change by less than this in a unit of phase, the
orbit is an equilibrium."""

SINGULAR = 1e-4
"""With a multiplier this near to one, orbits a residual of 1e-12 apart differ by 1e-8 and more:
then the equations are made regular as at a fold."""


@dataclass(frozen=True, eq=False, repr=False)
class OrbitCheck(OneLine):
    """How far an orbit is from the same one by collocation; frozen.

    Parameters
    ----------
    collocated
        The orbit by collocation, with its mesh and multipliers.
    states
        Largest difference of the states at the orbit's nodes, in scaled states.
    duration
        Difference of the durations, as a share.
    multipliers
        Largest difference of the multipliers, as a share of the largest or of one; those that
        coincide are compared by their mean.
    tolerance
        What is allowed of each.
    """

    collocated: CollocatedOrbit
    states: float
    duration: float
    multipliers: float
    tolerance: float

    @property
    def passed(self) -> bool:
        """Whether collocation settled and every difference is within the tolerance."""
        return self._settled and self._largest <= self.tolerance

    @property
    def _settled(self) -> bool:
        """Whether halving the intervals changes less than is allowed; collocation aims at less."""
        return self.collocated.error <= self.tolerance

    @property
    def _largest(self) -> float:
        differences = [self.states, self.duration, self.multipliers, self.collocated.mismatch]
        return float(np.max(differences))  # NaN if any is

    def _line(self) -> str:
        verdict = "within" if self.passed else "not within"
        return (
            f"OrbitCheck: states {self.states:.1e}, duration {self.duration:.1e}, multipliers "
            f"{self.multipliers:.1e}, {verdict} {self.tolerance:.0e}"
        )

    def _rows(self) -> PrintedTable:
        differences = {
            "states": self.states,
            "duration": self.duration,
            "multipliers": self.multipliers,
            "tolerance": self.tolerance,
        }
        lines = [[name, f"{value:.1e}"] for name, value in differences.items()]
        return PrintedTable(["", "difference"], lines, ("",))

    def __str__(self) -> str:
        """Say it in a sentence."""
        found = self.collocated
        differences = (
            f"states differ by {self.states:.1e}, the duration by {self.duration:.1e}, "
            f"multipliers by {self.multipliers:.1e}"
        )
        intervals = f"{len(found.edges) - 1} intervals"
        if not self._settled:
            return (
                f"collocation did not settle on {intervals}, where halving them still changes "
                f"{found.error:.1e}; {differences}"
            )
        verdict = "within" if self.passed else "not within"
        return f"collocation on {intervals}: {differences}, {verdict} {self.tolerance:.0e}"


def orbit_by_collocation(
    model: Model,
    nodes: Array,
    sample: Callable[[int], tuple[Array, Array]],
    period: int,
    multipliers: Multipliers,
) -> CollocatedOrbit:
    """Return the orbit with these nodes and multipliers. Shapes: nodes (m, n); multipliers (n,)."""
    if rests(model, nodes):
        singular = is_singular(multipliers, 0)
        return exact_equilibrium(model, nodes[0], len(nodes), period, singular=singular)
    singular = is_singular(multipliers, 0 if model.forced else 1)
    samples = sample(SAMPLES * period)[1]
    return collocate(model, samples, period, anchors=len(nodes), singular=singular)


def is_singular(multipliers: Multipliers, always: int) -> bool:
    """Whether one multiplier more than always is so near to one that equations are made regular."""
    distance = np.sort(np.abs(multipliers - 1))
    return len(distance) > always and bool(distance[always] < SINGULAR)


def rests(model: Model, states: Array) -> bool:
    """Whether an orbit is an equilibrium. Shapes: states (m, n)."""
    if model.forced:
        return False
    flow = flow_of(model)
    rates = flow.rates(states, np.zeros(len(states)), flow.constants_of(model))
    return bool(np.abs(rates / model.state_scales()).max() < REST)
