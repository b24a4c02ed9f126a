"""Simulation, smooth or through stick and slip: a number of periods, or to a steady state."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from slipfold.arrays import Array, as_numbers
from slipfold.errors import InputError, unknown
from slipfold.flow.batches import ROUNDING
from slipfold.flow.equations import Constants, power_of_two
from slipfold.flow.equilibrium import (
    EQUILIBRIUM,
    perturbed_from_equilibrium,
    rounded_down,
    shortened,
    with_duration,
)
from slipfold.flow.flow import flow_of
from slipfold.flow.guarded_flow import CHUNK, GuardedFlow, GuardStop
from slipfold.flow.hybrid_flow import hybrid_system
from slipfold.flow.hybrid_trajectory import Broken, Recorder, first_mode, smooth_phases
from slipfold.flow.modes import Status, contacts_of, limits_of_contacts, reported_mode
from slipfold.flow.scales import measured
from slipfold.flow.settlement import (
    Settlement,
    judge_autonomous,
    judge_changes,
    judge_settlement,
    not_converged,
)
from slipfold.flow.trajectory import Sticking, Trajectory
from slipfold.models.angles import count_revolutions, revolutions_by_name, wrap_angles
from slipfold.models.model import Model
from slipfold.models.quantities import DURATION
from slipfold.models.units import parse_quantity
from slipfold.progress import Observer, Progress
from slipfold.text import listed, revolutions_text

PERIODS = 1000
"""Forcing periods of a trajectory by default."""

LARGEST = 1e12
"""Size in scales beyond which a trajectory has left whatever its equations mean."""


def simulate(
    model: Model,
    periods: int | None = None,
    state: ArrayLike | Mapping[str, float | str] | None = None,
    *,
    tolerance: float = 1e-9,
    observer: Observer | None = None,
    through_stick: bool = True,
    kept: int | None = None,
) -> Trajectory:
    """Integrate a model, and say whether its trajectory has converged, and to what.

    Where a contact sticks or opens the trajectory continues, unless it is not to continue
    `through_stick`: then it ends there, as at other limits. Intervals of contacts are `kept` of so
    many periods at its end, or of all. If it is observed, an interrupted trajectory is returned as
    far as it came. Shapes: state (n_states,).
    """
    start = initial_state(model, state)
    if not through_stick or starts_in_slip(model, start):
        result = _simulate_in_slip(model, periods, start, tolerance, observer)
        if not (through_stick and reaches_stick_limit(result.stopped, model)):
            return result
    hybrid = HybridIntegration.begin(model, start, own_duration=periods is None)
    hybrid.kept = kept
    return hybrid.run(periods, tolerance, observer)


def _simulate_in_slip(
    model: Model, periods: int | None, start: Array, tolerance: float, observer: Observer | None
) -> Trajectory:
    if not model.forced:
        model, periods = with_duration(model, start, periods)
    for _ in range(5):  # intervals are divided where it becomes faster than it began
        result = SmoothIntegration(model, start).run(periods, tolerance, observer)
        if model.forced or result.stopped is None or result.stopped.kind != "stiff":
            break
        model, periods = shortened(model, periods)
    return result


def initial_state(model: Model, state: ArrayLike | Mapping[str, float | str] | None) -> Array:
    """Check an initial state.

    Shapes: state (n_states,); returns (n_states,).

    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
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
        own = zip(model.states, model.start.tolist(), strict=True)
        state = [parse_quantity(state.get(x.name, at), x.unit, x.name) for x, at in own]
    values = as_numbers(state)
    if values.shape != (len(names),):
        raise InputError(
            f"the state {state!r} is not a list of {len(names)} numbers; give {', '.join(names)}"
        )
    for name, value, given in zip(names, values, np.array(state, dtype=object), strict=True):
        if not math.isfinite(value):
            raise InputError(f"the state {name} = {given} is not a finite number; give one")
    return values


