"""Shooting through stick and slip past an event that is only just met, or only just not met."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Self

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.switched.mode import Mode
from slipfold.flow.switched.mode_equations import Undetermined
from slipfold.flow.switched.switched_motion import Broken, legs
from slipfold.flow.switched.transition import Undecided
from slipfold.models.model import Model
from slipfold.orbits.discretisations.switched_shooting import Passed, SwitchedShooting

OFF_CENTER = 0.25
"""Fraction of the reach by which the event may move away from the middle of the window."""


class MarginalShooting(SwitchedShooting):
    """Orbits that pass an event in a window alike on either side of it.

    So they depend smoothly on everything there, and so does the function that is zero where the
    event is only just met. The node lies at the beginning of the window, where the orbit does the
    same in the next period.

    `met` is the event, with its phase and the `reach` of phases in which nothing else happens.
    """

    level = 0.0
    """Value of the function, over its scale, where it cannot vanish."""

    def __init__(
        self, model: Model, free: Mapping[str, float], period: int, met: Any, lead: float = 0.5
    ) -> None:
        self.met = met
        super().__init__(model, free, period, 1, met.phase - lead * met.reach)
        self._beyond = met.phase + 0.5 * met.reach

    @abstractmethod
    def condition(self, nodes: Array, constants: Constants) -> tuple[float, Array, Array]:
        """Return the function that is zero where the event is met, with its derivatives.

        It is divided by its scale; the derivatives are by scaled states and scaled free parameters.
        Shapes: nodes (1, n); returns (), (n,), (k,).
        """

    @abstractmethod
    def again(self, nodes: Array, constants: Constants) -> Self | None:
        """Return the same for the event as it is found again, None if it is not."""

    @abstractmethod
    def phase_of_event(self, nodes: Array, constants: Constants) -> float | None:
        """Return the phase of the event in the window, None if there is none."""

    def better(self, nodes: Array, constants: Constants) -> Self | None:
        """Return one in whose window the event lies in the middle, None if it does here."""
        phase = self.phase_of_event(nodes, constants)
        if phase is None or abs(phase - self.met.phase) < OFF_CENTER * self.met.reach:
            return None
        met = replace(self.met, phase=phase)
        return self.again(nodes, constants) or type(self)(self.model, self.free, self.period, met)

    def with_period(self, period: int) -> Self:
        """Return the same for orbits of another period."""
        return type(self)(self.model, self.free, period, self.met)

    def shifted(
        self, nodes: Array, constants: Constants, along: Array, rates: Array
    ) -> tuple[Self, Array, Array]:
        """Return the same with an earlier beginning of the window: all steps then are others."""
        other = type(self)(self.model, self.free, self.period, self.met, lead=0.8)
        return other, *self.moved_to(other, nodes, constants, along, rates)

    def beyond(
        self, mode: Mode, state: Array, end: float, constants: Constants, weights: Array
    ) -> Passed:
        """Return what follows the window; nothing where the trajectory cannot continue."""
        flow, begin = self.switched, self._beyond
        try:
            found = list(legs(flow, mode, state, end, constants, weights, begin=begin))
        except (Broken, Undecided, Undetermined):
            return []
        return found if found[-1][0].end <= end else []
