"""What contacts do at the end of a trajectory, or along an orbit: stick, slip and flight."""

from __future__ import annotations

from dataclasses import dataclass

from slipfold.arrays import Array
from slipfold.errors import InputError, unknown
from slipfold.flow.contact_trajectory import ContactPhase, ContactTrajectory, contact_trajectories
from slipfold.flow.flow import flow_of
from slipfold.flow.modes import Mode, contacts_of
from slipfold.flow.trajectory import Trajectory
from slipfold.models.model import Model
from slipfold.models.system import System
from slipfold.orbits.periodic_orbit import PeriodicOrbit

Start = tuple[Array, Mode | None]
"""A state, and the mode of its contacts where that is known."""


@dataclass(frozen=True, eq=False)
class ContactRounds:
    """Contacts over some rounds; times in forcing periods, of an autonomous model in s."""

    model: Model
    contacts: tuple[ContactTrajectory, ...]
    begin: float  # when the first round begins, since the start of the trajectory
    unit: float  # of a phase, in these times
    repeats: bool  # whether the rounds are all alike

    @property
    def units(self) -> tuple[str, str, str]:
        """Units of displacement, slip and force: equations as text have those that states have."""
        if not isinstance(self.model, System) or all(item.unit for item in self.model.states):
            return "m", "m/s", "N"
        return "", "", ""

    def time(self, piece: ContactPhase) -> Array:
        """Return the times of a piece."""
        return self.begin + self.unit * piece.phase

    def seconds(self, piece: ContactPhase) -> Array:
        """Return the times of a piece in s, from the first round on."""
        return piece.phase * flow_of(self.model).constants_of(self.model).period


def find_contacts(
    trajectory: Trajectory | PeriodicOrbit,
    contact: str | None = None,
    rounds: int = 1,
    per_period: int = 256,
) -> ContactRounds:
    """Return what a contact, or all of them, do in the last rounds of a trajectory."""
    if rounds < 1:
        raise InputError(f"rounds = {rounds} is less than 1; give 1 or more")
    _check(trajectory.model, contact)
    if isinstance(trajectory, PeriodicOrbit):
        model, begin, repeats = trajectory.model, 0.0, True
        starts: list[Start] = [(trajectory.state, None)] * rounds
        length = float(trajectory.period)
    else:
        starts, begin, repeats = _end(trajectory, rounds)
        model, length = trajectory.steady_model, 1.0
    unit = 1.0 if model.forced else flow_of(model).constants_of(model).period
    result = contact_trajectories(model, starts, length, per_period)
    shown = tuple(item for item in result if contact in (None, item.name))
    return ContactRounds(model, shown, begin * unit, unit, repeats)


def _end(trajectory: Trajectory, rounds: int) -> tuple[list[Start], float, bool]:
    """Return starts of the last rounds, the phase of the first, and whether all are alike."""
    settlement, sticking = trajectory.settlement, trajectory.sticking
    repeats = settlement.settled and settlement.kind != "equilibrium"
    if settlement.duration is not None:
        begin, places = trajectory.duration / settlement.duration, [trajectory.periods] * rounds
    else:
        requested = rounds * (settlement.period or 1) if repeats else 32  # periods at the end
        first = max(trajectory.periods - requested, 0)
        begin, places = float(first), [*range(first, trajectory.periods)]
    if not places:
        raise InputError("the trajectory ended within its first period; start elsewhere")
    modes = [None if sticking is None else sticking.mode(index) for index in places]
    return [*zip(trajectory.states[places], modes, strict=True)], begin, repeats


def _check(model: Model, contact: str | None) -> None:
    names = [item.name for item in contacts_of(model)]
    if not names:
        raise InputError(
            f"{model.name} has no contact with an exact law of friction, which sticks; show its "
            "outputs instead"
        )
    if contact is not None and contact not in names:
        raise unknown(f"{model.name} has no contact", contact, names)
