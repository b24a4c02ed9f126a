"""An orbit computed again by a method that shares no code with the first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from slipfold.collocation import CollocatedOrbit, collocate, exact_equilibrium
from slipfold.collocation.multipliers import multiplier_difference
from slipfold.flow import flow_of
from slipfold.text.one_line import OneLine
from slipfold.text.printed_table import PrintedTable

if TYPE_CHECKING:
    from slipfold.orbits.periodic_orbit import PeriodicOrbit

__all__ = ["OrbitCheck", "check_orbit", "is_singular", "rests"]

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


def check_orbit(orbit: PeriodicOrbit, tolerance: float = 1e-8) -> OrbitCheck:
    """Compute an orbit by collocation and compare."""
    model, anchors = orbit.model, len(orbit.nodes)
    scales = model.state_scales()
    resting = rests(orbit)
    singular = is_singular(orbit, resting=resting)
    if resting:
        found = exact_equilibrium(model, orbit.state, anchors, orbit.period, singular=singular)
    else:
        _, samples = orbit.sample(SAMPLES * orbit.period)
        found = collocate(model, samples, orbit.period, anchors=anchors, singular=singular)
    size = max(1.0, float(np.abs(orbit.multipliers).max()))
    return OrbitCheck(
        found,
        float(np.abs((found.anchors - orbit.nodes) / scales).max()),
        abs(found.duration / orbit.duration - 1),
        multiplier_difference(orbit.multipliers, found.multipliers) / size,
        tolerance,
    )


def is_singular(orbit: PeriodicOrbit, *, resting: bool) -> bool:
    """Whether it is so near a fold or branch point that the equations are made regular."""
    distance = np.sort(np.abs(orbit.multipliers - 1))
    own = 0 if resting or orbit.model.forced else 1  # one multiplier of a cycle is always one
    return len(distance) > own and bool(distance[own] < SINGULAR)


def rests(orbit: PeriodicOrbit) -> bool:
    """Whether it is an equilibrium."""
    if orbit.model.forced:
        return False
    flow = flow_of(orbit.model)
    constants = flow.constants_of(orbit.model)
    rates = flow.rates(orbit.nodes, np.zeros(len(orbit.nodes)), constants)
    return bool(np.abs(rates / orbit.model.state_scales()).max() < REST)
