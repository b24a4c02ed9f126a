"""A hybrid trajectory at any instant: states, outputs, and slip and forces of contacts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import heyoka as hy
import numpy as np

from slipfold.arrays import Array
from slipfold.flow.compiled_code import StateFunction
from slipfold.flow.contact_state import changed
from slipfold.flow.equations import model_symbols
from slipfold.flow.flow import flow_of
from slipfold.flow.hybrid_flow import HybridSystem, SmoothPhase, hybrid_flow_of, hybrid_system
from slipfold.flow.hybrid_trajectory import Broken, first_mode, smooth_phases
from slipfold.flow.modes import CONTACT, Ending, Mode, Status, mode_equations
from slipfold.models.friction.contact import Contact
from slipfold.models.model import Kind, Model
from slipfold.models.quantities import Expression


class Samples:
    """States at some phases, with their modes if contacts stick."""

    def __init__(
        self, model: Model, states: Array, phases: Array, modes: list[Mode] | None = None
    ) -> None:
        self.states, self.phases, self.modes = states, phases, modes  # states of shape (m, n)
        self.model = model

    def outputs(self) -> Array:
        """Return all outputs there, the states first, shape (m, n_outputs)."""
        smooth = flow_of(self.model)
        constants = smooth.constants_of(self.model)
        if self.modes is None:
            return smooth.outputs(self.states, self.phases, constants)
        flow, result = hybrid_flow_of(self.model), np.empty(0)
        for mode in dict.fromkeys(self.modes):
            rows = np.array([item == mode for item in self.modes])
            values = flow.of(mode).outputs(self.states[rows], self.phases[rows], constants)
            result = result if result.size else np.empty((len(self.states), values.shape[1]))
            result[rows] = values
        return result


def joined_samples(each: Sequence[Samples]) -> Samples:
    """Return one sequence of samples from several."""
    states, phases = (
        np.concatenate([getattr(samples, name) for samples in each])
        for name in ("states", "phases")
    )
    modes = [mode for samples in each for mode in samples.modes or ()]
    return Samples(each[0].model, states, phases, modes)


def dense_phases(model: Model, state: Array, mode: Mode, end: float) -> Iterator[SmoothPhase]:
    """Propagate a state from phase zero to another with dense output.

    A trajectory that cannot continue ends early. After slip in the plane grazes zero it continues
    from rest.
    """
    system = hybrid_system(model, state)
    phase, ahead = 0.0, True
    while ahead:
        ahead = False
        try:
            for part, _ in smooth_phases(system, mode, state, end, begin=phase, dense=True):
                yield part
        except Broken as broken:
            if (last := broken.part) is None:
                return
            yield last
            resting = _at_rest_after_grazing(system, last)
            if resting is not None and phase < last.end < end:
                mode, phase, ahead = resting, last.end, True
                state = system.held(mode, last.state, phase)


def _at_rest_after_grazing(system: HybridSystem, part: SmoothPhase) -> Mode | None:
    """Return the mode at rest after slip that turned too fast; None if slip is not zero."""
    if not part.ended_by(Ending.STIFF) or Status.SLOW not in part.mode:
        return None
    contact, now = part.mode.index(Status.SLOW), system.at(part.state, part.end)
    speed = math.hypot(*now.slip[system.places[contact]]) * system.weights[contact]
    return changed(part.mode, {contact: Status.STICK}) if speed < CONTACT.grazing else None


def sample_hybrid(model: Model, state: Array, mode: Mode, phases: Array) -> Samples:
    """Sample a trajectory at increasing phases. Shapes: state (n,); phases (m,)."""
    states = np.full((len(phases), len(state)), np.nan)
    modes = [mode] * len(phases)
    scales = flow_of(model).constants_of(model).scales
    done, last, doing = 0, state, mode
    for part in dense_phases(model, state, mode, float(phases[-1])):
        arrived = part.event is None and part.end >= phases[-1]
        upto = len(phases) if arrived else int(np.searchsorted(phases, part.end))
        if upto > done:
            if part.polynomials is None:
                states[done:upto] = part.state
            else:
                states[done:upto] = part.polynomials(phases[done:upto])[:, : len(state)] * scales
            modes[done:upto] = [part.reported_mode] * (upto - done)
        done, last, doing = max(done, upto), part.state, part.reported_mode
    # The last smooth phase may end in an event at the last phase.
    states[done:], modes[done:] = last, [doing] * (len(phases) - done)
    return Samples(model, states, phases, modes)


@dataclass(frozen=True, eq=False)
class ContactPhase:
    """A time in which a contact keeps its status, ends included; d directions."""

    status: Status
    phase: Array  # since the start, shape (m,)
    slip: Array  # velocity of the moving surface relative to the body in m/s, shape (m, d)
    friction: Array  # force on the body in N, shape (m, d)
    normal: Array  # normal force in N, shape (m,)
    plate: Array  # velocity of the moving surface in m/s, shape (m, d)
    # Displacement of the body in m, shape (m, d); NaN if the equations do not give it
    displacement: Array


@dataclass(frozen=True, eq=False)
class ContactTrajectory:
    """The trajectory of one contact, one piece per status."""

    name: str
    pieces: tuple[ContactPhase, ...]

    @property
    def directions(self) -> int:
        """One along a line, two in the plane."""
        return int(self.pieces[0].slip.shape[1])

    @property
    def end(self) -> float:
        """Where the last piece ends."""
        return float(self.pieces[-1].phase[-1])


def contact_trajectories(
    model: Model,
    starts: Iterable[tuple[Array, Mode | None]],
    length: float = 1.0,
    per_period: int = 256,
) -> tuple[ContactTrajectory, ...]:
    """Return the trajectories of all contacts over rounds of equal length.

    Each round begins at phase zero, at a state and in a mode; None is the mode of the state.
    """
    flow = hybrid_flow_of(model)
    result: list[list[ContactPhase]] = [[] for _ in flow.contacts]
    for number, (state, mode) in enumerate(starts):
        if mode is None:
            mode = first_mode(hybrid_system(model, state), state)
        for part in dense_phases(model, state, mode, length):
            if part.polynomials is None or part.end == part.begin:
                continue
            sampled = _sampled(model, part, len(state), per_period)
            for pieces, piece in zip(result, sampled, strict=True):
                pieces.append(replace(piece, phase=piece.phase + number * length))
    return tuple(
        ContactTrajectory(contact.name, tuple(_joined(pieces)))
        for contact, pieces in zip(flow.contacts, result, strict=True)
    )


def _sampled(model: Model, part: SmoothPhase, n: int, per_period: int) -> list[ContactPhase]:
    """Sample a smooth phase from its begin to its end, a piece for each contact."""
    constants, flow = flow_of(model).constants_of(model), hybrid_flow_of(model)
    # Short pieces may bend as much.
    count = max(math.ceil(per_period * (part.end - part.begin)), 16)
    phases = np.linspace(part.begin, part.end, count + 1)
    assert part.polynomials is not None
    states = part.polynomials(phases)[:, :n] * constants.scales
    mode = part.reported_mode
    values = _evaluated(model.kind, mode).along(states, phases, constants)
    pieces, done = [], 0
    for components, status in zip(flow.quantities.places, mode, strict=True):
        d = components.stop - components.start
        own = np.split(values[:, done : done + 4 * d + 1], [d, 2 * d, 2 * d + 1, 3 * d + 1], axis=1)
        slip, friction, normal, plate, displacement = own
        if status is Status.STICK:
            slip = np.zeros_like(slip)
        pieces.append(
            ContactPhase(status, phases, slip, friction, normal[:, 0], plate, displacement)
        )
        done += 4 * d + 1
    return pieces


@lru_cache(maxsize=256)
def _evaluated(kind: Kind, mode: Mode) -> StateFunction:
    """Return a compiled function of states, phase and coefficients."""
    model = kind.make()
    result = mode_equations(model, mode)
    expressions: list[Expression] = []
    for contact, friction, normal in zip(
        result.contacts, result.friction, result.normal, strict=True
    ):
        own = [*contact.slip, *friction, normal, *contact.plate, *_displacement(model, contact)]
        expressions += [hy.expression(0.0) + item for item in own]
    return StateFunction("contact motion", expressions, result.equations)


def _displacement(model: Model, contact: Contact) -> list[Expression]:
    """Return the displacement of a contact: its velocity with each rate replaced by its state."""
    symbols = model_symbols(model)
    rates = model.rates(symbols.states, symbols.coefficients, symbols.phase)
    moved = {
        name: symbols.states[state]
        for state, rate in rates.items()
        for name, symbol in symbols.states.items()
        if rate == symbol
    }
    result = []
    for slip in contact.slip:
        slopes = {name: hy.diff(slip, symbol) for name, symbol in symbols.states.items()}
        determined = all(name in moved for name, slope in slopes.items() if slope != ZERO)
        parts = [-slopes[name] * position for name, position in moved.items()]
        result.append(hy.sum(parts) if determined else hy.expression(math.nan))
    return result


ZERO = hy.expression(0.0)


def _joined(pieces: Sequence[ContactPhase]) -> list[ContactPhase]:
    """Join consecutive pieces with the same status."""
    result: list[ContactPhase] = []
    for piece in pieces:
        if result and result[-1].status is piece.status:
            last = vars(result.pop())
            own = vars(piece)
            joined = {key: np.concatenate([last[key], own[key]]) for key in own if key != "status"}
            piece = ContactPhase(piece.status, **joined)
        result.append(piece)
    return result
