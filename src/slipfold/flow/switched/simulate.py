"""Simulation of models whose contacts slip, stick and open."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.flow import flow_of
from slipfold.flow.guarded_flow import Stop
from slipfold.flow.pace import rounded_down
from slipfold.flow.scaled import power_of_two
from slipfold.flow.settling.autonomous_settlement import judge_autonomous
from slipfold.flow.settling.settlement import Settlement, judge_settlement
from slipfold.flow.simulate import (
    PERIODS,
    checked_periods,
    checked_tolerance,
    cut_short,
    initial_state,
    interrupted_at,
    simulate,
)
from slipfold.flow.switched.event_returns import judge_changes
from slipfold.flow.switched.mode import Status
from slipfold.flow.switched.mode_equations import contacts_of
from slipfold.flow.switched.switched_motion import SwitchedMotion
from slipfold.flow.trajectory import Sticking, Trajectory
from slipfold.models.model import Model
from slipfold.models.parameter import DURATION
from slipfold.progress import Observer, Progress

ROUNDS = (32, 128, 512, 2048, 8192)
"""Intervals after which an autonomous motion is judged, and ended if it has settled."""

PILOT = 4
"""Periods after which sizes of states are taken from a motion."""

SLIPS = (Status.FORTH, Status.BACK)

STILL = 1e-12
"""Rate, in scales an interval, at which a motion rests."""


def simulate_smooth_or_switched(
    model: Model,
    periods: int | None = None,
    state: ArrayLike | Mapping[str, float] | None = None,
    *,
    tolerance: float = 1e-9,
    observer: Observer | None = None,
) -> Trajectory:
    """Integrate a model, through stick and slip where its contacts come to that.

    A motion that always slips well is that of `slipfold.flow.simulate`.
    """
    start = initial_state(model, state)
    if slips_at_first(model, start):
        found = simulate(model, periods, start, tolerance=tolerance, observer=observer)
        if not comes_to_rest(found.stopped, model):
            return found
    return simulate_switched(
        model, checked_periods(periods), start, checked_tolerance(tolerance), observer
    )


def comes_to_rest(stopped: Stop | None, model: Model) -> bool:
    """Whether a motion ended where a contact may stick or open, and so goes on."""
    beyond = {name for contact in contacts_of(model) for name in contact.limits}
    return stopped is not None and stopped.kind in beyond


def slips_at_first(model: Model, start: Array) -> bool:
    """Whether no contact is at one of its limits. Shapes: start (n,)."""
    if not contacts_of(model):
        return True
    constants, starts = flow_of(model).constants_of(model), start[None]
    reached, bounds = _limits_at(model, starts, constants)
    return told_in_slip(model, starts, constants) and bool(np.all(reached > bounds))


def told_in_slip(model: Model, starts: Array, constants: Constants) -> bool:
    """Whether motions in slip tell where their contacts come to their limits.

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

    If `periods` is None an autonomous model is integrated until it settles. If it is observed, an
    interrupted motion is returned as far as it came. Shapes: start (n,).
    """
    motion, ends = begun(model, start, paced=periods is None), ends_of(model, periods)
    total = ends[0] if len(ends) == 1 else None

    def tell() -> None:
        if observer is not None:
            observer(Progress("motion", motion.periods, total, f"{motion.time:.6g} s"))

    try:
        for count in ends:
            motion.go_on(count - motion.periods, tell)
            found = trajectory_of(motion, tolerance)
            if found.settlement.settled or motion.stopped is not None:
                break
    except KeyboardInterrupt:
        if observer is None:
            raise
        motion.stopped = interrupted_at(motion.time)
        found = trajectory_of(motion, tolerance)
    return found


def ends_of(model: Model, periods: int | None) -> tuple[int, ...]:
    """Return the numbers of periods after which a motion is judged, and ended if it has settled."""
    if periods is not None:
        return (periods,)
    return (PERIODS,) if model.forced else ROUNDS


def begun(model: Model, start: Array, *, paced: bool) -> SwitchedMotion:
    """Begin a motion; if it is to be paced, an autonomous one in intervals that suit it.

    Shapes: start (n,).
    """
    if paced and not model.forced and model.values[DURATION.name] == DURATION.default:
        model = model.replace(**{DURATION.name: _natural(model, start)})
    return SwitchedMotion(_sized(model, start), start)


def trajectory_of(motion: SwitchedMotion, tolerance: float) -> Trajectory:
    """Return what has come of a motion so far, and whether it has settled."""
    settlement = _settlement(motion, tolerance)
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
    """Return the model with typical sizes of its states, seen in a short motion."""
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


def _settlement(motion: SwitchedMotion, tolerance: float) -> Settlement:
    """Judge whether a motion has settled, and on what."""
    model, scales = motion.model, motion.model.state_scales()
    if motion.stopped is not None:
        return cut_short(motion.stopped)
    if model.forced:
        return judge_settlement(motion.strobe, scales, tolerance)
    changes, mode, state = motion.recorder.changes, motion.modes[-1], motion.strobe[-1]
    since = math.ceil(changes[-1].time) if changes else 0
    if 2 * since < motion.periods and all(status in SLIPS for status in mode):
        return judge_autonomous(model, motion.strobe[since:], tolerance)
    rates = motion.flow.of(mode).rates(state[None], np.zeros(1), motion.constants)[0]
    if all(status is Status.STICK for status in mode) and np.abs(rates / scales).max() <= STILL:
        message = "settled on an equilibrium in which all contacts stick"
        return Settlement(True, 1, 0.0, None, message, kind="equilibrium")
    time = motion.periods * motion.constants.period
    return judge_changes(changes, scales, tolerance, motion.constants.period, time)
