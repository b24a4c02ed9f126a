"""Compiled code of one mode: an integrator with events, and functions of its contacts."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import heyoka as hy
import numpy as np

from slipfold.arrays import Array
from slipfold.flow.batches import ARRIVED, OPTIMIZATION, STEP_LIMIT, TOLERANCE
from slipfold.flow.compiled_code import cached
from slipfold.flow.contact_state import SLACK, Arguments, Slopes, many
from slipfold.flow.equations import Constants, Scaled
from slipfold.flow.flow import Flow
from slipfold.flow.modes import (
    ANGLE,
    END,
    LOGARITHM,
    PHASE,
    REST,
    SLOW,
    STUCK,
    Ending,
    Mode,
    ModeEquations,
    Status,
    SwitchingEvent,
    events_of,
    is_zero,
)
from slipfold.flow.polynomials import UNIT
from slipfold.flow.sharp_turns import VERSION, SharpTurns, sharp_turns
from slipfold.models.formulas.functions import compiled_function
from slipfold.models.quantities import Expression, Limit

BEYOND = TOLERANCE / 10
"""Distance beyond zero, over the scale, at which an event triggers. Slip is exactly zero where a
mode begins, and a root there must not be an event."""


class CompiledMode:
    """Compiled code of one mode, stored on disk.

    Parameters of the integrator are coefficients, scales, and one over the scales of slips, of
    frictions and of outputs of limits; with slow slip the requested phase comes last. States are
    those of the model, with slow slip its logarithm, its angle and the phase, then the energies.
    """

    def __init__(self, mode: ModeEquations, limits: Sequence[Limit]) -> None:
        self._mode, self._limits = mode, limits
        count = len(mode.contacts)
        self.name = str(mode.mode)
        self.contacts = count
        equations = mode.equations
        self._weights = [
            hy.expression(f"weight {place}") for place in range(2 * count + len(limits))
        ]
        self.events = events_of(mode, limits, self._weights[:count])
        # Next mode of a single contact along a line by the outcome of the integration
        self.follows = _follows(self.events) if count == 1 else {}
        self.held = [equations.names.index(name) for name in mode.held]
        # Whether held states are constant, as on surfaces with a constant speed
        self.rests = mode.slow is None and all(
            is_zero(equations.field[place]) for place in self.held
        )
        # Whether all rates are constant, of contacts along lines
        constant = {str(item) for item in equations.coefficients}
        self.steady = all(len(contact.slip) == 1 for contact in mode.contacts) and (
            constant.issuperset(hy.get_variables(list(equations.field)))
        )
        self.slow = mode.mode.index(Status.SLOW) if mode.slow is not None else None
        self.flow = Flow(equations)
        self._key = f"{equations.fingerprint()} {mode.mode} {list(mode.held)}"
        if mode.held:
            slow = [] if mode.slow is None else [LOGARITHM, ANGLE]
            inputs = [*equations.states, *slow, equations.phase, *equations.coefficients]
            result = [*mode.held.values(), *_held_alone(mode)]
            self._holding: Any = cached(
                f"held at a phase and by what {self._key}",
                lambda: compiled_function(result, inputs),
            )
            self._arguments = Arguments()

    def hold(
        self, state: Array, phase: float, constants: Constants, polar: Sequence[float] = ()
    ) -> Array:
        """Return a state in which sticking contacts have no slip.

        `polar` is the logarithm and the angle of slow slip. Shapes: state (n,).
        """
        if not self.held:
            return state
        if len(polar):
            known = np.concatenate([state, polar, (phase,), constants.values])
        else:
            known = self._arguments.of(state, phase, constants)
        result = state.copy()
        for place, value in zip(self.held, self._holding(known).tolist(), strict=False):
            result[place] = value
        return result

    def hold_all(self, states: Array, phases: Array, constants: Constants, polar: Array) -> Array:
        """Hold many states of slow slip. Shapes: states (p, n); phases (p,); polar (p, 2)."""
        result = states.copy()
        known = many(np.concatenate([states, polar], axis=1), phases, constants)
        result[:, self.held] = self._holding(known).T
        return result

    def rest(self, state: Array, phase: float, constants: Constants) -> tuple[float, bool]:
        """Return the held state of a single contact along a line that comes to rest.

        Also return whether friction is clearly below its limit, as in most cases. Shapes: state
        (n,).
        """
        known = self._arguments.of(state, phase, constants)
        speed, needed, most = self._holding(known).tolist()
        return speed, abs(needed) < most * (1 - SLACK)

    def slopes_of(self, event: SwitchingEvent) -> tuple[Slopes, int]:
        """Return the derivatives of events in a mode without slow slip, and the row of an event."""
        same = [
            (item.ending, item.which, item.towards) == (event.ending, event.which, event.towards)
            for item in self.events
        ]
        return self._event_slopes, same.index(True)

    @cached_property
    def held_slopes(self) -> Slopes:
        """Derivatives of the states that contacts hold, in a mode without slow slip."""
        return Slopes(list(self._mode.held.values()), self._mode.equations)

    @cached_property
    def _event_slopes(self) -> Slopes:
        """Derivatives of what is zero at events, in a mode without slow slip."""
        return Slopes([event.expression for event in self.events], self._mode.equations)

    @cached_property
    def powers(self) -> Any:
        """Power of each contact on the structure, and heat, in J per phase, compiled."""
        equations, ones = self._mode.equations, [hy.expression(1.0)] * self.contacts
        result = [
            equations.coefficients[-1] * power
            for powers in _powers(self._mode, ones, ones)
            for power in powers
        ]
        inputs = [*equations.states, equations.phase, *equations.coefficients]
        return cached(f"powers {self._key}", lambda: compiled_function(result, inputs))

    def integrator(self) -> Any:
        """Return the integrator of states and energies."""
        bounds = [(item.output, item.bound) for item in self._limits]
        hy.llvm_state.set_diskcache_enabled(False)
        made = f"tol={TOLERANCE!r} level={OPTIMIZATION} {BEYOND, REST, SLOW, UNIT} {VERSION}"
        return cached(f"switched {made} limits={bounds!r}\n{self._key}", self._build)

    def _build(self) -> Any:
        mode, equations = self._mode, self._mode.equations
        scaled, count = Scaled.of(equations), len(mode.contacts)
        symbols = [*equations.coefficients, *scaled.scales, *self._weights]
        phase = str(equations.phase)
        energies = [
            equations.coefficients[-1] * power
            for powers in _powers(mode, self._weights[:count], self._weights[count : 2 * count])
            for power in powers
        ]
        rates = [*scaled.rates, *scaled.express(energies)]
        states = [hy.expression(f"energy {place}") for place in range(2 * count)]
        watched = scaled.express([self._watched(event, count) for event in self.events])
        known: dict[str, Any] = {phase: hy.time}
        if mode.slow is not None:
            symbols.append(END)
            known = {phase: PHASE, str(LOGARITHM): UNIT * LOGARITHM}
            rates = [hy.exp(LOGARITHM) * rate for rate in rates]
            for name in mode.held:
                rates[equations.names.index(name)] = hy.expression(0.0)
            grows, turns = scaled.express(mode.slow)
            own = [grows / UNIT, turns, hy.exp(LOGARITHM)]
            rates[equations.dimension : equations.dimension] = own
            states = [LOGARITHM, ANGLE, PHASE, *states]
        known |= {str(symbol): hy.par[i] for i, symbol in enumerate(symbols)}
        events = [
            hy.t_event(item, direction=RISING if event.rising else FALLING)
            for item, event in zip(hy.subs(watched, known), self.events, strict=True)
        ]
        # Laws do not turn sharply within slow slip.
        turns_sharply = sharp_turns(equations).scaled(scaled) if mode.slow is None else SharpTurns()
        return hy.taylor_adaptive(
            list(zip([*equations.states, *states], hy.subs(rates, known), strict=True)),
            state=[0.0] * len(rates),
            pars=[0.0] * len(symbols),
            tol=TOLERANCE,
            opt_level=OPTIMIZATION,
            t_events=[*events, *turns_sharply.events(known, batch=False)],
            nt_events=turns_sharply.passed(known, batch=False),
        )

    def _watched(self, event: SwitchingEvent, count: int) -> Expression:
        """Return the scaled function of an event, with its root slightly shifted."""
        if event.scaled:
            return event.expression
        which = event.which
        if event.ending is Ending.LIMIT:
            which += 2 * count
        elif event.ending is not Ending.STOPS:
            which += count
        return self._weights[which] * event.expression + (-BEYOND if event.rising else BEYOND)


def _follows(events: Sequence[SwitchingEvent]) -> dict[int, Mode]:
    after = {Ending.STOPS: STUCK}
    after_each = {
        -1 - place: (event.towards,) if event.ending is Ending.YIELDS else after.get(event.ending)
        for place, event in enumerate(events)
    }
    return {outcome: mode for outcome, mode in after_each.items() if mode is not None}


def _held_alone(mode: ModeEquations) -> list[Expression]:
    """Return friction in stick of a single contact along a line, and its limit."""
    if mode.mode != (Status.STICK,) or len(mode.friction[0]) > 1:
        return []
    return [mode.friction[0][0], mode.normal[0] * hy.subs(mode.contacts[0].holding, mode.held)]


RISING, FALLING = hy.event_direction.positive, hy.event_direction.negative


def _powers(
    mode: ModeEquations, slips: Sequence[Expression], forces: Sequence[Expression]
) -> tuple[list[Expression], list[Expression]]:
    """Return the power of each contact on the structure, and heat, in units of the weights."""
    given, heat = [], []
    for contact, friction, slip, force in zip(
        mode.contacts, mode.friction, slips, forces, strict=True
    ):
        parts = list(zip(friction, contact.plate, contact.slip, strict=True))
        lost = hy.sum([item * moved for item, _, moved in parts])
        driven = hy.sum([item * plate for item, plate, _ in parts])
        given.append(hy.subs(slip * force * (driven - lost), mode.held))
        heat.append(hy.subs(slip * force * lost, mode.held))
    return given, heat


STEPS = 20_000
"""Largest number of integrator steps between two changes."""


class ReadyMode:
    """An integrator with views of its states, which alone differ between most smooth phases."""

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
        # Units of the states, and of energies in J
        self.units = np.concatenate([constants.scales, np.ones(own + 2 * count)])
        self.weigh(weights)

    def weigh(self, weights: Array) -> None:
        """Set other scales of slips and forces."""
        self.weights, self._weights[:] = weights, weights
        k = self.compiled.contacts
        self.units[-2 * k : -k] = self.units[-k:] = 1 / (weights[:k] * weights[k : 2 * k])

    def set_out(self, state: Array, phase: float) -> None:
        """Set the initial state. Shapes: state (n,)."""
        np.divide(state, self.constants.scales, self.scaled)
        self.energies.fill(0.0)
        if self.compiled.events:
            self.integrator.reset_cooldowns()
        self.integrator.time = phase

    def propagate(self, until: float) -> tuple[SwitchingEvent | None, float]:
        """Integrate up to a time; return the event that ended it, and when."""
        # A keyword argument would take as long as a step.
        outcome = int(self.integrator.propagate_until(until, STEPS)[0])
        return self.ending(outcome), self.integrator.time

    def ending(self, outcome: int) -> SwitchingEvent | None:
        """Return the event that ended the integration; None at the requested end."""
        if outcome == ARRIVED:
            return None
        if -len(self.compiled.events) <= outcome < 0:
            event = self.compiled.events[-1 - outcome]
            return None if event.ending is Ending.ARRIVES else event
        return SwitchingEvent(Ending.STIFF if outcome == STEP_LIMIT else Ending.SINGULAR, 0, None)

    def arrived(self) -> tuple[Array, Array]:
        """Return state and energies, shapes (n,) and (2 k,)."""
        result = self.whole * self.units
        return result[: self.dimension], result[-len(self.energies) :]
