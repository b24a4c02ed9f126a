"""The flow of a model in each mode of its contacts, which ends where the mode changes."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from threading import Lock
from typing import Any

import heyoka as hy
import numpy as np

from slipfold.arrays import Array
from slipfold.flow.affine_events import AffineEvents, is_large, pays
from slipfold.flow.affine_flow import flow_of_rates
from slipfold.flow.assembled_modes import AssembledFlow, AssembledSlopes, FreeContacts
from slipfold.flow.batches import ARRIVED, STEP_LIMIT, TOLERANCE, run
from slipfold.flow.compiled_code import OwnCopies, Slopes, StateFunction, cached, shared_by_kind
from slipfold.flow.contact_state import ContactQuantities, ContactsNow
from slipfold.flow.equations import Constants, Scaled, power_of_two
from slipfold.flow.flow import Flow, flow_of
from slipfold.flow.modes import (
    ANGLE,
    CONTACT,
    CONTACT_NUMBERS,
    END,
    LOGARITHM,
    PHASE,
    STUCK,
    Ending,
    Mode,
    ModeEquations,
    Status,
    SwitchingEvent,
    contacts_of,
    events_of,
    is_zero,
    limits_of_contacts,
    mode_equations,
    reported_mode,
    with_given_forces,
)
from slipfold.flow.polynomials import Dense, SlipOnset, SlowPolynomials, StepPolynomials, step_to
from slipfold.flow.sharp_turns import VERSION, SharpTurns, sharp_turns
from slipfold.models.formulas.functions import OPTIMIZATION
from slipfold.models.model import Model
from slipfold.models.quantities import Expression, Limit


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
            hy.expression(f"weight {index}") for index in range(2 * count + len(limits))
        ]
        self.events = events_of(mode, limits, self._weights[:count])
        self.held = [equations.names.index(name) for name in mode.held]
        # Whether held states are constant, as on surfaces with a constant speed
        self.rests = mode.slow is None and all(
            is_zero(equations.field[index]) for index in self.held
        )
        self.slow = mode.mode.index(Status.SLOW) if mode.slow is not None else None
        self.flow = flow_of_rates(equations) if mode.slow is None else Flow(equations)
        if mode.held:
            slow = [] if mode.slow is None else [LOGARITHM, ANGLE]
            result = [*mode.held.values(), *_held_alone(mode)]
            key = f"held {mode.mode} {list(mode.held)}"
            self._holding = StateFunction(key, result, equations, slow)

    def hold(
        self, state: Array, phase: float, constants: Constants, polar: Sequence[float] = ()
    ) -> Array:
        """Return a state in which sticking contacts have no slip.

        `polar` is the logarithm and the angle of slow slip. Shapes: state (n,).
        """
        if not self.held:
            return state
        given = np.concatenate([state, polar]) if len(polar) else state
        values = self._holding.at(given, phase, constants).tolist()
        result = state.copy()
        for index, value in zip(self.held, values, strict=False):
            result[index] = value
        return result

    def hold_all(self, states: Array, phases: Array, constants: Constants, polar: Array) -> Array:
        """Hold many states of slow slip. Shapes: states (p, n); phases (p,); polar (p, 2)."""
        result = states.copy()
        given = np.concatenate([states, polar], axis=1)
        result[:, self.held] = self._holding.along(given, phases, constants)
        return result

    def rest(self, state: Array, phase: float, constants: Constants) -> tuple[float, bool]:
        """Return the held state of a single contact along a line that comes to rest.

        Also return whether friction is clearly below its limit, as in most cases. Shapes: state
        (n,).
        """
        speed, needed, limit = self._holding.at(state, phase, constants).tolist()
        return speed, abs(needed) < limit * (1 - CONTACT.slack)

    def slopes_of(self, event: SwitchingEvent) -> tuple[Slopes, int]:
        """Return the derivatives of events in a mode without slow slip, and the row of an event."""
        same = [
            (item.ending, item.which, item.towards) == (event.ending, event.which, event.towards)
            for item in self._unscaled
        ]
        return self._event_slopes, same.index(True)

    @property
    def _unscaled(self) -> list[SwitchingEvent]:
        """Events but those in scales, at which slow slip begins and ends; the motion goes on."""
        return [event for event in self.events if not event.scaled]

    @cached_property
    def held_slopes(self) -> Slopes:
        """Derivatives of the states that contacts hold, in a mode without slow slip."""
        return Slopes(list(self._mode.held.values()), self._mode.equations)

    @cached_property
    def _event_slopes(self) -> Slopes:
        """Derivatives of what is zero at events, in a mode without slow slip."""
        return Slopes([event.expression for event in self._unscaled], self._mode.equations)

    @cached_property
    def exact(self) -> AffineEvents | None:
        """Its events in closed form; None if they, or the rates, are not affine."""
        return AffineEvents.of(self.flow, self.events, lambda: self._event_slopes, self.contacts)

    def powers(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Return power of each contact on the structure, and heat, in J per phase, (p, 2 k)."""
        return self._powers.along(states, phases, constants)

    @cached_property
    def _powers(self) -> StateFunction:
        equations, ones = self._mode.equations, [hy.expression(1.0)] * self.contacts
        flat = [power for powers in _powers(self._mode, ones, ones) for power in powers]
        result = [equations.coefficients[-1] * power for power in flat]
        return StateFunction("powers", result, equations)

    def held_at(self, constants: Constants) -> list[int]:
        """Return the numbers of the states that contacts hold."""
        return self.held

    def integrator(self) -> Any:
        """Return the integrator of states and energies."""
        bounds = [(item.output, item.bound) for item in self._limits]
        made = f"tol={TOLERANCE!r} {CONTACT_NUMBERS} {VERSION}"
        mode = self._mode
        # A contact's limit, and the speed of its surface, may be numbers that no rate contains.
        more = [event.expression for event in self.events] + [*(mode.slow or ())]
        more += [part for item in mode.contacts for part in (*item.slip, *item.plate)]
        key = f"{mode.equations.fingerprint(more)} {mode.mode} {self.held}"
        return cached(f"switched {made} limits={bounds!r}\n{key}", self._build)

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
        states = [hy.expression(f"energy {index}") for index in range(2 * count)]
        watched = scaled.express([self._watched(event, count) for event in self.events])
        known: dict[str, Any] = {phase: hy.time}
        if mode.slow is not None:
            symbols.append(END)
            known = {phase: PHASE, str(LOGARITHM): CONTACT.unit * LOGARITHM}
            rates = [hy.exp(LOGARITHM) * rate for rate in rates]
            for name in mode.held:
                rates[equations.names.index(name)] = hy.expression(0.0)
            grows, turns = scaled.express(mode.slow)
            own = [grows / CONTACT.unit, turns, hy.exp(LOGARITHM)]
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
        return self._weights[which] * event.expression + (
            -CONTACT.event_distance if event.rising else CONTACT.event_distance
        )


