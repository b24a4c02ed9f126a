"""A periodic orbit through stick and slip as data."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow import flow_of
from slipfold.flow.last_round import LastRound, StickTime, round_with_stick
from slipfold.flow.switched.mode import Mode, shown
from slipfold.flow.switched.sampled import Samples, sample_switched
from slipfold.flow.switched.switched_flow import switched_flow_of
from slipfold.flow.switched.switched_motion import first_mode
from slipfold.models.turns import turns_between, turns_by_name
from slipfold.orbits.check import OrbitCheck
from slipfold.orbits.discretisations.switched_shooting import SwitchedShooting
from slipfold.orbits.extrema import Extrema
from slipfold.orbits.kinds import orbits_of
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.orbits.spectrum.floquet import floquet_multipliers
from slipfold.orbits.uncertainty import multiplier_change

SAMPLES = 512
"""Samples a forcing period between which outputs other than states turn; parabolas do the rest."""


IN_THE_PLANE = 5e-7
"""What the linearisation leaves out where slip in the plane begins and ends."""


@dataclass(frozen=True, eq=False, repr=False)
class StickSlipOrbit(PeriodicOrbit):
    """A periodic orbit whose contacts stick, slip back and forth, or open on the way; frozen.

    Its multipliers are those of the true linearisation, jumps at the changes included: what a stuck
    contact loses has the multiplier zero.
    """

    @property
    def sticking(self) -> tuple[StickTime, ...]:
        """When contacts stick, from phase zero."""
        return self._round.sticking

    @property
    def stuck_fraction(self) -> float:
        """Share of the period in which a contact sticks."""
        return self._round.fraction

    def sample(self, count: int = 256) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Sample the states over one period, through stick and slip."""
        phases: Array = np.arange(count, dtype=float) * (self.period / count)
        return phases * self._forcing_period, self._samples(phases).states

    def _outputs(self, count: int) -> tuple[Array, Array]:
        """Sample all outputs over one period through stick and slip, shape (count, n_outputs)."""
        phases: Array = np.arange(count, dtype=float) * (self.period / count)
        return phases * self._forcing_period, self._samples(phases).outputs()

    @property
    def _forcing_period(self) -> float:
        return self.duration / self.period

    def check(self, tolerance: float = 1e-8) -> OrbitCheck:
        """Refuse: collocation, the second method, does not go through stick and slip."""
        raise InputError(
            "an orbit that sticks cannot be computed again by collocation; its "
            "multiplier_uncertainty comes from other steps of the same method"
        )

    @cached_property
    def turns(self) -> dict[str, int]:
        """Whole turns that each angle makes in a period, by name; none where no state is one."""
        end = self._samples(np.array([0.0, float(self.period)])).states[-1]
        return turns_by_name(
            self.model.states, turns_between(end - self.state, self.model.whole_turns)
        )

    @cached_property
    def multiplier_uncertainty(self) -> NDArray[np.float64]:
        """Computed uncertainty of each multiplier, begun elsewhere on the orbit."""
        name = next(item.name for item in self.model.parameters if item.name != "duration")
        orbits = orbits_of(self.model, {name: 1.0}, self.period, 1, by=SwitchedShooting)
        z = orbits.unknown(self.nodes[:1], self.model)
        other, moved, _ = orbits.shifted(z, np.eye(1, len(z), len(z) - 1)[0])
        monodromy = other.linearise(moved).product
        change = multiplier_change(self.multipliers, floquet_multipliers(monodromy), monodromy)
        planar = any(len(contact.slip) == 2 for contact in switched_flow_of(self.model).contacts)
        return np.maximum(change, IN_THE_PLANE) if planar and self.stuck_fraction else change

    @cached_property
    def extrema(self) -> Extrema:
        """Minimum and maximum of every output: of states wherever they lie, of others sampled."""
        found, count = self._round, SAMPLES * self.period
        phases: Array = np.arange(count + 1, dtype=float) * (self.period / count)
        values = self._samples(phases).outputs()
        with np.errstate(invalid="ignore"):  # an output may be infinite at rest
            low, high, n = _least(values), -_least(-values), len(found.least)
        low[:n], high[:n] = found.least, found.most
        if np.isnan(found.fraction):  # of part of a round they would be others
            low[:], high[:] = np.nan, np.nan
        return Extrema(flow_of(self.model).output_names, low[None], high[None])

    def extrema_of(self, output: str) -> Extrema:
        """Return minimum and maximum of one output."""
        flow_of(self.model).output_index(output)
        return self.extrema

    @cached_property
    def _round(self) -> LastRound:
        names = [item.name for item in switched_flow_of(self.model).contacts]
        return round_with_stick(
            self.model, self.state, self.first_mode, names, self.period, repeats=True
        )

    @cached_property
    def first_mode(self) -> Mode:
        """What its contacts do at phase zero."""
        flow, constants = switched_flow_of(self.model), flow_of(self.model).constants_of(self.model)
        weights = flow.weights(self.state, constants)
        return shown(first_mode(flow, self.state, constants, weights))

    def _samples(self, phases: Array) -> Samples:
        return sample_switched(self.model, self.state, self.first_mode, phases)


def _least(values: Array) -> Array:
    """Return the minima of outputs, of parabolas where samples turn. Shapes: values (m, q)."""
    before, middle, after = values[:-2], values[1:-1], values[2:]
    bend = after - 2 * middle + before
    turns = (middle < before) & (middle < after) & (bend > 0)
    fall = np.where(turns, (after - before) ** 2 / (8 * np.where(turns, bend, 1.0)), 0.0)
    return np.asarray(np.minimum(values.min(axis=0), (middle - fall).min(axis=0)))
