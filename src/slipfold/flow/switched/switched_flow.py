"""The flow of a model in each of its modes, ended where a contact changes what it does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache
from threading import Lock
from typing import Any

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from slipfold.flow.cache import cached
from slipfold.flow.equations import Constants
from slipfold.flow.flow import Flow
from slipfold.flow.own_copies import OwnCopies
from slipfold.flow.precision import TOLERANCE
from slipfold.flow.scaled import Scaled, power_of_two
from slipfold.flow.sharp_turns import VERSION, sharp_turns
from slipfold.flow.switched.contact_quantities import ContactQuantities
from slipfold.flow.switched.mode import Mode, Status
from slipfold.flow.switched.mode_equations import (
    ModeEquations,
    contacts_of,
    mode_equations,
    with_given_forces,
)
from slipfold.flow.switched.step_polynomials import StepPolynomials, step_to
from slipfold.models.model import Kind, Model
from slipfold.models.output import Expression, Limit

__all__ = ["Ending", "Event", "Leg", "SwitchedFlow", "switched_flow_of"]

Array = NDArray[np.float64]

BEYOND = 1e-14
"""How far beyond zero, over its size, something has come that counts as having crossed it. Where a
mode begins, slip is exactly zero; a root there would be taken for the one that is sought."""

STEPS = 20_000
"""Steps of the integrator between two changes at most."""


class Ending(Enum):
    """Why a motion does not go on in its mode."""

    STOPS = "slip comes to an end"
    YIELDS = "friction cannot hold any more"
    PARTS = "the normal force vanishes"
    MEETS = "the contact closes"
    LIMIT = "a limit of the model is met"
    STIFF = "too many steps"
    SINGULAR = "no number"


@dataclass(frozen=True)
class Event:
    """A change that a mode may meet."""

    ending: Ending
    which: int  # number of the contact, or of the limit
    expression: Expression  # zero there
    rising: bool = False  # whether it comes from below
    towards: Status = Status.FORTH  # of a contact that yields: how it will slip


@dataclass(frozen=True, eq=False)
class Leg:
    """A piece of motion in one mode."""

    mode: Mode
    begin: float  # phases
    end: float
    state: Array  # at its end, shape (n,)
    energies: Array  # put into the structure by each contact, then heat, in J, shape (2, k)
    event: Event | None  # what ended it; None if it came to where it was asked to
    polynomials: StepPolynomials | None = None  # maps phases to scaled states, if asked for


class SwitchedFlow:
    """The flows of a model's modes; the values of its parameters play no part."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self.contacts = contacts_of(model)
        self._equations = with_given_forces(model, self.contacts)
        self.quantities = ContactQuantities(self.contacts, self._equations)
        beyond = {name for contact in self.contacts for name in contact.limits}
        self.limits: tuple[Limit, ...] = tuple(
            item for item in model.limits if item.name not in beyond
        )
        self._integrators = OwnCopies()
        self._modes: dict[Mode, _CompiledMode] = {}

    def of(self, mode: Mode) -> Flow:
        """Return the flow of a mode by itself, with its derivatives, as of any model."""
        return self._mode(mode).flow

    def held(self, mode: Mode, state: Array, constants: Constants) -> Array:
        """Return a state as the contacts of a mode hold it: what sticks has no slip at all.

        Shapes: state (n,).
        """
        compiled = self._mode(mode)
        if not compiled.held:
            return state
        result = state.copy()
        values = compiled.holding(np.concatenate([state, constants.values]))
        result[compiled.held] = values
        return result

    def run(
        self,
        mode: Mode,
        state: Array,
        begin: float,
        end: float,
        constants: Constants,
        weights: Array,
        *,
        dense: bool = False,
    ) -> Leg:
        """Carry a state on in a mode, until it changes. Shapes: state (n,)."""
        compiled, n = self._mode(mode), len(state)
        integrator = self._integrators.get(str(mode), compiled.integrator)
        integrator.time = begin
        integrator.state[:n] = state / constants.scales
        integrator.state[n:] = 0.0
        integrator.pars[:] = np.concatenate([constants.values, constants.scales, weights])
        if integrator.with_events:
            integrator.reset_cooldowns()
        polynomials, event = None, None
        if dense:
            outcome, polynomials = step_to(integrator, end, STEPS)
        else:
            outcome = int(integrator.propagate_until(end, max_steps=STEPS)[0])
        if -len(compiled.events) <= outcome < 0:
            event = compiled.events[-1 - outcome]
        elif outcome != ARRIVED:
            event = Event(Ending.STIFF if outcome == STEP_LIMIT else Ending.SINGULAR, 0, None)
        final = np.array(integrator.state[:n]) * constants.scales
        energies = np.array(integrator.state[n:]).reshape(2, -1)
        units = 1 / (weights[: len(self.contacts)] * weights[len(self.contacts) : energies.size])
        return Leg(
            mode,
            begin,
            float(integrator.time),
            self.held(mode, final, constants),
            energies * units,
            event,
            polynomials,
        )

    def weights(self, state: Array, constants: Constants) -> Array:
        """Return one over the sizes of slips, of frictions, and of what limits watch.

        They count in the length of a step. Shapes: state (n,).
        """
        around = np.concatenate([state[None], state + np.diag(constants.scales)])
        now = [self.quantities.at(item, 0.0, constants) for item in around]
        slips = np.array([
            [np.linalg.norm(item.slip[place]) for place in self.quantities.places] for item in now
        ])  # fmt: skip
        forces = np.abs([item.holding for item in now])
        slide = (Status.FORTH,) * len(self.contacts)
        flow = self.of(slide)
        values = flow.outputs(around, np.zeros(len(around)), constants)
        watched = [flow.output_index(item.output) for item in self.limits]
        bounds = np.array([item.bound for item in self.limits])
        distances = np.abs(values[:, watched] - bounds)
        return np.concatenate([_over(slips), _over(forces), _over(distances)])

    def _mode(self, mode: Mode) -> _CompiledMode:
        if mode not in self._modes:
            with _BUILDING:
                if mode not in self._modes:
                    equations = mode_equations(self._model, mode)
                    self._modes[mode] = _CompiledMode(equations, self.limits)
        return self._modes[mode]