def reaches_stick_limit(stopped: GuardStop | None, model: Model) -> bool:
    """Whether a trajectory ended where a contact may stick or open, and so continues."""
    return stopped is not None and stopped.kind in limits_of_contacts(model)


def starts_in_slip(model: Model, start: Array) -> bool:
    """Whether no contact is at one of its limits. Shapes: start (n,)."""
    if not contacts_of(model):
        return True
    given = model, start[None], flow_of(model).constants_of(model)
    return limits_are_defined(*given) and bool(np.all(_margins(*given) > 0))


def limits_are_defined(model: Model, starts: Array, constants: Constants) -> bool:
    """Whether trajectories in slip report where their contacts reach their limits.

    A floor that rests or swings has none, and over the speed of one at rest slip is infinite.
    Shapes: starts (m, n); constants of the model or of m like it.
    """
    if not contacts_of(model):
        return True
    return not model.resting and bool(np.isfinite(_margins(model, starts, constants)).all())


def _margins(model: Model, starts: Array, constants: Constants) -> Array:
    """Return how far contacts are from their limits, shape (m, l)."""
    beyond = limits_of_contacts(model)
    limits = [item for item in model.limits if item.name in beyond]
    return flow_of(model).margins(limits, starts, np.zeros(len(starts)), constants)


class Integration(ABC):
    """A trajectory while it is integrated, one forcing period after the other."""

    checks: Sequence[int]
    """Intervals after which an autonomous trajectory is judged, and ended if it has converged."""

    def __init__(self, model: Model, constants: Constants) -> None:
        self.model, self.constants = model, constants
        self.stopped: GuardStop | None = None  # why and when it ended early

    @property
    @abstractmethod
    def states(self) -> Array:
        """States at the start of every period so far, read-only, shape (periods + 1, n)."""

    @property
    @abstractmethod
    def periods(self) -> int:
        """Complete periods so far."""

    @property
    def time(self) -> float:
        """Seconds so far."""
        return self.periods * self.constants.period

    @abstractmethod
    def advance(self, periods: int, on_progress: Callable[[], None] = lambda: None) -> None:
        """Integrate some more periods, as far as it comes; `on_progress` may interrupt."""

    @abstractmethod
    def settlement(self, tolerance: float) -> Settlement:
        """Return whether it has converged, and to what."""

    def result(self, tolerance: float) -> Trajectory:
        """Return the trajectory so far, as data."""
        return Trajectory(self.model, self.states, self.settlement(tolerance), self.stopped)

    def ends(self, periods: int | None) -> Sequence[int]:
        """Return the numbers of periods after which it is judged, and ended if it has converged."""
        if periods is not None:
            return (periods,)
        return (PERIODS,) if self.model.forced else self.checks

    def run(
        self, periods: int | None, tolerance: float, observer: Observer | None = None
    ) -> Trajectory:
        """Integrate for some periods, or until it converges; keep what there is if interrupted."""
        ends = self.ends(periods)
        total = ends[0] if len(ends) == 1 else None

        def report() -> None:
            if observer is not None:
                observer(Progress("motion", self.periods, total, f"{self.time:.6g} s"))

        try:
            for count in ends:
                self.advance(count - self.periods, report)
                result = self.result(tolerance)
                if result.settlement.settled or self.stopped is not None:
                    break
        except KeyboardInterrupt:
            if observer is None:
                raise
            self.stopped = GuardStop("interrupted", "it was interrupted", self.time)
            result = self.result(tolerance)
        return result

    @abstractmethod
    def _after(self, length: float) -> Array:
        """Return the state after so many more periods, shape (n,)."""

    def _with_revolutions(self, result: Settlement) -> Settlement:
        """Add the revolutions of angles in a response or a cycle."""
        if result.kind in (None, "equilibrium") or not self.model.angle_periods.any():
            return result
        length = (result.duration or 0.0) / self.constants.period or float(result.period or 1)
        counts = count_revolutions(self._after(length) - self.states[-1], self.model.angle_periods)
        revolutions = revolutions_by_name(self.model.states, counts)
        message = "; ".join(filter(None, [result.message, revolutions_text(revolutions)]))
        return replace(result, message=message, revolutions=revolutions)

    def _ended_early(self, stop: GuardStop) -> Settlement:
        return not_converged(f"not settled: ended after {stop.time:.6g} s, {stop.reason}")


