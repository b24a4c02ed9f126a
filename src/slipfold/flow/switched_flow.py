"""The flow of a model in each of its modes, ended where a contact changes what it does.

Slip in the plane that grows slowly from zero is solved by a polynomial through Radau's points:
friction turns slip the more firmly the slower it is, so that explicit steps from rest would never
end. Terms of the series in which slip grows fall until their number is friction, as a rate, times
time over slip; the polynomial goes as far as that.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from threading import Lock

import numpy as np

from slipfold.arrays import Array
from slipfold.collocation_points import radau_points
from slipfold.flow.compiled_code import OwnCopies
from slipfold.flow.compiled_mode import STEPS, CompiledMode, ReadyMode
from slipfold.flow.contact_state import (
    SLACK,
    Arguments,
    ContactQuantities,
    ContactsNow,
    Slopes,
    many,
)
from slipfold.flow.equations import Constants, power_of_two
from slipfold.flow.flow import Flow, flow_of
from slipfold.flow.intervals import Field, Solved
from slipfold.flow.modes import (
    REST,
    STUCK,
    Event,
    Mode,
    Status,
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
from slipfold.flow.stage_equations import Inverted
from slipfold.models.model import Kind, Model
from slipfold.models.output import Limit

POINTS = radau_points(8)
"""Points of the polynomial; with six the end is as good to 1e-14."""

EXACT = 1e-15
"""Steps of Newton's method, in scaled states, continue until they are this short: slip at the first
point is a ten thousandth of that at the end."""

ITERATIONS, RENEWED = 12, 0.1
"""How many of them there may be, and from what fraction of the one before on that takes new
derivatives."""

FAR = 1.0
"""A first step must be shorter than a fraction of this, in scaled states, to lead anywhere."""

LAST = 1e-13
"""Last term of the polynomial, in scaled states, that is small enough: what is left out is smaller
by as much as that is smaller than the one before."""


@dataclass(frozen=True, eq=False)
class Beginning:
    """A time in which slip begins."""

    field: Field
    begin: float  # phase
    length: float  # in phases
    solved: Solved  # one interval, in scaled states

    @property
    def stages(self) -> Array:
        """States at the points, shape (s, n)."""
        return np.asarray(self.solved.stages[0] * self.field.scales)

    @property
    def phases(self) -> Array:
        """Phases of the points, shape (s,)."""
        return self.solved.phases[0]

    @property
    def end(self) -> float:
        """Phase at which it is over."""
        return self.begin + self.length

    def integrals(self, phase: float) -> Array:
        """Return weights that integrate over phases what is known at the points, shape (s,)."""
        if phase >= self.end:
            return self.length * POINTS.weights
        share = (phase - self.begin) / self.length
        return np.asarray(self.length * POINTS.integrals(np.array([share]))[0])

    def at(self, phase: float) -> Array:
        """Return the state at a phase, shape (n,)."""
        if phase >= self.end:
            return np.asarray(self.stages[-1])
        scaled = self.solved.nodes[0] + self.integrals(phase) @ self.solved.slopes[0]
        return np.asarray(scaled * self.field.scales)

    @property
    def missing(self) -> Array:
        """By how much more states change a phase than the equations say, which round, (s, n)."""
        scaled = self.solved.stages[0]
        rates = self.field.rates(scaled, self.phases)
        return np.asarray((self.solved.slopes[0] - rates) * self.field.scales)

    def polynomials(self, end: float) -> StepPolynomials:
        """Return scaled states as far as some phase."""
        powers = POINTS.powers @ self.solved.slopes[0] * self.length
        powers[0] += self.solved.nodes[0]
        powers /= self.length ** np.arange(len(powers))[:, None]
        return StepPolynomials([self.begin, end], [powers.T])

    def linearized(self, phase: float, directions: Array) -> tuple[Array, Array]:
        """Return derivatives of the state at a phase, by that at the beginning and coefficients.

        Slip that begins earlier or later is included: to first order it makes no difference whether
        slip waits until it may grow, or is carried through zero. Shapes: directions (n_c, k);
        returns (n, n), (n, k).
        """
        field, n = self.field, len(self.field.scales)
        rows, phases = self.stages, self.phases
        pushes = np.zeros((*rows.shape, directions.shape[1]))
        if pushes.size:
            pulls = field.flow.pulls(rows, phases, field.constants, directions)
            pushes = pulls / field.scales[:, None]
        equations = _equations(field, self.solved.lengths, self.solved.stages[0], phases)
        assert equations is not None  # it is solved
        driven = self.length * np.einsum("lk,kaq->laq", POINTS.inner, pushes)
        changes = np.concatenate([equations.moved, equations.solve(driven[None])], axis=3)[0]
        own = np.eye(n, n + directions.shape[1])
        share = self.integrals(phase) / self.length @ POINTS.outer
        found = own + np.einsum("k,kab->ab", share, changes - own)
        found *= field.scales[:, None]
        return found[:, :n] / field.scales, found[:, n:]


def beginning(
    field: Field, state: Array, begin: float, length: float, guess: Array
) -> Beginning | None:
    """Solve for slip that begins; None where a polynomial does not do.

    Shapes: state (n,); guess (s, n).
    """
    node, lengths = state / field.scales, np.array([length])
    stages, phases = guess / field.scales, begin + length * POINTS.points
    equations, before = None, FAR
    for _ in range(ITERATIONS):
        rates = field.rates(stages, phases)
        if equations is None:
            equations = _equations(field, lengths, stages, phases)
        if equations is None:
            return None
        missing = node + length * (POINTS.inner @ rates) - stages
        step = equations.solve(missing[None, ..., None])[0, ..., 0]
        stages = stages + step
        size = float(np.abs(step).max())
        if not size <= RENEWED * before:
            equations = None
        # What is left after a step is as much smaller as that was than the one before.
        elif size <= EXACT or (before < FAR and size * size <= EXACT * before):
            break
        before = size
    else:
        return None
    assert equations is not None
    one = np.array([begin])
    solved = Solved(POINTS, node[None], one, lengths, stages[None], rates[None], equations, None)
    last = POINTS.transform[-1] @ solved.slopes[0] * length / (2 * (2 * len(phases) - 1))
    return Beginning(field, begin, length, solved) if np.abs(last).max() <= LAST else None


def _equations(field: Field, lengths: Array, stages: Array, phases: Array) -> Inverted | None:
    """Return the derivatives of the stages' equations, None where they are singular."""
    jacobians = field.jacobians(stages, phases)[None]
    if not np.isfinite(jacobians).all():
        return None
    try:
        return Inverted.of(POINTS, lengths, jacobians)
    except np.linalg.LinAlgError:
        return None


