"""A mode that is ready to run: its integrator knows the parameters of a motion."""

from __future__ import annotations

from typing import Any

import heyoka as hy
import numpy as np

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.switched.compiled_mode import CompiledMode
from slipfold.flow.switched.events import Ending, Event

STEPS = 20_000
"""Steps of the integrator between two changes at most."""

ARRIVED = int(hy.taylor_outcome.time_limit)
STEP_LIMIT = int(hy.taylor_outcome.step_limit)


class ReadyMode:
    """An integrator with the places of its states: most pieces of a motion differ in them alone."""

    def __init__(
        self, compiled: CompiledMode, integrator: Any, constants: Constants, weights: Array
    ) -> None:
        known = np.concatenate([constants.values, constants.scales])
        integrator.pars[: len(known)] = known
        self.compiled, self.integrator = compiled, integrator
        self.constants = constants
        self._weights = integrator.pars[len(known) : len(known) + len(weights)]
        n, count = len(constants.scales), compiled.contacts
        own = 0 if compiled.slow is None else 3
        self.whole = integrator.state
        self.scaled = self.whole[:n]
        self.slow = self.whole[n : n + own]  # logarithm and angle of slow slip, and the phase
        self.energies = self.whole[n + own :]
        self.dimension = n
        # Of states in their units, and of energies in J
        self.units = np.concatenate([constants.scales, np.ones(own + 2 * count)])
        self.weigh(weights)

    def weigh(self, weights: Array) -> None:
        """Take other sizes of the same slips and forces."""
        self.weights, self._weights[:] = weights, weights
        k = self.compiled.contacts
        self.units[-2 * k : -k] = self.units[-k:] = 1 / (weights[:k] * weights[k : 2 * k])

    def set_out(self, state: Array, phase: float) -> None:
        """Put the integrator at a beginning. Shapes: state (n,)."""
        np.divide(state, self.constants.scales, self.scaled)
        self.energies.fill(0.0)
        if self.compiled.events:
            self.integrator.reset_cooldowns()
        self.integrator.time = phase

    def propagate(self, until: float) -> tuple[Event | None, float]:
        """Integrate up to a time; return what ended it there or before, and when."""
        # By name the number of steps would take as long as a step.
        outcome = int(self.integrator.propagate_until(until, STEPS)[0])
        return self.ending(outcome), self.integrator.time

    def ending(self, outcome: int) -> Event | None:
        """Return what ended a piece of motion; None if it came to where it was asked to."""
        if outcome == ARRIVED:
            return None
        if -len(self.compiled.events) <= outcome < 0:
            event = self.compiled.events[-1 - outcome]
            return None if event.ending is Ending.ARRIVES else event
        return Event(Ending.STIFF if outcome == STEP_LIMIT else Ending.SINGULAR, 0, None)

    def arrived(self) -> tuple[Array, Array]:
        """Return state and energies, shapes (n,) and (2 k,)."""
        found = self.whole * self.units
        return found[: self.dimension], found[-len(self.energies) :]
