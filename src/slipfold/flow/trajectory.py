"""A simulated motion as data: strobe states, and any other instant on demand."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.equations import Constants
from slipfold.flow.flow import Flow, flow_of
from slipfold.flow.guarded_flow import Stop
from slipfold.flow.settling.settlement import Settlement
from slipfold.flow.switched.history import Interval
from slipfold.flow.switched.mode import Mode, Status
from slipfold.flow.switched.sampled import Samples, sample_switched
from slipfold.models.model import Model
from slipfold.text.one_line import OneLine, headed, number_text
from slipfold.text.printed_table import PrintedTable


@dataclass(frozen=True, eq=False)
class Sticking:
    """What the contacts of a motion did; frozen.

    Parameters
    ----------
    contacts
        Their names.
    modes
        What each contact does at the start of every forcing period, shape (periods + 1,
        n_contacts): 0 sticks, 1 slips, -1 slips backwards, 2 is open.
    intervals
        When each contact stuck, slipped and was open.
    """

    contacts: tuple[str, ...]
    modes: NDArray[np.int64]
    intervals: tuple[Interval, ...]

    def mode(self, index: int) -> Mode:
        """Return what all contacts do at the start of a period."""
        return tuple(Status(int(value)) for value in self.modes[index])


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(OneLine):
    """A motion over many forcing periods; frozen.

    Of an autonomous model these are intervals of its ``duration``. It keeps the state at the start
    of every forcing period. What lies between is integrated again
    when asked for, so that a long run takes little memory and is known everywhere.

    Parameters
    ----------
    model
        The model with its parameter values.
    strobe
        States at phase zero of every forcing period (the stroboscopic Poincare section), from the
        initial state on, shape (periods + 1, n_states).
    settlement
        Whether and on what it settled.
    stopped
        Why and when it ended early; None if it ran to its end.
    sticking
        What contacts did in a motion that sticks; None of one that always slips.

    Examples
    --------
    >>> from slipfold.flow import simulate
    >>> from slipfold.models import SlidingOscillator
    >>> trajectory = simulate(SlidingOscillator(f=12.2, Nd=0.15), periods=1000)
    >>> trajectory.settlement.period
    2
    >>> trajectory.at([0.0, 1.0, 2.0]).shape
    (3, 4)
    """

    model: Model
    strobe: Array
    settlement: Settlement
    stopped: Stop | None = None
    sticking: Sticking | None = None

    def _line(self) -> str:
        ended = self.settlement.message if self.stopped is None else self.stopped.reason
        return f"{type(self).__name__} of {self.model.name}, {self.periods} periods: {ended}"

    def _rows(self) -> PrintedTable:
        last = zip(self.model.states, self.strobe[-1], strict=True)
        return PrintedTable(
            ["", "last strobe state"], [[headed(item), number_text(v, 10)] for item, v in last]
        )

    @property
    def periods(self) -> int:
        """Whole forcing periods there are."""
        return len(self.strobe) - 1

    @property
    def forcing_period(self) -> float:
        """Forcing period in seconds."""
        return self._constants.period

    @property
    def time(self) -> Array:
        """Times of the strobe states in seconds, shape (periods + 1,)."""
        return np.arange(float(len(self.strobe))) * self.forcing_period

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

        Raises
        ------
        InputError
            If a time lies outside the run.
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
        states = np.empty((len(times), self.strobe.shape[1]))
        order = np.lexsort((cycles, index))
        edges = np.flatnonzero(np.diff(index[order])) + 1
        groups = np.split(order, edges) if len(order) else []
        for group in groups:
            states[group] = self._within(int(index[group[0]]), cycles[group])
        return states if given.ndim else states[0]

    def sample(
        self, start: int = 0, stop: int | None = None, per_period: int = 64
    ) -> tuple[Array, Array]:
        """Sample the states evenly over whole forcing periods.

        Parameters
        ----------
        start, stop
            First forcing period and the one after the last, counted as in a slice: negative numbers
            count from the end, None is the end.
        per_period
            Samples per forcing period.

        Returns
        -------
        time : ndarray, shape (m,)
            Seconds from the start; the end of the last period is left out.
        states : ndarray, shape (m, n_states)
            States.

        Raises
        ------
        InputError
            If there is no such period, or `per_period` is less than 1.
        """
        first, last, _ = slice(start, stop).indices(self.periods)
        if first >= last:
            raise InputError(
                f"the periods {start} to {stop} are none of the {self.periods} simulated; give "
                f"start < stop within 0 to {self.periods}"
            )
        if per_period < 1:
            raise InputError(f"per_period = {per_period} is less than 1; give 1 or more")
        count = last - first
        ticks = np.arange(count * per_period) / per_period
        time = (first + ticks) * self.forcing_period
        if self.sticking is not None:
            return time, np.concatenate(
                [item.states for item in self._each(first, last, per_period)]
            )
        states = self._flow.sample(
            self.strobe[first:last], np.zeros(count), np.ones(count), per_period, self._constants
        )
        return time, states.reshape(len(ticks), -1)

    def _each(self, first: int, last: int, per_period: int) -> Iterator[Samples]:
        """Sample forcing periods of a motion that sticks, one after the other."""
        assert self.sticking is not None
        phases = np.arange(per_period) / per_period
        for index in range(first, last):
            mode = self.sticking.mode(index)
            yield sample_switched(self.model, self.strobe[index], mode, phases)

    def output(
        self, name: str, start: int = 0, stop: int | None = None, per_period: int = 64
    ) -> tuple[Array, Array]:
        """Sample one output evenly over whole forcing periods.

        Parameters
        ----------
        name
            A state or output of the model.
        start, stop
            First forcing period and the one after the last, as in `sample`.
        per_period
            Samples per forcing period.

        Returns
        -------
        time, values : ndarray, shape (m,)
            Seconds from the start, and values in the unit of the output.

        Raises
        ------
        InputError
            If there is no such output or no such period.
        """
        column = self._flow.output_index(name)
        time, states = self.sample(start, stop, per_period)
        if self.sticking is not None:
            first, last, _ = slice(start, stop).indices(self.periods)
            each = self._each(first, last, per_period)
            return time, np.concatenate([item.outputs()[:, column] for item in each])
        phases = np.arange(len(time)) % per_period / per_period
        return time, self._flow.outputs(states, phases, self._constants)[:, column]

    def steady(self, periods: int = 64, per_period: int = 64) -> tuple[Array, Array]:
        """Sample the end of the run, over a whole number of response periods.

        Of a cycle, which takes no whole number of intervals, rounds from the last state on.

        Parameters
        ----------
        periods
            Forcing periods wanted; rounded up to a multiple of the period it settled on, as far as
            the run allows.
        per_period
            Samples per forcing period.

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
        count = self.steady_periods(periods)
        if self.settlement.duration is None:
            return self.sample(self.periods - count, None, per_period)
        ticks = np.arange(count * per_period + 1) / per_period
        time = self.duration + ticks[:-1] * self.settlement.duration
        if self.sticking is not None:
            return time, self._rounds(count, per_period).states
        constants = self._flow.constants_of(self.steady_model)
        states = self._flow.trajectory(self.strobe[-1], constants, ticks)
        return time, states[:-1]

    def _rounds(self, count: int, per_period: int) -> Samples:
        """Sample rounds of the cycle that a motion with stick settled on."""
        assert self.sticking is not None
        phases = np.arange(count * per_period) / per_period
        return sample_switched(self.steady_model, self.strobe[-1], self.sticking.mode(-1), phases)

    def steady_outputs(self, periods: int = 64, per_period: int = 64) -> Array:
        """Sample all outputs as `steady` does the states.

        Parameters
        ----------
        periods
            Forcing periods wanted.
        per_period
            Samples per forcing period.

        Returns
        -------
        ndarray, shape (m, n_outputs)
            Outputs, the states first.

        Raises
        ------
        InputError
            If the run is shorter than one response period.
        """
        count = self.steady_periods(periods)
        if self.sticking is None:
            states = self.steady(periods, per_period)[1]
            phases = np.arange(len(states)) % per_period / per_period
            constants = self._flow.constants_of(self.steady_model)
            return self._flow.outputs(states, phases, constants)
        if self.settlement.duration is not None:
            return self._rounds(count, per_period).outputs()
        each = self._each(self.periods - count, self.periods, per_period)
        return np.concatenate([item.outputs() for item in each])

    @property
    def steady_model(self) -> Model:
        """The model, of a cycle with its ``duration``."""
        duration = self.settlement.duration
        return self.model if duration is None else self.model.replace(duration=duration)

    def steady_periods(self, periods: int = 64) -> int:
        """Return how many forcing periods at the end are a whole number of response periods.

        Parameters
        ----------
        periods
            Forcing periods wanted.

        Raises
        ------
        InputError
            If `periods` is less than 1 or the run is shorter than one response period.
        """
        if periods < 1:
            raise InputError(f"periods = {periods} is less than 1; give 1 or more")
        if self.settlement.duration is not None:
            return periods
        response = self.settlement.period or 1
        count = min(-(-periods // response), self.periods // response) * response
        if count == 0:
            raise InputError(
                f"the run has {self.periods} whole forcing periods, fewer than one response; "
                "simulate longer"
            )
        return count

    def _within(self, index: int, cycles: Array) -> Array:
        """Integrate one forcing period again, to increasing times within it."""
        phases, inverse = np.unique(np.maximum(cycles - index, 0.0), return_inverse=True)
        grid = phases if phases[0] == 0 else np.concatenate([[0.0], phases])
        if len(grid) == 1:
            return np.repeat(self.strobe[index][None], len(cycles), axis=0)
        if self.sticking is not None:
            mode = self.sticking.mode(index)
            return sample_switched(self.model, self.strobe[index], mode, phases).states[inverse]
        states = self._flow.trajectory(self.strobe[index], self._constants, grid)
        return states[len(grid) - len(phases) :][inverse]

    @property
    def _flow(self) -> Flow:
        return flow_of(self.model)

    @cached_property
    def _constants(self) -> Constants:
        return self._flow.constants_of(self.model)