class AssembledMode(CompiledMode):
    """A mode that is assembled; what an integrator needs is derived where it is needed."""

    flow: AssembledFlow

    def __init__(self, free: FreeContacts, mode: Mode, derive: Callable[[Mode], Any]) -> None:
        self.flow = flow = AssembledFlow(free, mode, lambda: derive(mode).flow.equations)
        self.name, self.contacts, self.slow, self.rests = str(mode), len(mode), None, False
        self.events, self._derive = free.events(mode), derive
        rows, size = [free.row(event) for event in self.events], len(free.equations.field)
        self._event_slopes = AssembledSlopes(flow, lambda _: rows)
        self.held_slopes = AssembledSlopes(flow, lambda c: [size + i for i in flow.at(c)[0]])
        self.exact = AffineEvents(flow, self.events, self._event_slopes.affine, len(mode))

    def held_at(self, constants: Constants) -> list[int]:
        """Return the numbers of the states that contacts hold."""
        return self.flow.at(constants)[0]

    def hold(
        self, state: Array, phase: float, constants: Constants, polar: Sequence[float] = ()
    ) -> Array:
        """Return a state in which sticking contacts have no slip."""
        at = self.flow.unknowns(state[None], np.array([phase]), constants)
        return np.asarray(at[0, : len(state)])

    def powers(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Return power of each contact on the structure, and heat."""
        return self.flow.work(states, phases, constants)

    def integrator(self) -> Any:
        """Return the integrator of states and energies."""
        return self._derive(self.flow.mode).integrator()


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
        outcome = int(run(self.integrator.propagate_until, until, CONTACT.max_steps)[0])
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


@dataclass(eq=False, slots=True)  # frozen ones take three times as long to make
class SmoothPhase:
    """A part of a trajectory in one mode; not changed once it is returned."""

    mode: Mode
    begin: float  # phases
    end: float
    state: Array  # at its end, shape (n,)
    energies: Array  # put into the structure by each contact, then heat, in J, shape (2 k,)
    event: SwitchingEvent | None  # what ended it; None at the requested phase
    released: bool = False  # whether it is the onset of slip in the plane
    onset: SlipOnset | None = None  # the solution of a slow onset
    # Maps phases to scaled states, if asked for
    polynomials: Dense | None = None

    @property
    def reported_mode(self) -> Mode:
        """Mode as contacts know it."""
        return reported_mode(self.mode)

    def ended_by(self, ending: Ending) -> SwitchingEvent | None:
        """Return the event that ended it if it is one of a kind."""
        return self.event if self.event is not None and self.event.ending is ending else None


class HybridFlow:
    """The flows of a model's modes, for any values of its parameters."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self.contacts = contacts_of(model)
        self._equations = with_given_forces(model, self.contacts)
        self.quantities = ContactQuantities(self.contacts, self._equations)
        # Whether a contact along a line is the only one, and whether any is in the plane
        self.straight = [len(contact.slip) for contact in self.contacts] == [1]
        self.planar = any(len(contact.slip) == 2 for contact in self.contacts)
        beyond = limits_of_contacts(model)
        self.limits = tuple(item for item in model.limits if item.name not in beyond)
        self._slips = [part for contact in self.contacts for part in contact.slip]
        self._integrators = OwnCopies()
        self._own = _Own()
        self._modes: dict[Mode, CompiledMode] = {}

    @cached_property
    def slips(self) -> Slopes:
        """Derivatives of slips with respect to states, phase and coefficients."""
        return Slopes(self._slips, self._equations)

    def mode(self, mode: Mode) -> CompiledMode:
        """Return the compiled code of a mode."""
        if mode not in self._modes:
            with _BUILDING:
                if mode not in self._modes:
                    free, derive = self._free, self._derived
                    free = free if is_large(self._equations.dimension) else None
                    self._modes[mode] = AssembledMode(free, mode, derive) if free else derive(mode)
        return self._modes[mode]

    def _derived(self, mode: Mode) -> CompiledMode:
        return CompiledMode(mode_equations(self._model, mode), self.limits)

    @cached_property
    def _free(self) -> FreeContacts | None:
        """Its contacts with free forces, None where these cannot be."""
        return FreeContacts.of(self._equations, self.contacts, self.limits)

    def groups(self, constants: Constants) -> list[list[int]]:
        """Return groups of contacts between which the order of changes makes no difference."""
        return self._free.groups(constants) if self._free else [[*range(len(self.contacts))]]

    def of(self, mode: Mode) -> Flow:
        """Return the flow of a mode by itself, with its derivatives, as of any model."""
        return self.mode(reported_mode(mode)).flow

    @cached_property
    def stuck(self) -> CompiledMode:
        """The mode of stick of a single contact."""
        return self.mode(STUCK)

    def held(self, mode: Mode, state: Array, phase: float, constants: Constants) -> Array:
        """Return a state as the contacts of a mode hold it. Shapes: state (n,)."""
        return self.mode(reported_mode(mode)).hold(state, phase, constants)

    def ready(self, mode: Mode, constants: Constants, weights: Array) -> ReadyMode:
        """Return a mode with an integrator of this thread."""
        own = self._own.modes
        ready = own.get(mode)
        if ready is None or ready.constants is not constants:
            compiled = self.mode(mode)
            integrator = self._integrators.get(compiled.name, compiled.integrator)
            ready = own[mode] = ReadyMode(compiled, integrator, constants, weights)
        elif ready.weights is not weights:
            ready.weigh(weights)
        return ready

    def weights(self, state: Array, constants: Constants) -> Array:
        """Return one over the scales of slips, of frictions, and of the outputs of limits.

        They affect the length of a step. Shapes: state (n,).
        """
        around = np.concatenate([state[None], state + np.diag(constants.scales)])
        sizes = *self.quantities.sizes(around, constants), self._distances(around, constants)
        return np.concatenate([_over(part) for part in sizes])

    def system(self, state: Array, constants: Constants, *, energies: bool = True) -> HybridSystem:
        """Return the hybrid system with scales about a state. Shapes: state (n,)."""
        return HybridSystem(self, constants, self.weights(state, constants), energies)

    def _distances(self, states: Array, constants: Constants) -> Array:
        """Return how far states are from the limits, shape (m, limits)."""
        if not self.limits:  # compiling outputs takes time
            return np.empty((len(states), 0))
        flow = self.of((Status.FORTH,) * len(self.contacts))
        return np.abs(flow.margins(self.limits, states, np.zeros(len(states)), constants))


def _polar(slip: Sequence[float] | Array, minimum: float) -> tuple[float, float]:
    """Return logarithm and angle of slip, with a lower bound on the speed."""
    return math.log(max(math.hypot(*slip), minimum)), math.atan2(slip[1], slip[0])


def _over(sizes: Array) -> Array:
    largest = np.max(sizes, axis=0, initial=0.0, where=np.isfinite(sizes))
    return 1 / power_of_two(np.where(largest > 0, largest, 1.0))


@dataclass(frozen=True, eq=False, slots=True)
class HybridSystem:
    """The hybrid flow of a model at values of its parameters."""

    flow: HybridFlow
    constants: Constants
    weights: Array  # one over the scales of slips, frictions and outputs of limits
    energies: bool = True  # whether they are wanted: closed forms are quicker without

    @property
    def places(self) -> tuple[slice, ...]:
        """Components of slip of each contact."""
        return self.flow.quantities.places

    def at(self, state: Array, phase: float) -> ContactsNow:
        """Evaluate contacts at a state. Shapes: state (n,)."""
        return self.flow.quantities.at(state, phase, self.constants)

    def held(self, mode: Mode, state: Array, phase: float) -> Array:
        """Return a state as the contacts of a mode hold it. Shapes: state (n,)."""
        return self.flow.held(mode, state, phase, self.constants)

    def slipping(self, mode: Mode, state: Array, slip: Array, phase: float) -> Array:
        """Return a state with some slow slip in m/s in a mode. Shapes: state (n,); slip (2,)."""
        return self.flow.mode(mode).hold(state, phase, self.constants, _polar(slip, 0.0))

    def run(
        self, mode: Mode, state: Array, begin: float, end: float, *, dense: bool = False
    ) -> SmoothPhase:
        """Integrate a state in a mode until the mode changes. Shapes: state (n,)."""
        if exact := self._exactly(mode, state, begin, end, dense=dense):
            return exact
        ready = self.flow.ready(mode, self.constants, self.weights)
        ready.set_out(state, begin)
        if ready.compiled.slow is not None or dense:
            return self._run_closely(ready, mode, state, begin, end, dense=dense)
        event, time = ready.propagate(end)
        final, energies = ready.arrived()
        if not ready.compiled.rests:
            final = ready.compiled.hold(final, time, self.constants)
        return SmoothPhase(mode, begin, time, final, energies, event)

    def _exactly(
        self, mode: Mode, state: Array, begin: float, end: float, *, dense: bool
    ) -> SmoothPhase | None:
        """Do so in closed form, None where there is none, or where an integrator is quicker."""
        compiled = self.flow.mode(mode)
        if not pays(compiled.flow, self.constants) or compiled.exact is None:
            return None
        if not np.isfinite(state).all():
            return None
        found = compiled.exact.follow(state, begin, end, self.constants, self.weights)
        if found is None:
            return None
        final, energies, polynomials = found.state, np.zeros(2 * len(mode)), None
        if self.energies:
            energies = found.integral(
                lambda states, phases: compiled.powers(states, phases, self.constants)
            )
        if dense:
            polynomials = found.polynomials()
        if not compiled.rests:
            final = compiled.hold(final, found.end, self.constants)
        given = mode, begin, found.end, final, energies, found.event
        return SmoothPhase(*given, polynomials=polynomials)

    def _run_closely(
        self, ready: ReadyMode, mode: Mode, state: Array, begin: float, end: float, *, dense: bool
    ) -> SmoothPhase:
        """Integrate slow slip, or with dense output."""
        compiled, integrator = ready.compiled, ready.integrator
        until, slow = end, compiled.slow
        if slow is not None:
            slip = self.at(state, begin).slip[self.places[slow]]
            logarithm, angle = _polar(slip, 2 * CONTACT.rest / ready.weights[slow])
            ready.slow[:] = logarithm / CONTACT.unit, angle, begin
            integrator.time, until = 0.0, CONTACT.forever
            integrator.pars[-1] = end
        polynomials: StepPolynomials | SlowPolynomials | None = None
        if dense:
            outcome, polynomials = step_to(integrator, until, CONTACT.max_steps)
            event, time = ready.ending(outcome), integrator.time
        else:
            event, time = ready.propagate(until)
        final, energies = ready.arrived()
        polar: tuple[float, ...] = ()
        if slow is not None:
            logarithm, angle, time = ready.slow.tolist()
            polar = (logarithm * CONTACT.unit, angle)
            time = end if event is None else time
            if isinstance(polynomials, StepPolynomials):
                polynomials = self._slowly(compiled, polynomials)
        final = compiled.hold(final, time, self.constants, polar)
        return SmoothPhase(mode, begin, time, final, energies, event, polynomials=polynomials)

    def _slowly(self, compiled: CompiledMode, polynomials: StepPolynomials) -> SlowPolynomials:
        """Return dense output of slow slip."""
        scales = self.constants.scales

        def placed(scaled: Array, polar: Array, phases: Array) -> Array:
            return compiled.hold_all(scaled * scales, phases, self.constants, polar) / scales

        return SlowPolynomials(polynomials, len(scales), placed, compiled.held)

    def without_limits(self, contacts: Sequence[int]) -> HybridSystem:
        """Return the system in which contacts stick without a limit of friction."""
        weights = self.weights.copy()
        weights[len(self.flow.contacts) + np.array(contacts)] *= 2.0**-100
        return HybridSystem(self.flow, self.constants, weights, self.energies)


class _Own(threading.local):
    """The modes with integrators of a thread."""

    def __init__(self) -> None:
        self.modes: dict[Mode, ReadyMode] = {}


def hybrid_system(model: Model, state: Array) -> HybridSystem:
    """Return the hybrid system of a model, with scales about a state. Shapes: state (n,)."""
    return hybrid_flow_of(model).system(state, flow_of(model).constants_of(model))


@shared_by_kind
def hybrid_flow_of(model: Model) -> HybridFlow:
    """Return the hybrid flow of a model; models with the same equations share one."""
    return HybridFlow(model)


_BUILDING = Lock()
