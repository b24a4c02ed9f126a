"""A simulated trajectory as data: stroboscopic states, any other instant, its last round."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from slipfold.arrays import Array, Indices, Mask
from slipfold.errors import InputError, unknown
from slipfold.flow.batches import ROUNDING
from slipfold.flow.contact_trajectory import Samples, dense_phases, joined_samples, sample_hybrid
from slipfold.flow.equations import Constants
from slipfold.flow.flow import Flow, flow_of
from slipfold.flow.guarded_flow import GuardStop
from slipfold.flow.hybrid_flow import SmoothPhase
from slipfold.flow.hybrid_trajectory import Interval
from slipfold.flow.modes import Ending, Mode, Status
from slipfold.flow.polynomials import OnsetPolynomials, SlowPolynomials
from slipfold.flow.settlement import Settlement
from slipfold.models.angles import distances
from slipfold.models.model import Model
from slipfold.models.quantities import OutputName
from slipfold.read_only import Documented
from slipfold.text import OneLine, PrintedTable, headed, number_text

FirstPeriod = Annotated[
    int,
    "First forcing period and the one after the last, counted as in a slice: negative numbers "
    "count from the end, None is the end.",
]
LastPeriod = Annotated[int | None, ""]
PerPeriod = Annotated[int, "Samples per forcing period."]
SteadyPeriods = Annotated[
    int,
    "Forcing periods wanted; rounded up to a multiple of the period it converged to, as far as the "
    "run allows.",
]

Measure = Annotated[
    str,
    '``"max"``, ``"min"``, ``"peak_to_peak"`` or ``"modulus"``, the largest absolute value.',
]
LastPeriods = Annotated[int, "Forcing periods at the end; of a cycle, one round stands for all."]

ROUND = 4
"""Intervals of an unforced motion that hold a round of it, as a simulation is drawn."""

MEASURES = ("max", "min", "peak_to_peak", "modulus")
"""What may be taken of an output over a period."""

SAME = 1e-5
"""Distance, over the largest extremum, below which two are one."""


@dataclass(frozen=True, eq=False)
class Sticking(Documented):
    """What the contacts of a trajectory did; frozen."""

    contacts: Annotated[tuple[str, ...], "Their names."]
    modes: Annotated[
        Indices,
        "What each contact does at the start of every forcing period, shape (periods + 1, "
        "n_contacts): 0 sticks, 1 slips, -1 slips backwards, 2 is open.",
    ]
    intervals: Annotated[tuple[Interval, ...], "When each contact stuck, slipped and was open."]

    def mode(self, index: int) -> Mode:
        """Return what all contacts do at the start of a period."""
        return tuple(Status(int(value)) for value in self.modes[index])


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(OneLine, Documented):
    """A trajectory over many forcing periods; frozen.

    Of an autonomous model these are intervals of its ``duration``. It keeps the state at the start
    of every forcing period. What lies between is integrated again
    when requested, so that a long run takes little memory and is known everywhere.
    """

    model: Annotated[Model, "The model with its parameter values."]
    states: Annotated[
        Array,
        "States at phase zero of every forcing period (the stroboscopic Poincare section), from "
        "the initial state on, shape (periods + 1, n_states).",
    ]
    settlement: Annotated[Settlement, "Whether and on what it settled."]
    stopped: Annotated[
        GuardStop | None, "Why and when it ended early; None if it ran to its end."
    ] = None
    sticking: Annotated[
        Sticking | None,
        "What contacts did in a trajectory that sticks; None of one that always slips.",
    ] = None

    def _line(self) -> str:
        ended = self.settlement.message if self.stopped is None else self.stopped.reason
        return f"{type(self).__name__} of {self.model.name}, {self.periods} periods: {ended}"

    def _rows(self) -> PrintedTable:
        last = zip(self.model.states, self.states[-1], strict=True)
        return PrintedTable(
            ["", "last stroboscopic state"],
            [[headed(item), number_text(v, 10)] for item, v in last],
        )

    @property
    def periods(self) -> int:
        """Whole forcing periods there are."""
        return len(self.states) - 1

    @property
    def forcing_period(self) -> float:
        """Forcing period in seconds."""
        return self._constants.period

    @property
    def time(self) -> Array:
        """Times of the stroboscopic states in seconds, shape (periods + 1,)."""
        return np.arange(float(len(self.states))) * self.forcing_period

    @property
    def duration(self) -> float:
        """Seconds from the start to the end."""
        whole = self.periods * self.forcing_period
        return whole if self.stopped is None else max(whole, self.stopped.time)

    def at(self, time: ArrayLike) -> Array:
        """Return the states at any times of the run, exactly: nothing is interpolated.

        Parameters
        ----------
        time
            Seconds from the start, a number or shape (m,), in any order.

        Returns
        -------
        ndarray, shape (n_states,) or (m, n_states)
            States.
        """
        given = np.asarray(time, dtype=float)
        times = np.atleast_1d(given)
        if times.ndim != 1:
            raise InputError(f"time has {times.ndim} dimensions; give a number or one row of them")
        slack = 1e-12 * self.duration
        if not np.all((times >= 0) & (times <= self.duration + slack)):
            worst = times[~((times >= 0) & (times <= self.duration + slack))][0]
            raise InputError(
                f"time = {worst:g} s is outside the run; give 0 to {self.duration:g} s"
            )
        cycles = np.minimum(times, self.duration) / self.forcing_period
        index = np.minimum(np.floor(cycles).astype(int), self.periods)
        states = np.empty((len(times), self.states.shape[1]))
        order = np.lexsort((cycles, index))
        edges = np.flatnonzero(np.diff(index[order])) + 1
        groups = np.split(order, edges) if len(order) else []
        for group in groups:
            states[group] = self._within(int(index[group[0]]), cycles[group])
        return states if given.ndim else states[0]

    def sample(
        self, start: FirstPeriod = 0, stop: LastPeriod = None, per_period: PerPeriod = 64
    ) -> tuple[Array, Array]:
        """Sample the states evenly over whole forcing periods.

        Returns
        -------
        time : ndarray, shape (m,)
            Seconds from the start; the end of the last period is left out.
        states : ndarray, shape (m, n_states)
            States.
        """
        time, samples = self.sampled(start, stop, per_period)
        return time, samples.states

    def sampled(
        self, start: FirstPeriod, stop: LastPeriod, per_period: PerPeriod
    ) -> tuple[Array, Samples]:
        """Return times and samples over whole forcing periods, as `sample` does."""
        first, last, _ = slice(start, stop).indices(self.periods)
        if first >= last:
            raise InputError(
                f"the periods {start} to {stop} are none of the {self.periods} simulated; give "
                f"start < stop within 0 to {self.periods}"
            )
        if per_period < 1:
            raise InputError(f"per_period = {per_period} is less than 1; give 1 or more")
        count, starts = last - first, self.states[first:last]
        time = (first + np.arange(count * per_period) / per_period) * self.forcing_period
        phases = np.arange(per_period) / per_period
        if self.sticking is None:
            zero = np.zeros(count)
            states = self._flow.sample(starts, zero, zero + 1, per_period, self._constants)
            known = states.reshape(-1, starts.shape[1]), np.tile(phases, count)
            return time, Samples(self.model, *known)
        modes = map(self.sticking.mode, range(first, last))
        each = [
            sample_hybrid(self.model, state, mode, phases)
            for state, mode in zip(starts, modes, strict=True)
        ]
        return time, joined_samples(each)

    def output(
        self,
        name: OutputName,
        start: FirstPeriod = 0,
        stop: LastPeriod = None,
        per_period: PerPeriod = 64,
    ) -> tuple[Array, Array]:
        """Sample one output evenly over whole forcing periods.

        Returns
        -------
        time, values : ndarray, shape (m,)
            Seconds from the start, and values in the unit of the output.
        """
        column = self._flow.output_index(name)
        time, samples = self.sampled(start, stop, per_period)
        return time, samples.outputs()[:, column]

    def steady(
        self, periods: SteadyPeriods = 64, per_period: PerPeriod = 64
    ) -> tuple[Array, Array]:
        """Sample the end of the run, over a whole number of response periods.

        Of a cycle, which takes no whole number of intervals, rounds from the last state on.

        Returns
        -------
        time : ndarray, shape (m,)
            Seconds from the start of the run.
        states : ndarray, shape (m, n_states)
            States.

        Raises
        ------
        InputError
            If the run is shorter than one response period.
        """
        time, samples = self._sampled_steadily(periods, per_period)
        return time, samples.states

    def _sampled_steadily(self, periods: int, per_period: int) -> tuple[Array, Samples]:
        count, duration = self.steady_periods(periods), self.settlement.duration
        if duration is None:
            return self.sampled(self.periods - count, None, per_period)
        model, start = self.steady_model, self.states[-1]
        phases = np.arange(count * per_period) / per_period
        time = self.duration + phases * duration
        if self.sticking is not None:
            return time, sample_hybrid(model, start, self.sticking.mode(-1), phases)
        states = self._flow.trajectory(start, self._flow.constants_of(model), phases)
        return time, Samples(model, states, phases)

    def steady_outputs(self, periods: SteadyPeriods = 64, per_period: PerPeriod = 64) -> Array:
        """Sample all outputs as `steady` does the states.

        Returns
        -------
        ndarray, shape (m, n_outputs)
            Outputs, the states first.
        """
        return self._sampled_steadily(periods, per_period)[1].outputs()

    def extrema(
        self, name: OutputName, measure: Measure = "max", periods: LastPeriods = 16
    ) -> Array:
        """Return the extrema of an output in the last periods, each once, in rising order.

        They are vertices of parabolas through samples, one of each forcing period. Of an unforced
        motion they are those of each four intervals that have theirs inside, not on a border; if
        none has both its largest and its smallest value inside, the one extremum of all values.

        Returns
        -------
        ndarray, shape (m,)
            Extrema in the unit of the output.

        Raises
        ------
        InputError
            If `periods` is less than 1, or the run too short to hold an extremum.
        """
        if measure not in MEASURES:
            raise unknown("an output has no", measure, MEASURES)
        settled, forced = self.settlement.settled, self.model.forced
        intervals = 1 if forced else ROUND
        # One more: the extremum of a period may lie between its last sample and the next.
        self._refuse_fewer(periods, intervals + 1)
        if settled:  # its own round says all
            count = self.steady_periods(1)
            samples = self.steady_outputs(count, 64 * intervals)[:, self._flow.output_index(name)]
        else:
            samples = self.output(name, -max(periods, intervals) - 1)[1]
        found, both = (
            reached(samples, 64 * intervals, item, settled, forced)
            for item in (measure, "peak_to_peak")
        )
        if not np.isfinite(both).any():  # of all measures alike
            samples = np.pad(samples, 2, mode="edge")
            found = reached(samples, len(samples) - 4, measure, False, forced)
        values = np.sort(found[np.isfinite(found)])
        apart = np.diff(values, prepend=-np.inf) > SAME * np.abs(values).max(initial=0.0)
        return np.asarray(values[apart])

    @property
    def steady_model(self) -> Model:
        """The model, of a cycle with its ``duration``."""
        duration = self.settlement.duration
        return self.model if duration is None else self.model.replace(duration=duration)

    def steady_periods(self, periods: SteadyPeriods = 64) -> int:
        """Return how many forcing periods at the end are a whole number of response periods.

        Raises
        ------
        InputError
            If `periods` is less than 1 or the run is shorter than one response period.
        """
        response = self.settlement.period or 1
        self._refuse_fewer(periods, response)
        if self.settlement.duration is not None:
            return periods
        return min(-(-periods // response), self.periods // response) * response

    def _refuse_fewer(self, periods: int, needed: int) -> None:
        """Refuse no periods, and a run of fewer than are needed unless it is a cycle."""
        if periods < 1:
            raise InputError(f"periods = {periods} is less than 1; give 1 or more")
        if self.settlement.duration is None and self.periods < needed:
            whole = "forcing periods" if self.model.forced else "intervals of its duration"
            raise InputError(
                f"the run has {self.periods} whole {whole}, fewer than {needed}; simulate longer"
            )

    def _within(self, index: int, cycles: Array) -> Array:
        """Integrate one forcing period again, to increasing times within it."""
        phases, inverse = np.unique(np.maximum(cycles - index, 0.0), return_inverse=True)
        grid = phases if phases[0] == 0 else np.concatenate([[0.0], phases])
        if len(grid) == 1:
            return np.repeat(self.states[index][None], len(cycles), axis=0)
        if self.sticking is not None:
            mode = self.sticking.mode(index)
            return sample_hybrid(self.model, self.states[index], mode, phases).states[inverse]
        states = self._flow.trajectory(self.states[index], self._constants, grid)
        return states[len(grid) - len(phases) :][inverse]

    @property
    def _flow(self) -> Flow:
        return flow_of(self.model)

    @cached_property
    def _constants(self) -> Constants:
        return self._flow.constants_of(self.model)


@dataclass(frozen=True)
class StickTime(Documented):
    """A time in which a contact sticks; frozen."""

    contact: Annotated[str, "Its name."]
    begin: Annotated[
        float,
        "From the start of the round, in forcing periods; of an autonomous model in s. Where a "
        "round repeats itself, a time that runs over its end ends beyond it.",
    ]
    end: Annotated[float, ""]


@dataclass(frozen=True, eq=False)
class LastRound(Documented):
    """The last complete round of a trajectory: a response or a cycle."""

    minimum: Annotated[
        Array,
        "Smallest and largest value of each state, shape (n_states,); NaN if it is not complete.",
    ]
    maximum: Annotated[Array, ""]
    sticking: Annotated[tuple[StickTime, ...], "When contacts stick."] = ()
    fraction: Annotated[float, "Fraction of the time in which any contact sticks."] = 0.0
    stuck: Annotated[bool, "Whether all contacts stick all the time."] = False


def last_periods(trajectory: Trajectory) -> int:
    """Return how long the last response is, or else a forcing period or 16 intervals at the end."""
    unsettled = 1 if trajectory.model.forced else min(16, trajectory.periods)
    return trajectory.settlement.period or unsettled


def last_round(trajectory: Trajectory) -> LastRound | None:
    """Return what the last whole round of a trajectory shows; None if there is none.

    That is one more round of a cycle, or else as long as `last_periods`.
    """
    settlement, model, count = trajectory.settlement, trajectory.model, last_periods(trajectory)
    if not 1 <= count <= trajectory.periods:
        return None
    if settlement.duration is not None:
        model, index, count = trajectory.steady_model, trajectory.periods, 1
    else:
        index = trajectory.periods - count
    state, flow = trajectory.states[index], flow_of(model)
    constants = flow.constants_of(model)
    if trajectory.sticking is None:
        dense = flow.dense(state, constants, float(count), 100_000)
        return None if dense is None else LastRound(*_extrema([dense.polynomials], dense.scales))
    mode, names = trajectory.sticking.mode(index), trajectory.sticking.contacts
    result = round_with_stick(model, state, mode, names, count, settlement.settled)
    return None if np.isnan(result.fraction) else result


def round_with_stick(
    model: Model, state: Array, mode: Mode, contacts: Sequence[str], count: int, repeats: bool
) -> LastRound:
    """Return what a trajectory with stick and slip shows from phase zero to another.

    Of one that stops on the way nothing is known: NaN. Shapes: state (n,).
    """
    parts = list(dense_phases(model, state, mode, float(count)))
    if not _goes_round(model, state, parts, count):
        unknown = np.full(len(state), np.nan)
        return LastRound(unknown, unknown, fraction=np.nan)
    constants = flow_of(model).constants_of(model)
    known = [part.polynomials for part in parts if part.polynomials is not None]
    unit = 1.0 if model.forced else constants.period
    times = []
    for contact, name in enumerate(contacts):
        spans = _joined([(part.begin, part.end) for part in parts if part.mode[contact] is STICK])
        joins = repeats and len(spans) > 1
        if joins and (spans[0][0], spans[-1][1]) == (0.0, float(count)):  # they are one stick
            first, *spans = spans
            spans[-1] = (spans[-1][0], count + first[1])
        times += [StickTime(name, begin * unit, end * unit) for begin, end in spans]
    stuck = sum(part.end - part.begin for part in parts if STICK in part.mode)
    whole = all(status is STICK for part in parts for status in part.mode)
    return LastRound(*_extrema(known, constants.scales), tuple(times), stuck / count, whole)


STICK = Status.STICK


def _goes_round(model: Model, state: Array, parts: Sequence[SmoothPhase], count: int) -> bool:
    """Whether a round is complete; one that continues from rest at a grazing must also close."""
    if not parts or parts[-1].end < count - 1e-9:  # an event may end it
        return False
    if not any(part.ended_by(Ending.STIFF) for part in parts):
        return True
    # A contact that is caught misses by far.
    return bool(distances(model, parts[-1].state, state) < 1e-5)


def _extrema(polynomials: Iterable[Any], scales: Array) -> tuple[Array, Array]:
    """Return the extrema of Taylor polynomials, wherever in their steps they lie."""
    n = len(scales)
    minimum, maximum = np.full(n, np.inf), np.full(n, -np.inf)
    for output in polynomials:
        known, values = [*range(n)], list[tuple[int, Array]]()
        if isinstance(output, OnsetPolynomials):
            output = output.inner
        if isinstance(output, SlowPolynomials):
            known = [index for index in known if index not in output.held]
            spread = output.nodes(np.linspace(0.0, 1.0, 64), _may_be_extreme(output))[0]
            values += [(index, _peaks(spread[:, :, index])) for index in output.held]
            output = output.inner
        orders = np.arange(output.tcs.shape[2])
        scaled = output.tcs[:, :n] * np.diff(output.times)[:, None, None] ** orders
        ends = np.stack([scaled[:, :, 0], scaled.sum(axis=2)])
        minimum[known] = np.minimum(minimum, ends.min(axis=(0, 1), initial=np.inf))[known]
        maximum[known] = np.maximum(maximum, ends.max(axis=(0, 1), initial=-np.inf))[known]
        # Only steps whose coefficients allow it are examined.
        reach = np.abs(scaled[:, :, 1:]).sum(axis=2)
        beyond = (scaled[:, :, 0] + reach > maximum) | (scaled[:, :, 0] - reach < minimum)
        places = [place for place in np.argwhere(beyond).tolist() if place[1] in known]
        values += [(index, _turning_values(scaled[step, index])) for step, index in places]
        for index, some in values:
            minimum[index] = min(minimum[index], some.min())
            maximum[index] = max(maximum[index], some.max())
    return minimum * scales, maximum * scales


def _may_be_extreme(slow: SlowPolynomials) -> Mask:
    """Whether held states may be extreme within a step, judged by five places of each."""
    few = slow.nodes(np.linspace(0.0, 1.0, 5))[0][:, :, list(slow.held)]
    low, high = few.min(axis=1), few.max(axis=1)
    inside = (2 * high - low < high.max(axis=0)) & (2 * low - high > low.min(axis=0))
    return np.asarray(~inside.all(axis=1))


def _peaks(values: Array) -> Array:
    """Return samples, and the vertices of parabolas where they turn. Shapes: values (m, p)."""
    before, middle, after = values[:, :-2], values[:, 1:-1], values[:, 2:]
    turns = (middle - before) * (after - middle) < 0
    bend = (after - 2 * middle + before)[turns]
    vertices = middle[turns] - (after - before)[turns] ** 2 / (8 * bend)
    return np.concatenate([values.ravel(), vertices])


def _turning_values(coefficients: Array) -> Array:
    """Return the values of a polynomial at the ends of [0, 1] and where it turns between them."""
    ends = np.array([coefficients[0], coefficients.sum()])
    slopes = coefficients[1:] * np.arange(1, len(coefficients))
    size = np.abs(slopes).max()
    if not abs(slopes[0]) <= np.abs(slopes[1:]).sum():  # the slope keeps its sign
        return ends
    slopes = np.trim_zeros(np.where(np.abs(slopes) < 1e-16 * size, 0.0, slopes), "b")
    if len(slopes) < 2:
        return ends
    roots = np.polynomial.polynomial.polyroots(slopes)
    real = roots.real[
        (np.abs(roots.imag) < 1e-6) & (roots.real > -ROUNDING) & (roots.real < 1 + ROUNDING)
    ]
    values = np.polynomial.polynomial.polyval(np.clip(real, 0.0, 1.0), coefficients)
    return np.concatenate([ends, values])


def _joined(spans: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Join spans that follow each other at once, and leave out those without length."""
    result: list[tuple[float, float]] = []
    for begin, end in spans:
        if end == begin:
            continue
        if result and result[-1][1] == begin:
            result[-1] = (result[-1][0], end)
        else:
            result.append((begin, end))
    return result


