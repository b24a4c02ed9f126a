"""What contacts do at the end of a trajectory, or along an orbit: stick, slip and flight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.flow.contact_motion import ContactMotion, ContactPiece, contact_motions
from slipfold.flow.flow import flow_of
from slipfold.flow.modes import Mode, contacts_of
from slipfold.flow.trajectory import Trajectory
from slipfold.models.model import Model
from slipfold.models.suggestion import unknown
from slipfold.models.system import System
from slipfold.orbits.periodic_orbit import PeriodicOrbit

UNSETTLED = 32
"""Periods at the end of a trajectory that has not settled, or has come to rest."""


@dataclass(frozen=True, eq=False)
class ShownContacts:
    """Contacts over some rounds; times in forcing periods, of an autonomous model in s."""

    model: Model
    contacts: tuple[ContactMotion, ...]
    begin: float  # when the first round begins, since the start of the trajectory
    unit: float  # of a phase, in these times
    repeats: bool  # whether the rounds are all alike

    @property
    def units(self) -> tuple[str, str, str]:
        """Units of displacement, slip and force: equations as text have those that states have."""
        if not isinstance(self.model, System) or all(item.unit for item in self.model.states):
            return "m", "m/s", "N"
        return "", "", ""

    def time(self, piece: ContactPiece) -> NDArray[np.float64]:
        """Return the times of a piece."""
        return self.begin + self.unit * piece.phase

    def seconds(self, piece: ContactPiece) -> NDArray[np.float64]:
        """Return the times of a piece in s, from the first round on."""
        return piece.phase * flow_of(self.model).constants_of(self.model).period


def find_contacts(
    motion: Trajectory | PeriodicOrbit,
    contact: str | None = None,
    rounds: int = 1,
    per_period: int = 256,
) -> ShownContacts:
    """Return what a contact, or all of them, do in the last rounds of a trajectory."""
    if rounds < 1:
        raise InputError(f"rounds = {rounds} is less than 1; give 1 or more")
    _check(motion.model, contact)
    part = _of_orbit(motion, rounds) if isinstance(motion, PeriodicOrbit) else _end(motion, rounds)
    unit = 1.0 if part.model.forced else flow_of(part.model).constants_of(part.model).period
    found = contact_motions(part.model, part.starts, part.length, per_period)
    return ShownContacts(
        part.model,
        tuple(item for item in found if contact in (None, item.name)),
        part.begin * unit,
        unit,
        part.repeats,
    )


@dataclass(frozen=True, eq=False)
class _Part:
    """The part of a trajectory that is shown, in phases."""

    model: Model
    starts: list[tuple[NDArray[np.float64], Mode | None]]  # each of the same length
    length: float
    begin: float
    repeats: bool


def _of_orbit(orbit: PeriodicOrbit, rounds: int) -> _Part:
    return _Part(orbit.model, [(orbit.state, None)] * rounds, float(orbit.period), 0.0, True)


def _end(motion: Trajectory, rounds: int) -> _Part:
    settlement, sticking = motion.settlement, motion.sticking
    repeats = settlement.settled and settlement.kind != "equilibrium"
    if settlement.duration is not None:
        begin, places = motion.duration / settlement.duration, [motion.periods] * rounds
    else:
        wanted = rounds * (settlement.period or 1) if repeats else UNSETTLED
        first = max(motion.periods - wanted, 0)
        begin, places = float(first), [*range(first, motion.periods)]
    if not places:
        raise InputError("the motion ended within its first period; start elsewhere")
    modes = [None if sticking is None else sticking.mode(place) for place in places]
    starts = [(motion.strobe[place], mode) for place, mode in zip(places, modes, strict=True)]
    return _Part(motion.steady_model, starts, 1.0, begin, repeats)


def _check(model: Model, contact: str | None) -> None:
    names = [item.name for item in contacts_of(model)]
    if not names:
        raise InputError(
            f"{model.name} has no contact with an exact law of friction, which sticks; show its "
            "outputs instead"
        )
    if contact is not None and contact not in names:
        raise unknown(f"{model.name} has no contact", contact, names)
