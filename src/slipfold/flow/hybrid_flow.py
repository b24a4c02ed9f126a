"""The flow of a model in each mode of its contacts, which ends where the mode changes."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from threading import Lock

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.compiled_code import OwnCopies, shared_by_kind
from slipfold.flow.compiled_mode import STEPS, CompiledMode, ReadyMode
from slipfold.flow.contact_state import ContactQuantities, ContactsNow, Slopes
from slipfold.flow.equations import Constants, power_of_two
from slipfold.flow.flow import Flow, flow_of
from slipfold.flow.modes import (
    REST,
    STUCK,
    Mode,
    Status,
    SwitchingEvent,
    contacts_of,
    mode_equations,
    shown,
    with_given_forces,
)
from slipfold.flow.polynomials import (
    UNIT,
    BegunPolynomials,
    SlowPolynomials,
    StepPolynomials,
    step_to,
)
from slipfold.flow.slip_onset import SlipOnset
from slipfold.models.model import Model
from slipfold.models.quantities import Limit

FOREVER = 1e30
"""End of the rescaled time, beyond that of any trajectory."""


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
    polynomials: StepPolynomials | SlowPolynomials | BegunPolynomials | None = None

    @property
    def seen(self) -> Mode:
        """Mode as contacts know it."""
        return shown(self.mode)


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
        beyond = {name for contact in self.contacts for name in contact.limits}
        self.limits: tuple[Limit, ...] = tuple(
            item for item in model.limits if item.name not in beyond
        )
        slips = [part for contact in self.contacts for part in contact.slip]
        self._slips = slips
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
                    equations = mode_equations(self._model, mode)
                    self._modes[mode] = CompiledMode(equations, self.limits)
        return self._modes[mode]

    def of(self, mode: Mode) -> Flow:
        """Return the flow of a mode by itself, with its derivatives, as of any model."""
        return self.mode(shown(mode)).flow

    @cached_property
    def stuck(self) -> CompiledMode:
        """The mode of stick of a single contact."""
        return self.mode(STUCK)

    def held(self, mode: Mode, state: Array, phase: float, constants: Constants) -> Array:
        """Return a state as the contacts of a mode hold it. Shapes: state (n,)."""
        return self.mode(shown(mode)).hold(state, phase, constants)

    def no_energies(self) -> Array:
        """Return the energies of a smooth phase without duration, shape (2 k,)."""
        return np.zeros(2 * len(self.contacts))

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
        now = self.quantities.along(around, np.zeros(len(around)), constants)
        slips = np.array([
            [math.hypot(*item.slip[place]) for place in self.quantities.places] for item in now
        ])  # fmt: skip
        forces = np.abs([item.holding for item in now])
        return np.concatenate(
            [_over(slips), _over(forces), _over(self._distances(around, constants))]
        )

    def system(self, state: Array, constants: Constants) -> HybridSystem:
        """Return the hybrid system with scales about a state. Shapes: state (n,)."""
        return HybridSystem(self, constants, self.weights(state, constants))

    def _distances(self, states: Array, constants: Constants) -> Array:
        """Return how far states are from the limits, shape (m, limits)."""
        if not self.limits:  # compiling outputs takes time
            return np.empty((len(states), 0))
        flow = self.of((Status.FORTH,) * len(self.contacts))
        values = flow.outputs(states, np.zeros(len(states)), constants)
        watched = [flow.output_index(item.output) for item in self.limits]
        return np.abs(values[:, watched] - np.array([item.bound for item in self.limits]))


def _polar(slip: Sequence[float] | Array, least: float) -> tuple[float, float]:
    """Return logarithm and angle of slip, with a lower bound on the speed."""
    return math.log(max(math.hypot(*slip), least)), math.atan2(slip[1], slip[0])


def _over(sizes: Array) -> Array:
    largest = np.max(sizes, axis=0, initial=0.0, where=np.isfinite(sizes))
    return 1 / power_of_two(np.where(largest > 0, largest, 1.0))


@dataclass(frozen=True, eq=False, slots=True)
class HybridSystem:
    """The hybrid flow of a model at values of its parameters."""

    flow: HybridFlow
    constants: Constants
    weights: Array  # one over the scales of slips, frictions and outputs of limits

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
        ready = self.flow.ready(mode, self.constants, self.weights)
        ready.set_out(state, begin)
        if ready.compiled.slow is not None or dense:
            return self._run_closely(ready, mode, state, begin, end, dense=dense)
        event, time = ready.propagate(end)
        final, energies = ready.arrived()
        if not ready.compiled.rests:
            final = ready.compiled.hold(final, time, self.constants)
        return SmoothPhase(mode, begin, time, final, energies, event)

    def _run_closely(
        self, ready: ReadyMode, mode: Mode, state: Array, begin: float, end: float, *, dense: bool
    ) -> SmoothPhase:
        """Integrate slow slip, or with dense output."""
        compiled, integrator = ready.compiled, ready.integrator
        until, slow = end, compiled.slow
        if slow is not None:
            slip = self.at(state, begin).slip[self.places[slow]]
            logarithm, angle = _polar(slip, 2 * REST / ready.weights[slow])
            ready.slow[:] = logarithm / UNIT, angle, begin
            integrator.time, until = 0.0, FOREVER
            integrator.pars[-1] = end
        polynomials: StepPolynomials | SlowPolynomials | None = None
        if dense:
            outcome, polynomials = step_to(integrator, until, STEPS)
            event, time = ready.ending(outcome), integrator.time
        else:
            event, time = ready.propagate(until)
        final, energies = ready.arrived()
        polar: tuple[float, ...] = ()
        if slow is not None:
            logarithm, angle, time = ready.slow.tolist()
            polar = (logarithm * UNIT, angle)
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

    def without_limit(self, contact: int) -> HybridSystem:
        """Return the system in which a contact sticks without a limit of friction."""
        weights = self.weights.copy()
        weights[len(self.flow.contacts) + contact] *= 2.0**-100
        return HybridSystem(self.flow, self.constants, weights)


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