def reached(samples: Array, width: int, measure: str, closed: bool, forced: bool) -> Array:
    """Return the extremum of an output in each window of samples.

    Windows of an unforced motion begin anywhere: NaN where it is greater just outside of one.
    Shapes: samples (n,), of which two precede the first window and two follow the last, unless
    they close; returns (m,).
    """
    if closed:
        samples = np.pad(samples, 2, mode="wrap")
    begins = np.arange(2, len(samples) - width - 1, width)
    rows = samples[np.add.outer(begins, np.arange(-2, width + 2))]
    high, low, far = _peak(rows, forced), -_peak(-rows, forced), _peak(np.abs(rows), forced)
    return {"max": high, "min": low, "peak_to_peak": high - low, "modulus": far}[measure]


def _peak(values: Array, borders: bool) -> Array:
    """Return the largest value between two at either end; NaN at a border, unless borders count."""
    rows, index = np.arange(len(values)), values[:, 2:-2].argmax(axis=1) + 2
    first, before, here, after, last = (values[rows, index + shift] for shift in range(-2, 3))
    bend, turns = before - 2 * here + after, (before <= here) & (here >= after)
    # What is concave lies below its chords extended; the parabola beside a jump does not.
    most = np.maximum(_crossing(after, here, before, first), _crossing(before, here, after, last))
    with np.errstate(divide="ignore", invalid="ignore"):
        top = np.minimum(here - (after - before) ** 2 / (8 * bend), most)
    top = np.where(turns & (top > here), top, here)
    return np.where(turns | borders, top, np.nan)


def _crossing(before: Array, here: Array, after: Array, last: Array) -> Array:
    """Return the height between the middle two of four samples at which their chords cross."""
    rise, fall = here - before, last - after
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.clip((after - fall - here) / (rise - fall), 0.0, 1.0)
        return np.asarray(here + np.where(rise > fall, part, 0.0) * rise)