ARRIVED = int(hy.taylor_outcome.time_limit)
STEP_LIMIT = int(hy.taylor_outcome.step_limit)


def _over(sizes: Array) -> Array:
    largest = np.max(sizes, axis=0, initial=0.0, where=np.isfinite(sizes))
    return 1 / power_of_two(np.where(largest > 0, largest, 1.0))


class _CompiledMode:
    """What runs in one mode, compiled and kept on disk."""

    def __init__(self, mode: ModeEquations, limits: Sequence[Limit]) -> None:
        self._mode, self._limits = mode, limits
        equations = mode.equations
        self.events = _events(mode, limits)
        self.held = [equations.names.index(name) for name in mode.held]
        self.flow = Flow(equations)
        self._key = f"{equations.fingerprint()} {mode.mode} {list(mode.held)}"
        if mode.held:
            inputs = [*equations.states, *equations.coefficients]
            self.holding: Any = cached(
                f"held {self._key}",
                lambda: hy.cfunc(list(mode.held.values()), vars=inputs, compact_mode=True),
            )

    def integrator(self) -> Any:
        """Return the integrator of states and energies."""
        bounds = [(item.output, item.bound) for item in self._limits]
        hy.llvm_state.set_diskcache_enabled(False)
        return cached(
            f"switched tol={TOLERANCE!r} limits={bounds!r} {BEYOND} {VERSION}\n{self._key}",
            self._build,
        )

    def _build(self) -> Any:
        mode, equations = self._mode, self._mode.equations
        scaled, count = Scaled.of(equations), len(mode.contacts)
        symbols = [*equations.coefficients, *scaled.scales]
        known: dict[str, Any] = {str(symbol): hy.par[i] for i, symbol in enumerate(symbols)}
        known[str(equations.phase)] = hy.time
        weights = [hy.par[len(symbols) + i] for i in range(2 * count + len(self._limits))]
        energies = [
            equations.coefficients[-1] * power
            for powers in _powers(mode, weights[:count], weights[count : 2 * count])
            for power in powers
        ]
        rates = [*scaled.rates, *scaled.express(energies)]
        names = [f"energy {place}" for place in range(2 * count)]
        states = [*equations.states, *(hy.expression(name) for name in names)]
        watched = [
            weights[_weight(event, count)] * event.expression
            + (-BEYOND if event.rising else BEYOND)
            for event in self.events
        ]
        events = [
            hy.t_event(item, direction=RISING if event.rising else FALLING)
            for item, event in zip(
                hy.subs(scaled.express(watched), known), self.events, strict=True
            )
        ]
        turns = sharp_turns(equations).scaled(scaled)
        return hy.taylor_adaptive(
            list(zip(states, hy.subs(rates, known), strict=True)),
            state=[0.0] * len(states),
            pars=[0.0] * (len(symbols) + len(weights)),
            tol=TOLERANCE,
            t_events=[*events, *turns.events(known, batch=False)],
            nt_events=turns.passed(known, batch=False),
        )


RISING, FALLING = hy.event_direction.positive, hy.event_direction.negative


def _weight(event: Event, count: int) -> int:
    if event.ending is Ending.STOPS:
        return event.which
    return event.which + (2 * count if event.ending is Ending.LIMIT else count)


def _powers(
    mode: ModeEquations, slips: Sequence[Expression], forces: Sequence[Expression]
) -> tuple[list[Expression], list[Expression]]:
    """Return what each contact puts into the structure, and heat, in units of the weights."""
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


def _events(mode: ModeEquations, limits: Sequence[Limit]) -> tuple[Event, ...]:
    """Return the changes that a mode may meet."""
    found = []
    for which, (contact, status) in enumerate(zip(mode.contacts, mode.mode, strict=True)):
        if status is Status.OPEN:
            normal = hy.subs(contact.normal, mode.held)
            found.append(Event(Ending.MEETS, which, normal, rising=True))
            continue
        if contact.opens:
            found.append(Event(Ending.PARTS, which, mode.normal[which]))
        if status is Status.STICK:
            most = mode.normal[which] * hy.subs(contact.holding, mode.held)
            (friction,) = mode.friction[which]
            found.append(Event(Ending.YIELDS, which, most - friction))
            found.append(Event(Ending.YIELDS, which, most + friction, towards=Status.BACK))
        else:
            slip = hy.subs(contact.slip[0], mode.held)
            found.append(Event(Ending.STOPS, which, slip, rising=status is Status.BACK))
    outputs = dict(mode.equations.outputs)
    return (
        *found,
        *(
            Event(Ending.LIMIT, place, outputs[limit.output] - limit.bound)
            for place, limit in enumerate(limits)
        ),
    )


def switched_flow_of(model: Model) -> SwitchedFlow:
    """Return the switched flow of a model; models with the same equations share one."""
    with _SHARING:
        return _shared(model.kind)


_SHARING = Lock()
_BUILDING = Lock()


@lru_cache(maxsize=64)
def _shared(kind: Kind) -> SwitchedFlow:
    return SwitchedFlow(kind.make())