class SmoothIntegration(Integration):
    """A trajectory that ends where a limit of the model is met."""

    checks = (1000, 4000, 16000)

    def __init__(self, model: Model, start: Array) -> None:
        model = measured(model, start=start)
        super().__init__(model, flow_of(model).constants_of(model))
        self._flow = GuardedFlow(model, self.constants, start)
        self._pieces = [start[None]]
        self._pushed: list[int] = []
        self._periods = 0
        self._implicit = 0  # periods in implicit steps

    @property
    def states(self) -> Array:
        """States at the start of every period so far."""
        whole = np.concatenate(self._pieces)
        whole.setflags(write=False)
        return whole

    @property
    def periods(self) -> int:
        """Complete periods so far."""
        return self._periods

    def advance(self, periods: int, on_progress: Callable[[], None] = lambda: None) -> None:
        """Integrate some more periods, as far as it comes."""
        end = self._periods + periods
        while self.stopped is None and self._periods < end:
            count = end - self._periods
            if not self.model.forced:
                self._leave_unstable_equilibrium()
                count = min(CHUNK, count)
            last, known = self._pieces[-1][-1], len(self._pieces)
            for piece in self._flow.pieces(last, count, self._periods):
                self._pieces.append(piece.states)
                self._periods += len(piece.states)
                self._implicit += piece.implicit
                self.stopped = piece.stop
                on_progress()
            if not self.model.forced:
                self._end_beyond_bounds(known)

    def _leave_unstable_equilibrium(self) -> None:
        """Push the trajectory on where it would stay for ever."""
        last, scales = self._pieces[-1], self.model.state_scales()
        lately = np.concatenate(self._pieces[-2:])[-2:]
        moving = np.abs(np.diff(lately, axis=0) / scales).max(initial=0.0)
        still = moving <= EQUILIBRIUM.distance
        pushed = perturbed_from_equilibrium(self.model, last[-1]) if still else None
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
        model, stop = self.model, self.stopped
        if stop is not None:
            result = self._ended_early(stop)
        elif model.forced:
            scales, periods = model.state_scales(), model.angle_periods
            result = judge_settlement(self.states, scales, tolerance, periods)
        else:
            result = judge_autonomous(model, self.states, tolerance)
        result = self._with_revolutions(result)
        message = result.message
        if self._pushed and stop is None:
            message += self._pushed_text()
        if self._implicit:
            each = "forcing period" if model.forced else "interval"
            message += (
                f"; {self._implicit} of {self.periods} {each}s took implicit steps, since it is "
                "stiff"
            )
        return replace(result, message=message)

    def _after(self, length: float) -> Array:
        start, zero = self.states[-1:], np.zeros(1)
        return flow_of(self.model).advance(start, zero, zero + length, self.constants)[0]

    def _pushed_text(self) -> str:
        time = self._pushed[0] * self.constants.period
        where = f"At {time:.6g} s it had reached" if time else "It began on"
        size = f"{EQUILIBRIUM.perturbation:g} (scaled)"
        return f". {where} an unstable equilibrium and was pushed off it by {size}"


LONGER = (32_768, 131_072)
"""Intervals after which a trajectory whose slowest vibration is much slower is judged as well."""

SLOW_ROUNDS = 1024
"""Half periods of that vibration within which a trajectory should settle."""


