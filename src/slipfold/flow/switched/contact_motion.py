"""What goes on in each contact of a motion: how far it moved, its slip, and the forces in it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import heyoka as hy
import numpy as np

from slipfold.arrays import Array
from slipfold.flow.cache import cached
from slipfold.flow.equations import written
from slipfold.flow.flow import flow_of
from slipfold.flow.switched.mode import Mode, Status
from slipfold.flow.switched.mode_equations import mode_equations
from slipfold.flow.switched.sampled import dense_legs
from slipfold.flow.switched.switched_flow import Leg, switched_flow_of
from slipfold.flow.switched.switched_motion import first_mode
from slipfold.models.evaluation import compiled_function
from slipfold.models.model import Kind, Model
from slipfold.models.output import Contact, Expression

FEWEST = 16
"""Intervals between samples of a piece at least: short ones turn as sharply as long ones."""


@dataclass(frozen=True, eq=False)
class ContactPiece:
    """A time in which a contact does one thing, with its ends; d directions."""

    status: Status
    phase: Array  # since the start, shape (m,)
    slip: Array  # velocity of the counter-body relative to the body in m/s, shape (m, d)
    friction: Array  # force on the body in N, shape (m, d)
    normal: Array  # normal force in N, shape (m,)
    plate: Array  # velocity of the counter-body in m/s, shape (m, d)
    # How far the body is from its place in m, shape (m, d); NaN where the equations do not tell
    displacement: Array


@dataclass(frozen=True, eq=False)
class ContactMotion:
    """All that one contact does, piece after piece."""

    name: str
    pieces: tuple[ContactPiece, ...]

    @property
    def directions(self) -> int:
        """One along a line, two in the plane."""
        return int(self.pieces[0].slip.shape[1])

    @property
    def end(self) -> float:
        """Where the last piece ends."""
        return float(self.pieces[-1].phase[-1])


def contact_motions(
    model: Model,
    starts: Iterable[tuple[Array, Mode | None]],
    length: float = 1.0,
    per_period: int = 256,
) -> tuple[ContactMotion, ...]:
    """Return what all contacts do in motions of some length that follow each other.

    Each begins at phase zero, at a state and in a mode; None is the one that the state tells.
    """
    flow = switched_flow_of(model)
    constants = flow_of(model).constants_of(model)
    found: list[list[ContactPiece]] = [[] for _ in flow.contacts]
    for number, (state, mode) in enumerate(starts):
        if mode is None:
            mode = first_mode(flow, state, constants, flow.weights(state, constants))
        for leg in dense_legs(model, state, mode, length):
            if leg.polynomials is None or leg.end == leg.begin:
                continue
            sampled = _sampled(model, leg, len(state), per_period)
            for pieces, piece in zip(found, sampled, strict=True):
                pieces.append(_later(piece, number * length))
    return tuple(
        ContactMotion(contact.name, tuple(_joined(pieces)))
        for contact, pieces in zip(flow.contacts, found, strict=True)
    )


def _sampled(model: Model, leg: Leg, n: int, per_period: int) -> list[ContactPiece]:
    """Sample a leg from its begin to its end, a piece for each contact."""
    constants, flow = flow_of(model).constants_of(model), switched_flow_of(model)
    count = max(math.ceil(per_period * (leg.end - leg.begin)), FEWEST)
    phases = np.linspace(leg.begin, leg.end, count + 1)
    assert leg.polynomials is not None
    states = leg.polynomials(phases)[:, :n] * constants.scales
    mode = leg.seen
    repeated = np.broadcast_to(constants.values, (len(phases), len(constants.values)))
    inputs = np.concatenate([states, phases[:, None], repeated], axis=1)
    values = _evaluated(model.kind, mode)(np.ascontiguousarray(inputs.T)).T
    pieces, done = [], 0
    for place, status in zip(flow.quantities.places, mode, strict=True):
        d = place.stop - place.start
        own = np.split(values[:, done : done + 4 * d + 1], [d, 2 * d, 2 * d + 1, 3 * d + 1], axis=1)
        slip, friction, normal, plate, displacement = own
        if status is Status.STICK:
            slip = np.zeros_like(slip)
        pieces.append(
            ContactPiece(status, phases, slip, friction, normal[:, 0], plate, displacement)
        )
        done += 4 * d + 1
    return pieces


@lru_cache(maxsize=256)
def _evaluated(kind: Kind, mode: Mode) -> Any:
    """Return a compiled function of states, phase and coefficients."""
    model = kind.make()
    found = mode_equations(model, mode)
    expressions: list[Expression] = []
    for contact, friction, normal in zip(found.contacts, found.friction, found.normal, strict=True):
        own = [*contact.slip, *friction, normal, *contact.plate, *_displacement(model, contact)]
        expressions += [hy.expression(0.0) + item for item in own]
    equations = found.equations
    inputs = [*equations.states, equations.phase, *equations.coefficients]
    return cached(
        f"contact motion {equations.fingerprint()} {mode}",
        lambda: compiled_function(expressions, inputs),
    )


def _displacement(model: Model, contact: Contact) -> list[Expression]:
    """Return how far a contact is from its place: its velocity, with each rate by its state."""
    symbols = written(model)
    rates = model.rates(symbols.states, symbols.coefficients, symbols.phase)
    moved = {
        name: symbols.states[place]
        for place, rate in rates.items()
        for name, symbol in symbols.states.items()
        if rate == symbol
    }
    found = []
    for slip in contact.slip:
        slopes = {name: hy.diff(slip, symbol) for name, symbol in symbols.states.items()}
        told = all(name in moved for name, slope in slopes.items() if slope != ZERO)
        parts = [-slopes[name] * place for name, place in moved.items()]
        found.append(hy.sum(parts) if told else hy.expression(math.nan))
    return found


ZERO = hy.expression(0.0)


def _later(piece: ContactPiece, phases: float) -> ContactPiece:
    return ContactPiece(**{**vars(piece), "phase": piece.phase + phases})


def _joined(pieces: Sequence[ContactPiece]) -> list[ContactPiece]:
    """Join pieces that follow each other in which a contact does the same."""
    found: list[ContactPiece] = []
    for piece in pieces:
        if found and found[-1].status is piece.status:
            last = vars(found.pop())
            own = vars(piece)
            joined = {key: np.concatenate([last[key], own[key]]) for key in own if key != "status"}
            piece = ContactPiece(piece.status, **joined)
        found.append(piece)
    return found
