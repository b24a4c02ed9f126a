"""Simulation, smooth or through stick and slip: a number of periods, or to a steady state."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.autonomous_settlement import judge_autonomous
from slipfold.flow.batches import ROUNDING
from slipfold.flow.equations import Constants, power_of_two
from slipfold.flow.equilibrium import AT_REST, PUSH, divided, paced, perturbed_off, rounded_down
from slipfold.flow.flow import flow_of
from slipfold.flow.guarded_flow import CHUNK, Stop, guarded_flow_of
from slipfold.flow.modes import Status, contacts_of
from slipfold.flow.scales import measured
from slipfold.flow.settlement import Settlement, judge_changes, judge_settlement, not_converged
from slipfold.flow.switched_motion import SwitchedMotion
from slipfold.flow.trajectory import Sticking, Trajectory
from slipfold.models.model import Model
from slipfold.models.parameter import DURATION
from slipfold.models.suggestion import unknown
from slipfold.models.turns import turns_between, turns_by_name
from slipfold.progress import Observer, Progress
from slipfold.text.stability import turns_text

PERIODS = 1000
"""Forcing periods of a trajectory by default."""

DIVISIONS = 4
"""Times that intervals are divided where a trajectory becomes faster than it began."""

LARGEST = 1e12
"""Size in scales beyond which a trajectory has left whatever its equations mean."""

SMOOTH_CHECKS = (1000, 4000, 16000)
"""Intervals after which an autonomous trajectory is judged, and ended if it has converged."""


def simulate(
    model: Model,
    periods: int | None = None,
    state: ArrayLike | Mapping[str, float] | None = None,
    *,
    tolerance: float = 1e-9,
    observer: Observer | None = None,
) -> Trajectory:
    """Integrate a model, and say whether its trajectory has converged, and to what.

    If it is observed, an interrupted trajectory is returned as far as it came. Shapes: state
    (n_states,).

    >>> from slipfold.models import SlidingOscillator, model_named
    >>> trajectory = simulate(SlidingOscillator(f=12.2, Nd=0.05), periods=1000)
    >>> trajectory.settlement.settled, trajectory.settlement.period
    (True, 1)
    >>> print(simulate(model_named("vanderpol-free")).settlement.kind)
    cycle
    """
    asked, tolerance = checked_periods(periods), checked_tolerance(tolerance)
    start = initial_state(model, state)
    if model.forced:
        asked = asked or PERIODS
    else:
        model, asked = paced(model, start, asked)
    for _ in range(DIVISIONS + 1):
        motion = Motion(model, start)
        settlement = integrate(
            motion,
            SMOOTH_CHECKS if asked is None else (asked,),
            partial(motion.settlement, tolerance),
            observer,
        )
        if motion.stopped is None or motion.stopped.kind != "stiff" or model.forced:
            break
        model, asked = divided(model, asked)
    return Trajectory(motion.model, motion.strobe, settlement, motion.stopped)


def integrate(
    motion: Motion | SwitchedMotion,
    ends: Sequence[int],
    settlement: Callable[[], Settlement],
    observer: Observer | None,
) -> Settlement:
    """Integrate up to numbers of periods, until a trajectory converges, ends or is interrupted."""
    total = ends[0] if len(ends) == 1 else None

    def report() -> None:
        if observer is not None:
            observer(Progress("motion", motion.periods, total, f"{motion.time:.6g} s"))

    try:
        for count in ends:
            motion.go_on(count - motion.periods, report)
            found = settlement()
            if found.settled or motion.stopped is not None:
                break
    except KeyboardInterrupt:
        if observer is None:
            raise
        motion.stopped = interrupted_at(motion.time)
        found = settlement()
    return found


class Motion:
    """A trajectory while it is integrated, piece by piece."""

    def __init__(self, model: Model, start: Array) -> None:
        self.model = measured(model, start=start)
        self.stopped: Stop | None = None
        self._constants = flow_of(model).constants_of(self.model)
        self._weights = guarded_flow_of(self.model).weights(start, self._constants)
        self._pieces = [start[None]]
        self._pushed: list[int] = []
        self.periods = 0  # whole ones so far
        self._implicit = 0  # those in implicit steps

    @property
    def strobe(self) -> Array:
        """States at the start of every period so far, read-only."""
        whole = np.concatenate(self._pieces)
        whole.setflags(write=False)
        return whole

    @property
    def time(self) -> float:
        """Seconds so far."""
        return self.periods * self._constants.period

    def go_on(self, periods: int, tell: Callable[[], None] = lambda: None) -> Array:
        """Integrate some more periods; return the states at their starts, as far as it came.

        The caller who is to be told of each piece may interrupt.
        """
        flow, first = guarded_flow_of(self.model), self.periods
        end = first + periods
        while self.stopped is None and self.periods < end:
            count = end - self.periods
            if not self.model.forced:
                self._leave_unstable_equilibrium()
                count = min(CHUNK, count)
            last, known = self._pieces[-1][-1], len(self._pieces)
            for piece in flow.pieces(last, count, self._constants, self.periods, self._weights):
                self._pieces.append(piece.states)
                self.periods += len(piece.states)
                self._implicit += piece.implicit
                self.stopped = piece.stop
                tell()
            if not self.model.forced:
                self._end_beyond_bounds(known)
        return self.strobe[first : self.periods]

    def _leave_unstable_equilibrium(self) -> None:
        """Push the trajectory on where it would stay for ever."""
        last, scales = self._pieces[-1], self.model.state_scales()
        lately = np.concatenate(self._pieces[-2:])[-2:]
        moving = np.abs(np.diff(lately, axis=0) / scales).max(initial=0.0)
        pushed = perturbed_off(self.model, last[-1]) if moving <= AT_REST else None
        if pushed is not None:
            self._pieces[-1] = np.concatenate([last[:-1], pushed[None]])
            self._pushed.append(self.periods)

    def _end_beyond_bounds(self, known: int) -> None:
        """End a trajectory that grows without bound, before numbers do; some pieces are known."""
        states = np.concatenate(self._pieces[known:])
        size = np.abs(states / self.model.state_scales()).max(initial=0.0)
        if self.stopped is None and size > LARGEST:
            self.stopped = unbounded_at(self.time, size)

    def settlement(self, tolerance: float) -> Settlement:
        """Return whether it has converged, and to what."""
        found = self._judged(tolerance)
        return replace(found, message=found.message + self._computed()) if self._implicit else found

    def _computed(self) -> str:
        each = "forcing period" if self.model.forced else "interval"
        return (
            f"; {self._implicit} of {self.periods} {each}s took implicit steps, since it is stiff"
        )

    def _judged(self, tolerance: float) -> Settlement:
        model = self.model
        if self.stopped is not None:
            return ended_early(self.stopped)
        if model.forced:
            found = judge_settlement(
                self.strobe, model.state_scales(), tolerance, model.whole_turns
            )
            return self._turned(found, found.period)
        found = judge_autonomous(model, self.strobe, tolerance)
        found = self._turned(found, found.duration and found.duration / self._constants.period)
        return replace(found, message=found.message + self._told()) if self._pushed else found

    def _turned(self, found: Settlement, length: float | None) -> Settlement:
        """Add how often angles turn round in a response of that many periods."""
        if length is None or not self.model.whole_turns.any():
            return found
        start, zero = self.strobe[-1:], np.zeros(1)
        (end,) = flow_of(self.model).advance(start, zero, zero + length, self._constants)
        counts = turns_between(end - start[0], self.model.whole_turns)
        turns = turns_by_name(self.model.states, counts)
        told = [found.message, turns_text(turns)]
        return replace(found, message="; ".join(filter(None, told)), turns=turns)

    def _told(self) -> str:
        if self._pushed[0] == 0:
            where = "it began on an unstable equilibrium"
        else:
            time = self._pushed[0] * self._constants.period
            where = f"at {time:.6g} s it had come to an unstable equilibrium"
        return f". {where[:1].upper()}{where[1:]} and was pushed off it by {PUSH:g} (scaled)"


def initial_state(model: Model, state: ArrayLike | Mapping[str, float] | None) -> Array:
    """Check an initial state.

    Shapes: state (n_states,); returns (n_states,).

    >>> from slipfold.models import SlidingOscillator
    >>> [float(value) for value in initial_state(SlidingOscillator(), {"y": 0.1})]
    [0.0, 0.1, 0.0, 0.0]
    """
    names = [item.name for item in model.states]
    if state is None:
        return model.start
    if isinstance(state, Mapping):
        for name in state:
            if name not in names:
                raise unknown(f"{model.name} has no state", name, names)
        own = dict(zip(names, model.start, strict=True))
        state = [state.get(name, own[name]) for name in names]
    try:
        values = np.array(state, dtype=float)
    except (TypeError, ValueError):
        raise InputError(
            f"the state {state!r} is not a list of numbers; give {', '.join(names)}"
        ) from None
    if values.shape != (len(names),):
        raise InputError(
            f"the state has the shape {values.shape}; give {len(names)} numbers: {', '.join(names)}"
        )
    for name, value in zip(names, values, strict=True):
        if not math.isfinite(value):
            raise InputError(f"the state {name} = {value} is not a finite number; give one")
    return values


def checked_periods(periods: object) -> int | None:
    """Return a number of periods, or None for as many as it takes."""
    if periods is None:
        return None
    if isinstance(periods, (int, np.integer)) and not isinstance(periods, bool) and periods >= 1:
        return int(periods)
    raise InputError(f"periods = {periods!r} is not a whole number of at least 1; give one")


def checked_tolerance(tolerance: float) -> float:
    """Return a tolerance that is a positive number."""
    if math.isfinite(tolerance) and tolerance > 0:
        return tolerance
    raise InputError(f"tolerance = {tolerance!r} is not a positive number; give one like 1e-9")


def interrupted_at(time: float) -> Stop:
    """Return the end of a trajectory that was interrupted."""
    return Stop("interrupted", "it was interrupted", time)


def unbounded_at(time: float, size: float) -> Stop:
    """Return the end of a trajectory that grew to some scales."""
    reason = f"the motion grows without bound: after {time:.6g} s it has {size:.0e} scales"
    return Stop("unbounded", reason, time)


def ended_early(stop: Stop) -> Settlement:
    """Say of a trajectory that ended early that it has not settled."""
    return not_converged(f"not settled: ended after {stop.time:.6g} s, {stop.reason}")


SWITCHED_CHECKS = (32, 128, 512, 2048, 8192)
"""Intervals after which an autonomous trajectory is judged, and ended if it has converged."""

PILOT = 4
"""Periods after which sizes of states are taken from a trajectory."""

SLIPS = (Status.FORTH, Status.BACK)


def simulate_smooth_or_switched(
    model: Model,
    periods: int | None = None,
    state: ArrayLike | Mapping[str, float] | None = None,
    *,
    tolerance: float = 1e-9,
    observer: Observer | None = None,
) -> Trajectory:
    """Integrate a model, through stick and slip where its contacts come to that.

    A trajectory that always slips well is that of `slipfold.flow.simulate`.
    """
    start = initial_state(model, state)
    if starts_in_slip(model, start):
        found = simulate(model, periods, start, tolerance=tolerance, observer=observer)
        if not reaches_stick_limit(found.stopped, model):
            return found
    return simulate_switched(
        model, checked_periods(periods), start, checked_tolerance(tolerance), observer
    )


def reaches_stick_limit(stopped: Stop | None, model: Model) -> bool:
    """Whether a trajectory ended where a contact may stick or open, and so continues."""
    beyond = {name for contact in contacts_of(model) for name in contact.limits}
    return stopped is not None and stopped.kind in beyond


def starts_in_slip(model: Model, start: Array) -> bool:
    """Whether no contact is at one of its limits. Shapes: start (n,)."""
    if not contacts_of(model):
        return True
    constants, starts = flow_of(model).constants_of(model), start[None]
    reached, bounds = _limits_at(model, starts, constants)
    return limits_are_defined(model, starts, constants) and bool(np.all(reached > bounds))


def limits_are_defined(model: Model, starts: Array, constants: Constants) -> bool:
    """Whether trajectories in slip tell where their contacts come to their limits.

    Over the speed of a floor at rest slip is infinite, and no limit can be followed. Shapes: starts
    (m, n); constants of the model or of m like it.
    """
    contacts = contacts_of(model)
    if not contacts:
        return True
    return all(contact.limits for contact in contacts) and bool(
        np.isfinite(_limits_at(model, starts, constants)[0]).all()
    )


def _limits_at(model: Model, starts: Array, constants: Constants) -> tuple[Array, Array]:
    """Return what limits of contacts watch, shape (m, l), and their bounds, shape (l,)."""
    beyond = {name for contact in contacts_of(model) for name in contact.limits}
    flow = flow_of(model)
    values = flow.outputs(starts, np.zeros(len(starts)), constants)
    watched = [item for item in model.limits if item.name in beyond]
    reached = values[:, [flow.output_index(item.output) for item in watched]]
    return reached, np.array([item.bound for item in watched])


def simulate_switched(
    model: Model,
    periods: int | None,
    start: Array,
    tolerance: float,
    observer: Observer | None = None,
) -> Trajectory:
    """Integrate a model with stick and slip from a state at phase zero.

    If `periods` is None an autonomous model is integrated until it converges. If it is observed, an
    interrupted trajectory is returned as far as it came. Shapes: start (n,).
    """
    motion = start_switched(model, start, paced=periods is None)
    settlement = partial(settlement_of, motion, tolerance)
    return trajectory_of(motion, integrate(motion, ends_of(model, periods), settlement, observer))


def ends_of(model: Model, periods: int | None) -> tuple[int, ...]:
    """Return the numbers of periods after which a motion is judged, and ended if it has settled."""
    if periods is not None:
        return (periods,)
    return (PERIODS,) if model.forced else SWITCHED_CHECKS


def start_switched(model: Model, start: Array, *, paced: bool) -> SwitchedMotion:
    """Begin a trajectory; if it is to be paced, an autonomous one in intervals that suit it.

    Shapes: start (n,).
    """
    if paced and not model.forced and model.values[DURATION.name] == DURATION.default:
        model = model.replace(**{DURATION.name: _natural(model, start)})
    return SwitchedMotion(_sized(model, start), start)


def trajectory_of(motion: SwitchedMotion, settlement: Settlement) -> Trajectory:
    """Return the trajectory so far, as data."""
    unit = 1.0 if motion.model.forced else motion.constants.period
    end = (
        motion.periods if motion.stopped is None else motion.stopped.time / motion.constants.period
    )
    intervals = motion.recorder.ended(end)
    if unit != 1:
        intervals = tuple(
            item._replace(begin=item.begin * unit, end=item.end * unit) for item in intervals
        )
    # An interrupt may have come between the mode and the state of a period.
    modes = np.array(motion.modes[: motion.periods + 1], np.int64)
    modes.setflags(write=False)
    contacts = tuple(item.name for item in motion.flow.contacts)
    sticking = Sticking(contacts, modes, intervals)
    return Trajectory(motion.model, motion.strobe, settlement, motion.stopped, sticking)


def _sized(model: Model, start: Array) -> Model:
    """Return the model with characteristic scales of its states, seen in a short trajectory."""
    if not np.isnan(model.declared_scales()).any() or model.found_sizes is not None:
        return model
    sizes = np.ones(len(start))
    for _ in range(2):  # what is small beside one shows in a second look only
        pilot = SwitchedMotion(model.measured_in(sizes), start)
        pilot.go_on(PILOT)
        ends = [item.state for item in pilot.recorder.changes]
        reached = np.abs(np.array([*pilot.strobe, *ends])).max(axis=0)
        sizes = power_of_two(np.where(reached > 0, reached, sizes))
    return model.measured_in(sizes)


def _natural(model: Model, start: Array) -> float:
    """Return half the period of the fastest vibration in slip, rounded to 1, 2 or 5."""
    motion = SwitchedMotion(model.replace(**{DURATION.name: 1.0}), start)
    slipping = (Status.FORTH,) * len(motion.flow.contacts)
    slopes = motion.flow.of(slipping).jacobians(start[None], np.zeros(1), motion.constants)[0]
    if not np.isfinite(slopes).all():
        return DURATION.default
    fastest = float(np.abs(np.linalg.eigvals(slopes)).max())
    if not fastest > 0:
        return DURATION.default
    return rounded_down(math.pi / fastest)


def settlement_of(motion: SwitchedMotion, tolerance: float) -> Settlement:
    """Judge whether a trajectory has converged, and to what."""
    model, scales = motion.model, motion.model.state_scales()
    if motion.stopped is not None:
        return ended_early(motion.stopped)
    if model.forced:
        return judge_settlement(motion.strobe, scales, tolerance)
    changes, mode, state = motion.recorder.changes, motion.modes[-1], motion.strobe[-1]
    since = math.ceil(changes[-1].time) if changes else 0
    if 2 * since < motion.periods and all(status in SLIPS for status in mode):
        return judge_autonomous(model, motion.strobe[since:], tolerance)
    rates = motion.flow.of(mode).rates(state[None], np.zeros(1), motion.constants)[0]
    if all(status is Status.STICK for status in mode) and np.abs(rates / scales).max() <= ROUNDING:
        message = "settled on an equilibrium in which all contacts stick"
        return Settlement(True, 1, 0.0, None, message, kind="equilibrium")
    time = motion.periods * motion.constants.period
    return judge_changes(changes, scales, tolerance, motion.constants.period, time)