class HybridIntegration(Integration):
    """A trajectory through stick, slip and flight, and a record of what contacts did."""

    checks: Sequence[int] = (32, 128, 512, 2048, 8192)

    def __init__(self, model: Model, start: Array) -> None:
        self.system = system = hybrid_system(model, start)
        super().__init__(model, system.constants)
        self.flow = system.flow
        mode = reported_mode(first_mode(system, start))
        self.modes = [mode]
        self._states = [system.held(mode, start, 0.0)]
        self.recorder = Recorder([item.name for item in self.flow.contacts], mode)
        self.kept: int | None = None  # periods whose record is kept: of slow ones it is long

    @classmethod
    def begin(
        cls, model: Model, start: Array, *, own_duration: bool, energies: bool = True
    ) -> HybridIntegration:
        """Begin in characteristic scales; an autonomous one with its own duration if requested.

        Shapes: start (n,).
        """
        further = list[int]()
        if own_duration and not model.forced and model.values[DURATION.name] == DURATION.default:
            duration, ratio = _natural_duration(model, start)
            model = model.replace(**{DURATION.name: duration})
            # Slow vibrations settle within as many of their own periods.
            further = [every for every in LONGER if every < 4 * SLOW_ROUNDS * ratio]
        result = cls(_in_own_scales(model, start), start)
        result.checks = (*cls.checks, *further)
        result.system = replace(result.system, energies=energies)
        return result

    @property
    def states(self) -> Array:
        """States at the start of every period so far, shape (periods + 1, n)."""
        whole = np.array(self._states)
        whole.setflags(write=False)
        return whole

    @property
    def periods(self) -> int:
        """Complete periods so far."""
        return len(self._states) - 1

    @property
    def time(self) -> float:
        """Seconds so far, of complete periods and the known part of another."""
        return max(self.periods, self.recorder.times[-1]) * self.constants.period

    def advance(self, periods: int, on_progress: Callable[[], None] = lambda: None) -> None:
        """Integrate some more periods, as far as it comes."""
        last, state, mode = self.periods + periods, self._states[-1], self.modes[-1]
        while (done := self.periods) < last:
            self.recorder.periods = done
            try:
                for part, after in smooth_phases(self.system, mode, state, 1.0):
                    self.recorder.add(part.energies)
                    state = part.state
                    if reported_mode(after) != mode:
                        mode = reported_mode(after)
                        self.recorder.changed(part.end, state, mode)
            except Broken as broken:
                time = (done + broken.stop.time) * self.constants.period
                self.stopped = replace(broken.stop, time=time)
                return
            state = wrap_angles(state, self.model.angle_periods)
            self.modes.append(mode)
            self._states.append(state)
            if self.kept is not None:
                self.recorder.forget(max(self.periods - self.kept, 0))
            on_progress()

    def settlement(self, tolerance: float) -> Settlement:
        """Return whether it has converged, and to what."""
        model, scales = self.model, self.model.state_scales()
        if self.stopped is not None:
            return self._ended_early(self.stopped)
        if model.forced:
            result = judge_settlement(self.states, scales, tolerance, model.angle_periods)
            return self._with_revolutions(result)
        changes, mode, state = self.recorder.changes, self.modes[-1], self._states[-1]
        since = math.ceil(changes[-1].time) if changes else 0
        slips = all(status in (Status.FORTH, Status.BACK) for status in mode)
        if 2 * since < self.periods and slips:
            return self._with_revolutions(judge_autonomous(model, self.states[since:], tolerance))
        sticks = [item.name for item, does in zip(self.flow.contacts, mode, strict=True)
                  if does is Status.STICK]  # fmt: skip
        at = state[None], np.zeros(1), self.constants
        rates = self.flow.of(mode).rates(*at)[0]
        if sticks and np.abs(rates / scales).max() <= ROUNDING:
            stuck = f"{listed(sticks)} stick{'s' * (len(sticks) == 1)}"
            stuck = "all contacts stick" if len(sticks) == len(mode) else stuck
            free = np.delete(np.arange(len(state)), self.flow.mode(mode).held_at(self.constants))
            slopes = self.flow.of(mode).jacobians(*at)[0][np.ix_(free, free)]
            matrix = slopes * (scales[free] / scales[free, None])
            growth = np.linalg.eigvals(matrix).real.max(initial=0.0)
            # Eigenvalues have errors of n last digits of the norm, a double one of their root.
            error = math.sqrt(len(matrix) * np.finfo(float).eps) * np.linalg.norm(matrix)
            if growth <= error:
                message = f"settled on an equilibrium in which {stuck}"
                return Settlement(True, 1, 0.0, None, message, kind="equilibrium")
            return not_converged(f"not settled: on an unstable equilibrium in which {stuck}")
        if 2 * since < self.periods:
            states, flow = self.states[since:], self.flow.of(mode)
            some = states[-9:]
            slopes = flow.jacobians(some, np.zeros(len(some)), self.constants)
            # A contact that sticks keeps its slip, and may rest anywhere: its multipliers are one.
            rank = np.linalg.matrix_rank(np.hstack(list(slopes * scales / scales[:, None])))
            given = model, states, tolerance, flow, len(scales) - int(rank)
            return self._with_revolutions(judge_autonomous(*given))
        return self._with_revolutions(judge_changes(model, changes, tolerance, self.time))

    def _after(self, length: float) -> Array:
        state = self._states[-1]
        for part, _ in smooth_phases(self.system, self.modes[-1], state, length):
            state = part.state
        return state

    def result(self, tolerance: float) -> Trajectory:
        """Return the trajectory so far, as data, with what its contacts did."""
        period = self.constants.period
        end = self.periods if self.stopped is None else self.stopped.time / period
        intervals = self.recorder.ended(end)
        if not self.model.forced and period != 1:
            intervals = tuple(
                item._replace(begin=item.begin * period, end=item.end * period)
                for item in intervals
            )
        # An interrupt may have come between the mode and the state of a period.
        modes = np.array(self.modes[: self.periods + 1], np.int64)
        modes.setflags(write=False)
        contacts = tuple(item.name for item in self.flow.contacts)
        sticking = Sticking(contacts, modes, intervals)
        return replace(super().result(tolerance), sticking=sticking)