FOREVER = 1e30
"""Upper end of the rescaled time, which no trajectory reaches."""


@dataclass(eq=False, slots=True)  # frozen ones take three times as long to make
class Leg:
    """A piece of motion in one mode; nothing changes once it is handed on."""

    mode: Mode
    begin: float  # phases
    end: float
    state: Array  # at its end, shape (n,)
    energies: Array  # put into the structure by each contact, then heat, in J, shape (2 k,)
    event: Event | None  # what ended it; None if it came to where it was asked to
    released: bool = False  # whether it is the beginning of slip in the plane, taken by itself
    beginning: Beginning | None = None  # how slip begins in it if that is slowly
    # Maps phases to scaled states, if asked for
    polynomials: StepPolynomials | SlowPolynomials | BegunPolynomials | None = None

    @property
    def seen(self) -> Mode:
        """What contacts do in it."""
        return shown(self.mode)


class SwitchedFlow:
    """The flows of a model's modes; the values of its parameters play no part."""

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
        self._arguments = Arguments()
        self._own = _Own()
        self._modes: dict[Mode, CompiledMode] = {}

    @cached_property
    def slips(self) -> Slopes:
        """What differentiates slips by states, phase and coefficients."""
        return Slopes(self._slips, self._equations)

    def of(self, mode: Mode) -> Flow:
        """Return the flow of a mode by itself, with its derivatives, as of any model."""
        return self._mode(shown(mode)).flow

    def held(self, mode: Mode, state: Array, phase: float, constants: Constants) -> Array:
        """Return a state as the contacts of a mode hold it: what sticks has no slip at all.

        Shapes: state (n,).
        """
        return self._placed(self._mode(shown(mode)), state, (), phase, constants)

    def slipping(
        self, mode: Mode, state: Array, slip: Array, phase: float, constants: Constants
    ) -> Array:
        """Return a state with some slow slip in m/s in a mode. Shapes: state (n,); slip (2,)."""
        return self._placed(self._mode(mode), state, _polar(slip, 0.0), phase, constants)

    def all_slipping(
        self, mode: Mode, states: Array, slips: Array, phases: Array, constants: Constants
    ) -> Array:
        """Do so with many. Shapes: states (p, n); slips (p, 2); phases (p,); returns (p, n)."""
        x, y = slips.T
        polar = np.stack([np.log(np.hypot(x, y)), np.arctan2(y, x)], axis=1)
        return self._all_placed(self._mode(mode), states, polar, phases, constants)

    def powers(self, mode: Mode, states: Array, phases: Array, constants: Constants) -> Array:
        """Return what contacts put into the structure a phase, and heat, in J.

        Shapes: states (p, n); phases (p,); returns (p, 2 k).
        """
        known = many(states, phases, constants)
        return np.asarray(self._mode(shown(mode)).powers(known).T)

    @cached_property
    def rests_by(self) -> list[int]:
        """Which states follow from the others where a contact, the only one, sticks."""
        return self.places_held(STUCK)

    def rested(self, state: Array, phase: float, constants: Constants) -> tuple[float, bool]:
        """Return the speed of a state when a contact along a line, the only one, comes to rest.

        With it whether friction holds it, clearly within its limit: most do. Shapes: state (n,).
        """
        known = self._arguments.of(state, phase, constants)
        speed, needed, most = self._mode(STUCK).holding(known).tolist()
        return speed, abs(needed) < most * (1 - SLACK)

    def _placed(
        self,
        compiled: CompiledMode,
        state: Array,
        polar: tuple[float, ...],
        phase: float,
        constants: Constants,
    ) -> Array:
        if not compiled.held:
            return state
        if polar:
            known = np.concatenate([state, polar, (phase,), constants.values])
        else:
            known = self._arguments.of(state, phase, constants)
        result = state.copy()
        for place, value in zip(compiled.held, compiled.holding(known).tolist(), strict=False):
            result[place] = value
        return result

    def _all_placed(
        self,
        compiled: CompiledMode,
        states: Array,
        polar: Array,
        phases: Array,
        constants: Constants,
    ) -> Array:
        """Do so with many states of slow slip. Shapes: states (p, n); polar (p, 2); phases (p,)."""
        result = states.copy()
        known = many(np.concatenate([states, polar], axis=1), phases, constants)
        result[:, compiled.held] = compiled.holding(known).T
        return result

    def no_energies(self) -> Array:
        """Return those of a smooth phase without duration, shape (2 k,)."""
        return np.zeros(2 * len(self.contacts))

    def steady(self, mode: Mode) -> bool:
        """Whether all rates are constant in a mode, of contacts along lines."""
        return not self.planar and self._mode(mode).steady

    def places_held(self, mode: Mode) -> list[int]:
        """Return which states follow from the others in a mode."""
        return self._mode(mode).held

    def held_slopes(self, mode: Mode) -> Slopes:
        """Return what differentiates these states in a mode without slow slip."""
        return self._mode(mode).held_slopes

    def events_of(self, mode: Mode) -> tuple[Event, ...]:
        """Return the changes that a mode may meet."""
        return self._mode(mode).events

    def event_slopes(self, mode: Mode, event: Event) -> tuple[Slopes, int]:
        """Return what differentiates an event, in a mode without slow slip, and its row there."""
        compiled = self._mode(mode)
        same = [
            (item.ending, item.which, item.towards) == (event.ending, event.which, event.towards)
            for item in compiled.events
        ]
        return compiled.event_slopes, same.index(True)

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
        """Propagate a state on in a mode, until it changes. Shapes: state (n,)."""
        ready = self.ready(mode, constants, weights)
        ready.set_out(state, begin)
        if ready.compiled.slow is not None or dense:
            return self._run_closely(ready, mode, state, begin, end, dense=dense)
        event, time = ready.propagate(end)
        final, energies = ready.arrived()
        if not ready.compiled.rests:
            final = self._placed(ready.compiled, final, (), time, constants)
        return Leg(mode, begin, time, final, energies, event)

    def _run_closely(
        self, ready: ReadyMode, mode: Mode, state: Array, begin: float, end: float, *, dense: bool
    ) -> Leg:
        """Do so where slip is slow, or all that lies between is wanted."""
        compiled, integrator, constants = ready.compiled, ready.integrator, ready.constants
        until, slow = end, compiled.slow
        if slow is not None:
            slip = self.quantities.at(state, begin, constants).slip[self.quantities.places[slow]]
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
                polynomials = self._slowly(compiled, polynomials, constants)
        final = self._placed(compiled, final, polar, time, constants)
        return Leg(mode, begin, time, final, energies, event, polynomials=polynomials)

    def _slowly(
        self, compiled: CompiledMode, polynomials: StepPolynomials, constants: Constants
    ) -> SlowPolynomials:
        """Return what lies between the ends of steps of slow slip."""
        scales = constants.scales

        def placed(scaled: Array, polar: Array, phases: Array) -> Array:
            return self._all_placed(compiled, scaled * scales, polar, phases, constants) / scales

        return SlowPolynomials(polynomials, len(scales), placed, compiled.held)

    def ready(self, mode: Mode, constants: Constants, weights: Array) -> ReadyMode:
        """Return a mode with its integrator, this thread's own."""
        own = self._own.modes
        ready = own.get(mode)
        if ready is None or ready.constants is not constants:
            compiled = self._mode(mode)
            integrator = self._integrators.get(compiled.name, compiled.integrator)
            ready = own[mode] = ReadyMode(compiled, integrator, constants, weights)
        elif ready.weights is not weights:
            ready.weigh(weights)
        return ready

    def weights(self, state: Array, constants: Constants) -> Array:
        """Return one over the sizes of slips, of frictions, and of what limits watch.

        They count in the length of a step. Shapes: state (n,).
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
        if not self.limits:  # outputs take their time to compile
            return np.empty((len(states), 0))
        flow = self.of((Status.FORTH,) * len(self.contacts))
        values = flow.outputs(states, np.zeros(len(states)), constants)
        watched = [flow.output_index(item.output) for item in self.limits]
        return np.abs(values[:, watched] - np.array([item.bound for item in self.limits]))

    def _mode(self, mode: Mode) -> CompiledMode:
        if mode not in self._modes:
            with _BUILDING:
                if mode not in self._modes:
                    equations = mode_equations(self._model, mode)
                    self._modes[mode] = CompiledMode(equations, self.limits)
        return self._modes[mode]


def _polar(slip: Sequence[float] | Array, least: float) -> tuple[float, float]:
    """Return logarithm and angle of slip that is no slower than some speed."""
    return math.log(max(math.hypot(*slip), least)), math.atan2(slip[1], slip[0])


def _over(sizes: Array) -> Array:
    largest = np.max(sizes, axis=0, initial=0.0, where=np.isfinite(sizes))
    return 1 / power_of_two(np.where(largest > 0, largest, 1.0))


@dataclass(frozen=True, eq=False, slots=True)
class HybridSystem:
    """The switched flow of a model at values of its parameters."""

    flow: SwitchedFlow
    constants: Constants
    weights: Array  # one over the scales of slips, frictions, and of what limits watch

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

    def run(
        self, mode: Mode, state: Array, begin: float, end: float, *, dense: bool = False
    ) -> Leg:
        """Integrate a state in a mode until the mode changes. Shapes: state (n,)."""
        return self.flow.run(mode, state, begin, end, self.constants, self.weights, dense=dense)

    def without_limit(self, contact: int) -> HybridSystem:
        """Return the system in which a contact is held by more than friction."""
        weights = self.weights.copy()
        weights[len(self.flow.contacts) + contact] *= NOTHING
        return HybridSystem(self.flow, self.constants, weights)


NOTHING = 2.0**-100


class _Own(threading.local):
    """The modes that are ready in a thread."""

    def __init__(self) -> None:
        self.modes: dict[Mode, ReadyMode] = {}


def hybrid_system(model: Model, state: Array) -> HybridSystem:
    """Return the hybrid system of a model, with scales about a state. Shapes: state (n,)."""
    return switched_flow_of(model).system(state, flow_of(model).constants_of(model))


def switched_flow_of(model: Model) -> SwitchedFlow:
    """Return the switched flow of a model; models with the same equations share one."""
    with _SHARING:
        return _shared(model.kind)


_SHARING = Lock()
_BUILDING = Lock()


@lru_cache(maxsize=64)
def _shared(kind: Kind) -> SwitchedFlow:
    return SwitchedFlow(kind.make())
