"""Hybrid trajectories from event to event, and a record of their contacts."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, repeat
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.batches import ROUNDING
from slipfold.flow.contact_state import Instant, Numbers, Undecided, changed
from slipfold.flow.guarded_flow import GuardStop
from slipfold.flow.hybrid_flow import HybridSystem, SmoothPhase
from slipfold.flow.modes import (
    CONTACT,
    STUCK,
    Ending,
    Mode,
    Status,
    SwitchingEvent,
    UndeterminedMode,
    reported_mode,
    status_name,
)
from slipfold.flow.release import Release, released_at_limit


class Interval(NamedTuple):
    """A time in which a contact slips, sticks or is open."""

    contact: str  # its name
    state: str  # ``"slip"``, ``"stick"`` or ``"free"``
    # Time since the start of the trajectory, in forcing periods; of an autonomous model in s
    begin: float
    end: float
    work: float  # of its friction on the structure in J
    heat: float  # from friction in J


@dataclass(eq=False, slots=True)  # frozen ones take three times as long to make
class ModeChange:
    """An instant at which the mode changes."""

    time: float  # in phases since the start
    state: Array  # shape (n,)
    mode: Mode  # what follows


class Recorder:
    """A record of the phases and changes of a trajectory in progress."""

    def __init__(self, contacts: Sequence[str], mode: Mode) -> None:
        self._contacts = contacts
        self._energies: list[Array] = []
        # Of each mode: its time, its state and the number of earlier smooth phases
        self.modes, self.times, self._legs = [mode], [0.0], [0]
        self._states: list[Array] = []
        self.periods = 0  # complete ones before the phases that are noted

    def add(self, energies: Array) -> None:
        """Note the energies of a smooth phase, shape (2 k,)."""
        self._energies.append(energies)

    def changed(self, time: float, state: Array, mode: Mode) -> None:
        """Note a new mode, at a phase of the present period."""
        self.modes.append(mode)
        self.times.append(self.periods + time)
        self._states.append(state)
        self._legs.append(len(self._energies))

    def forget(self, time: float) -> None:
        """Forget what came before the mode at a phase since the start."""
        first = bisect_right(self.times, time) - 1
        legs = self._legs[first]
        for record, count in ((self._energies, legs), (self._states, first), (self.modes, first)):
            del record[:count]
        self.times, self._legs = self.times[first:], [leg - legs for leg in self._legs[first:]]

    @property
    def changes(self) -> list[ModeChange]:
        """All changes that are noted."""
        return list(map(ModeChange, self.times[1:], self._states, self.modes[1:]))

    def ended(self, time: float) -> tuple[Interval, ...]:
        """Return all intervals up to a phase, sorted by their ends."""
        count = len(self._contacts)
        energies = np.zeros((len(self._energies) + 1, 2, count))
        if self._energies:
            energies[:-1] = np.concatenate(self._energies).reshape(-1, 2, count)
        result = [
            self._intervals(contact, name, energies[:, :, contact], time)
            for contact, name in enumerate(self._contacts)
        ]
        if count == 1:
            return tuple(result[0])
        return tuple(sorted(chain.from_iterable(result), key=attrgetter("end")))

    def _intervals(self, contact: int, name: str, energies: Array, time: float) -> list[Interval]:
        """Return the intervals of one contact. Shapes: energies (smooth phases + 1, 2)."""
        doing = np.array([mode[contact] for mode in self.modes])
        kept = np.flatnonzero(np.append(True, doing[1:] != doing[:-1]))
        sums = np.add.reduceat(energies, np.array(self._legs)[kept])
        begins = np.array(self.times)[kept]
        ends = np.append(begins[1:], time)
        lasts = ends > begins
        names = map(status_name, doing[kept][lasts].tolist())
        columns = (part[lasts].tolist() for part in (begins, ends, *sums.T))
        return [*map(Interval._make, zip(repeat(name), names, *columns, strict=False))]


class Broken(Exception):
    """A trajectory that cannot continue, and why."""

    def __init__(self, stop: GuardStop, part: SmoothPhase | None = None) -> None:
        super().__init__(stop.reason)
        self.stop, self.part = stop, part


def first_mode(system: HybridSystem, start: Array, phase: float = 0.0) -> Mode:
    """Return the mode in which a trajectory begins. Shapes: start (n,)."""
    now = system.at(start, phase)
    mode, rest = [], []
    for contact, components in enumerate(system.places):
        slip = now.slip[components]
        if system.flow.contacts[contact].opens and now.normal[contact] < 0:
            mode.append(Status.OPEN)
        elif math.hypot(*slip) * system.weights[contact] <= ROUNDING:
            mode.append(Status.STICK)
            rest.append(contact)
        else:
            mode.append(_slipping(slip))
    return Instant(now, system.places, tuple(rest), tuple(mode)).next_mode({})


def smooth_phases(
    system: HybridSystem,
    mode: Mode,
    state: Array,
    end: float,
    *,
    begin: float = 0.0,
    dense: bool = False,
) -> Iterator[tuple[SmoothPhase, Mode]]:
    """Propagate a state through its modes; yield each smooth phase and the mode that follows."""
    flow, phase = system.flow, begin
    if flow.planar:
        mode = _slow_where_slow(system, mode, state, phase)
    if Status.STICK in mode or Status.SLOW in mode:
        mode, first = _first_phases(system, mode, state, phase, end, dense=dense)
        for piece, after in first:
            yield piece, after
            state, phase = piece.state, piece.end
        if first and phase >= end:
            return
    for _ in range(CONTACT.max_changes):
        part = system.run(mode, state, phase, end, dense=dense)
        if part.event is None:
            yield part, mode
            return
        onset: list[SmoothPhase] = []
        try:
            after, resting = _after(system, part)
            for contact, status in enumerate(after if flow.planar else ()):
                if status is Status.SLOW and resting[contact] is Status.STICK:
                    new = Release(system, after, contact)
                    onset = new.phases(part.state, part.end, end, dense=dense)
        except Undecided as error:
            raise Broken(_undecided(error, part.end), part) from None
        except UndeterminedMode as error:
            reason = (
                f"{error} stick together and constrain one degree of freedom twice, so what each "
                "of them bears is not determined; join them to one contact, or put a "
                "spring between them"
            )
            raise Broken(GuardStop("undetermined", reason, phase), part) from None
        state = part.state
        yield part, after
        mode, phase = after, part.end
        for piece in onset:
            yield replace(piece, event=part.event), after
            state, phase = piece.state, piece.end
        if phase >= end:
            return
    reason = (
        f"contacts change between slip and stick more than {CONTACT.max_changes} times in a "
        "period; look at the last states, or make the model less stiff"
    )
    raise Broken(GuardStop("chattering", reason, phase))


def _first_phases(
    system: HybridSystem, mode: Mode, state: Array, phase: float, end: float, *, dense: bool
) -> tuple[Mode, list[tuple[SmoothPhase, Mode]]]:
    """Return the mode in which a trajectory continues, and first phases if slip begins at once."""
    first = list[tuple[SmoothPhase, Mode]]()
    try:
        slips = released_at_limit(system, mode, state, phase)
        if slips != mode:
            contact = next(i for i, status in enumerate(slips) if status is not mode[i])
            slips = _one_slow(slips, [contact])
            event = SwitchingEvent(Ending.YIELDS, contact, None, towards=slips[contact])
            first.append(
                (SmoothPhase(mode, phase, phase, state, np.zeros(2 * len(mode)), event), slips)
            )
        slow = slips.index(Status.SLOW) if Status.SLOW in slips else None
        new = None if slow is None else Release(system, slips, slow)
        if new is not None and new.begins(state, phase):
            pieces = new.phases(state, phase, end, dense=dense)
            first += [(piece, slips) for piece in pieces]
    except Undecided as error:
        raise Broken(_undecided(error, phase)) from None
    return slips, first


def _undecided(error: Undecided, phase: float) -> GuardStop:
    return GuardStop("undecided", f"{error}; start elsewhere", phase)


def _after(system: HybridSystem, part: SmoothPhase) -> tuple[Mode, Mode]:
    """Return the mode after an event, and the one in which all contacts at rest stick.

    The smooth phase ends in the latter.
    """
    event, mode = part.event, part.mode
    assert event is not None
    flow = system.flow
    if flow.straight and (alone := _alone(system, part, event)) is not None:
        return alone, alone
    if event.ending in (Ending.SLOWS, Ending.QUICKENS):
        slows = event.ending is Ending.SLOWS
        now_slow = _slow_where_slow(system, reported_mode(mode), part.state, part.end)
        after = changed(now_slow, {event.which: Status.SLOW if slows else Status.FORTH})
        after = _one_slow(after, [event.which]) if slows else after
        return after, after
    if event.ending in (Ending.LIMIT, Ending.STIFF, Ending.SINGULAR):
        raise Broken(_stop(system, part, event), part)
    now, places = system.at(part.state, part.end), system.places
    requested: dict[int, Status] = {}
    rest = []
    for contact, (status, components) in enumerate(zip(mode, places, strict=True)):
        slip, met = now.slip[components], event.which == contact
        if met and event.ending is Ending.PARTS:
            requested[contact] = Status.OPEN
            continue
        if status is Status.OPEN:
            if not (met and event.ending is Ending.MEETS):
                continue
            requested[contact] = _slipping(slip)
        if met and event.ending is Ending.STOPS:
            requested[contact] = Status.STICK
            rest.append(contact)
        elif status is Status.STICK:
            rest.append(contact)
            if met and event.ending is Ending.YIELDS:
                requested[contact] = event.towards
        elif math.hypot(*slip) * system.weights[contact] <= ROUNDING:
            rest.append(contact)
        elif status is Status.OPEN:
            continue  # it slips when it lands
        # A change would have been missed.
        elif len(slip) == 1 and float(status) * slip[0] * system.weights[contact] < -1e-9:
            raise Undecided(f"{flow.contacts[contact].name} slips against its own friction")
    stuck = dict.fromkeys(rest, Status.STICK)
    resting = tuple((requested | stuck).get(contact, own) for contact, own in enumerate(mode))
    if resting != mode:  # forces are judged where nothing is left of slip: friction may be steep
        part.state = system.held(resting, part.state, part.end)
        now = system.at(part.state, part.end)
    after = Instant(now, places, tuple(rest), mode).next_mode(requested)
    after = _one_slow(released_at_limit(system, after, part.state, part.end, now), rest)
    return after, resting


def _alone(system: HybridSystem, part: SmoothPhase, event: SwitchingEvent) -> Mode | None:
    """Return the mode after an event of a single contact; None if that is unclear."""
    if event.ending is Ending.YIELDS:
        return (event.towards,)
    if event.ending is Ending.STOPS:
        stuck = system.flow.stuck
        speed, holds = stuck.rest(part.state, part.end, system.constants)
        if holds:
            part.state[stuck.held[0]] = speed
            return STUCK
    return None


def _slow_where_slow(system: HybridSystem, mode: Mode, state: Array, phase: float) -> Mode:
    """Return a mode in which the slowest slip in the plane is integrated as slow if it is."""
    sliding = [
        contact for contact, components in enumerate(system.places)
        if mode[contact] is Status.FORTH and components.stop - components.start == 2
    ]  # fmt: skip
    if not sliding:
        return mode
    now, places = system.at(state, phase), system.places
    speeds = {contact: math.hypot(*now.slip[places[contact]]) for contact in sliding}
    weights = system.weights
    slowest = min(sliding, key=lambda contact: speeds[contact] * weights[contact])
    slow = speeds[slowest] * weights[slowest] < CONTACT.slow
    return changed(mode, {slowest: Status.SLOW}) if slow else mode


def _one_slow(mode: Mode, rest: Sequence[int]) -> Mode:
    """Return a mode with one slow contact, the one that begins to slip: its speed rescales time.

    Another slow contact is integrated as if it were fast.
    """
    if mode.count(Status.SLOW) < 2:
        return mode
    begins = [contact for contact in rest if mode[contact] is Status.SLOW]
    if len(begins) > 1:
        raise Undecided("two contacts begin to slip at one instant")
    return tuple(
        Status.FORTH if status is Status.SLOW and contact not in begins else status
        for contact, status in enumerate(mode)
    )


def _slipping(slip: Numbers) -> Status:
    return Status.FORTH if len(slip) == 2 or slip[0] > 0 else Status.BACK


def _stop(system: HybridSystem, part: SmoothPhase, event: SwitchingEvent) -> GuardStop:
    if event.ending is Ending.LIMIT:
        limit, mode = system.flow.limits[event.which], system.flow.of(part.mode)
        values = mode.outputs(part.state[None], np.array([part.end]), system.constants)
        value = float(values[0, mode.output_index(limit.output)])
        return GuardStop(limit.name, limit.reason.format(value=value), part.end)
    if event.ending is Ending.STIFF:
        reason = (
            "the trajectory would need too many steps; make what is steep or fast in the model "
            "less so"
        )
        return GuardStop("stiff", reason, part.end)
    end = part.end if np.isfinite(part.end) else part.begin  # after an overflow
    return GuardStop("singular", "the trajectory became singular; start elsewhere", end)