def _in_own_scales(model: Model, start: Array) -> Model:
    """Return the model with characteristic scales of its states, seen in a short trajectory."""
    if not np.isnan(model.declared_scales()).any() or model.estimated_scales is not None:
        return model
    sizes = np.ones(len(start))
    for _ in range(2):  # what is small beside one shows in a second look only
        pilot = HybridIntegration(model.with_scales(sizes), start)
        pilot.advance(4)  # periods show the scales
        ends = [item.state for item in pilot.recorder.changes]
        reached = np.abs(np.array([*pilot.states, *ends])).max(axis=0)
        sizes = power_of_two(np.where(reached > 0, reached, sizes))
    return model.with_scales(sizes)


def _natural_duration(model: Model, start: Array) -> tuple[float, float]:
    """Return half the period of the fastest vibration in slip, rounded to 1, 2 or 5.

    Beside it: how much faster it is than the slowest.
    """
    trajectory = HybridIntegration(model.replace(**{DURATION.name: 1.0}), start)
    flow = trajectory.flow.of((Status.FORTH,) * len(trajectory.flow.contacts))
    (slopes,) = flow.jacobians(start[None], np.zeros(1), trajectory.constants)
    if not np.isfinite(slopes).all():
        return DURATION.default, 1.0
    values = np.linalg.eigvals(slopes)
    fastest = float(np.abs(values).max())
    if not fastest > 0:
        return DURATION.default, 1.0
    slowest = np.abs(values[values.imag > 0]).min(initial=fastest)
    return rounded_down(math.pi / fastest), fastest / float(slowest)


def unbounded_at(time: float, size: float) -> GuardStop:
    """Return the end of a trajectory that grew to some scales."""
    reason = f"the trajectory grows without bound: after {time:.6g} s it has {size:.0e} scales"
    return GuardStop("unbounded", reason, time)
