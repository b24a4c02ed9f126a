"""Simulation: thousands of forcing periods, or as long as it takes, from rest or from any state."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.equilibrium import AT_REST, PUSH, pushed_off
from slipfold.flow.flow import flow_of
from slipfold.flow.guarded_flow import CHUNK, Stop, guarded_flow_of
from slipfold.flow.pace import divided, paced
from slipfold.flow.settling.autonomous_settlement import judge_autonomous
from slipfold.flow.settling.settlement import Settlement, judge_settlement
from slipfold.flow.sizes.typical_sizes import measured
from slipfold.flow.trajectory import Trajectory
from slipfold.models.model import Model
from slipfold.models.suggestion import unknown
from slipfold.models.turns import turns_between, turns_by_name
from slipfold.progress import Observer, Progress
from slipfold.text.stability import turns_text

PERIODS = 1000
"""Forcing periods of a motion by default."""

DIVISIONS = 4
"""Times that intervals are divided where a motion becomes faster than it began."""

LARGEST = 1e12
"""Size in scales beyond which a motion has left whatever its equations mean."""

ROUNDS = (1000, 4000, 16000)
"""Intervals after which an autonomous motion is judged, and ended if it has settled."""


def simulate(
    model: Model,
    periods: int | None = None,
    state: ArrayLike | Mapping[str, float] | None = None,
    *,
    tolerance: float = 1e-9,
    observer: Observer | None = None,
) -> Trajectory:
    """Integrate a model, and say whether its motion has settled, and on what.

    If it is observed, an interrupted motion is returned as far as it came. Shapes: state
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
    motion, settlement = integrated(model, start, asked, tolerance, observer)
    for _ in range(DIVISIONS):
        if motion.stopped is None or motion.stopped.kind != "stiff" or model.forced:
            break
        model, asked = divided(model, asked)
        motion, settlement = integrated(model, start, asked, tolerance, observer)
    return Trajectory(motion.model, motion.strobe, settlement, motion.stopped)


def integrated(
    model: Model,
    start: Array,
    asked: int | None,
    tolerance: float,
    observer: Observer | None = None,
) -> tuple[Motion, Settlement]:
    """Integrate as many periods as asked for, or until the motion settles or is interrupted."""
    motion = Motion(model, start)

    def tell() -> None:
        if observer is not None:
            observer(Progress("motion", motion.periods, asked, f"{motion.time:.6g} s"))

    try:
        for count in ROUNDS if asked is None else (asked,):
            motion.go_on(count - motion.periods, tell)
            settlement = motion.settlement(tolerance)
            if settlement.settled or motion.stopped is not None:
                break
    except KeyboardInterrupt:
        if observer is None:
            raise
        motion.stopped = interrupted_at(motion.time)
        settlement = motion.settlement(tolerance)
    return motion, settlement


class Motion:
    """A motion while it is integrated, piece by piece."""

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

        Whoever is to be told of each piece may interrupt.
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
        """Push the motion on where it would stay for ever."""
        last, scales = self._pieces[-1], self.model.state_scales()
        lately = np.concatenate(self._pieces[-2:])[-2:]
        moving = np.abs(np.diff(lately, axis=0) / scales).max(initial=0.0)
        pushed = pushed_off(self.model, last[-1]) if moving <= AT_REST else None
        if pushed is not None:
            self._pieces[-1] = np.concatenate([last[:-1], pushed[None]])
            self._pushed.append(self.periods)

    def _end_beyond_bounds(self, known: int) -> None:
        """End a motion that grows without bound, before numbers do; some pieces are known."""
        states = np.concatenate(self._pieces[known:])
        size = np.abs(states / self.model.state_scales()).max(initial=0.0)
        if self.stopped is None and size > LARGEST:
            self.stopped = unbounded_at(self.time, size)

    def settlement(self, tolerance: float) -> Settlement:
        """Return whether it has settled, and on what."""
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
            return cut_short(self.stopped)
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
    """Return the end of a motion that was interrupted."""
    return Stop("interrupted", "it was interrupted", time)


def unbounded_at(time: float, size: float) -> Stop:
    """Return the end of a motion that grew to some scales."""
    reason = f"the motion grows without bound: after {time:.6g} s it has {size:.0e} scales"
    return Stop("unbounded", reason, time)


def cut_short(stop: Stop) -> Settlement:
    """Say of a motion that ended early that it has not settled."""
    return Settlement(
        False, None, math.nan, None, f"not settled: ended after {stop.time:.6g} s, {stop.reason}"
    )
