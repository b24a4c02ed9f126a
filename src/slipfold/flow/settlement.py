"""Whether a trajectory has converged to a response, a cycle or an equilibrium.

It has converged if a sequence of its states repeats: the states at the start of forcing periods,
those at which an autonomous trajectory returns to a plane, or those at which contacts change. A
`Trend` holds the change over a period and its rate of decrease, which give the distance to the
limit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, reduce
from itertools import chain, pairwise

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.batches import ROUNDING
from slipfold.flow.equations import Constants
from slipfold.flow.equilibrium import Equilibrium, equilibrium_near
from slipfold.flow.flow import Flow, flow_of
from slipfold.flow.hybrid_trajectory import ModeChange
from slipfold.flow.implicit_steps import StiffFallback
from slipfold.flow.polynomials import DenseTrajectory
from slipfold.models.angles import NO_ANGLES, distances, wrap_angles
from slipfold.models.model import Model
from slipfold.text import number_text


class CONVERGENCE:
    """When a trajectory has converged."""

    max_period: int = 8  # of a response, in forcing periods
    few: int = 16  # number of periods up to which nothing is concluded
    short: int = 200  # number of periods below which a transient may be a torus
    # Maximum ratio of the changes in successive windows that decrease; its inverse is the minimum
    # of those that grow
    trend: float = 0.9
    max_changes: int = 64  # changes of contacts in a cycle
    rounds: int = 4  # rounds of a cycle that must repeat each other
    # Steps at the end of a trajectory in which returns are searched: a smooth cycle takes fifty
    # steps, one with jumps a thousand
    steps: tuple[int, ...] = (4_000, 16_000, 64_000)
    stiff_intervals: int = 100  # intervals before the end at which the search for stiffness begins
    stiff_trials: int = 10  # successive intervals that are tried
    stiff_steps: int = 500  # maximum number of explicit steps of each
    near: float = 0.3  # distance of a crossing from the plane's origin, over the extent
    enough: int = 60  # returns that suffice for a trend
    fewest: int = 40  # minimum number of states that show an approach to an equilibrium
    neutral: float = 1e-5  # distance of a multiplier from one: those of a center are known to 1e-6


@dataclass(frozen=True, repr=False)
class Settlement:
    """Whether a trajectory has converged, and how that was judged.

    Parameters
    ----------
    settled
        Whether it is within the tolerance of a periodic response.
    period
        Period of that response in forcing periods, 1 to 8; 1 on a cycle or an equilibrium; None if
        not settled.
    drift
        Largest change of a stroboscopic state from one response period to the next at the end, in
        scaled states; with respect to one forcing period if it neither settled nor approaches
        anything.
    rate
        Factor by which the drift changes in one forcing period; None where it is too small or the
        run too short to measure it.
    message
        A sentence for the user.
    duration
        Seconds that one round of a cycle takes; None if it converged to none.
    kind
        ``"response"`` of a forced model, ``"cycle"`` or ``"equilibrium"`` of an autonomous one;
        None if not settled.
    revolutions
        Full revolutions of each angle in that response, by name; empty if not settled.
    more
        Time that is still needed, in forcing periods (autonomous: in seconds); None if unknown.
    neutral_round
        Seconds of a round that repeats though nothing attracts to it, as round a center, or None.
    """

    settled: bool
    period: int | None
    drift: float
    rate: float | None
    message: str
    duration: float | None = None
    kind: str | None = None
    revolutions: Mapping[str, int] = field(default_factory=dict)
    more: float | None = None
    neutral_round: float | None = None

    def __repr__(self) -> str:
        """One line: on what, if on anything, and how nearly."""
        if self.kind == "cycle":
            on = f"a cycle of {number_text(self.duration)} s"
        elif self.kind == "equilibrium":
            on = "an equilibrium"
        else:
            on = f"period {self.period}"
        result = f"settled on {on}" if self.settled else "not settled"
        return f"<Settlement: {result}, drift {self.drift:.1e}>"

    def __str__(self) -> str:
        """Return the sentence."""
        return self.message


def not_converged(
    message: str, drift: float = math.nan, rate: float | None = None, more: float | None = None
) -> Settlement:
    """Return that a trajectory has not converged, and why."""
    return Settlement(False, None, drift, rate, message, more=more)


@dataclass(frozen=True)
class Trend:
    """The change of a state until the k-th after it, at the end and in three windows before."""

    period: int  # the number k
    drift: float  # largest change near the end
    windows: tuple[float, float, float]  # largest change in three successive windows
    width: int  # states in a window

    @property
    def rate(self) -> float | None:
        """Factor by which the changes shrink from state to state; None among rounding errors."""
        first, _, last = self.windows
        if min(first, last) <= ROUNDING:
            return None
        return float((last / first) ** (1 / (2 * self.width)))

    @property
    def growing(self) -> bool:
        """Whether it grows steadily: an unstable orbit is left."""
        first, middle, last = self.windows
        # Among rounding errors, a tenfold growth is needed to be believed.
        minimum = 2.0 if last > ROUNDING else 10.0
        steady = first < CONVERGENCE.trend * middle < CONVERGENCE.trend**2 * last
        return steady and last > minimum * first and last > 1e-2 * ROUNDING

    @property
    def shrinking(self) -> bool:
        """Whether it shrinks steadily."""
        first, middle, last = self.windows
        # Maxima of a few changes scatter, so a short run must show more of a trend.
        maximum = 1.0 if 8 * self.width >= CONVERGENCE.short else 1 / 3
        return (
            last < CONVERGENCE.trend * middle < CONVERGENCE.trend**2 * first
            and last < maximum * first
        )

    @property
    def distance(self) -> float:
        """Distance left to the periodic response: the sum of the changes still to come."""
        if self.drift <= ROUNDING and not self.growing:
            return self.drift
        rate = self.rate
        if rate is None or rate >= 1 or self.growing:
            return math.inf
        factor = rate**self.period
        return self.drift * factor / (1 - factor)

    def more(self, tolerance: float) -> float | None:
        """Return how many states more bring it within a tolerance; None if it does not shrink."""
        rate = self.rate
        if not self.shrinking or rate is None or not self.distance < math.inf:
            return None
        return float(math.ceil(math.log(tolerance / self.distance) / math.log(rate)))


def trends_of(scaled: Array, angle_periods: Array = NO_ANGLES) -> list[Trend]:
    """Return the trends over 1 to 8 states, revolutions left out. Shapes: scaled (m, n)."""
    return [
        _measure(scaled, angle_periods, period) for period in range(1, CONVERGENCE.max_period + 1)
    ]


def judge_settlement(
    states: Array, scales: Array, tolerance: float, angle_periods: Array = NO_ANGLES
) -> Settlement:
    """Judge from the states at phase zero whether a trajectory has converged.

    Shapes: states (m, n); scales (n,); angle_periods (n,), of angles.

    The drift ``d_k`` is the largest change over k periods near the end. It shrinks by a factor
    ``r`` a period, measured over the last three eighths of the run, so the response is still
    ``d_k r^k / (1 - r^k)`` away. A small drift that hardly shrinks is thus not taken for a settled
    response.
    """
    if len(states) <= CONVERGENCE.few:
        count = len(states) - 1
        return not_converged(
            f"not settled: {count} forcing periods are too few to decide; "
            f"simulate {5 * CONVERGENCE.short}"
        )
    trends = trends_of(states / scales, angle_periods / scales)
    for trend in trends:
        if trend.distance <= tolerance:
            return _settled(_shortest(trends, trend, tolerance))
    return _unsettled(trends, len(states) - 1, tolerance)


def _measure(scaled: Array, angle_periods: Array, period: int) -> Trend:
    change = np.abs(wrap_angles(scaled[period:] - scaled[:-period], angle_periods)).max(axis=1)
    width = max(min(len(scaled) // 8, len(change) // 3), 1)
    windows = tuple(
        float(change[len(change) - (i + 1) * width : len(change) - i * width].max())
        for i in (2, 1, 0)
    )
    drift = float(change[-min(width, CONVERGENCE.max_period) :].max())
    return Trend(period, drift, (windows[0], windows[1], windows[2]), width)


def _shortest(trends: list[Trend], settled: Trend, tolerance: float) -> Trend:
    """Return the trend of the shortest period that divides the settled one and also repeats.

    With a multiplier near -1 a trajectory alternates while it converges to period 1. The states of
    a period may then differ by twice the tolerance, after the decay of one more period.
    """
    fading = min(settled.rate or 1.0, 1.0) ** settled.period
    parts = (trend for trend in trends if settled.period % trend.period == 0)
    return next(part for part in parts if part is settled or part.drift * fading <= 2 * tolerance)


def _settled(trend: Trend) -> Settlement:
    plural = "" if trend.period == 1 else "s"
    message = f"settled on a response of {trend.period} forcing period{plural}; {_repeats(trend)}"
    return Settlement(True, trend.period, trend.drift, trend.rate, message, kind="response")


def _repeats(trend: Trend) -> str:
    return f"it repeats within {max(trend.drift, 1e-16):.1e}"


def _unsettled(trends: list[Trend], periods: int, tolerance: float) -> Settlement:
    start = f"not settled after {periods} forcing periods: "
    for trend in trends:
        rate, more = trend.rate, trend.more(tolerance)
        if rate is not None and more is not None:
            over = "a period" if trend.period == 1 else f"{trend.period} periods"
            return not_converged(
                f"{start}the state still changes by {trend.drift:.1e} over {over}, shrinking by "
                f"the factor {rate:.6g} a period; about {more:.0f} more periods are needed",
                trend.drift,
                rate,
                more,
            )
    first = trends[0]
    if first.growing:
        return not_converged(
            f"{start}it is leaving an unstable response, the change from period to period "
            f"({first.drift:.1e}) grows; simulate longer",
            first.drift,
            first.rate,
        )
    return not_converged(
        f"{start}the state changes by {first.drift:.1e} from period to period and this does not "
        f"shrink; {_advice(trends, periods)}",
        first.drift,
        first.rate,
    )


def _advice(trends: list[Trend], periods: int) -> str:
    if periods < CONVERGENCE.short:
        advice = 5 * CONVERGENCE.short
        return f"so short a run cannot distinguish a transient from a torus: simulate {advice}"
    # What moves on steadily is eight times as far after eight periods.
    moves_on = trends[-1].drift > trends[-1].period / 2 * trends[0].drift
    angle = "an angle that revolves and is not declared, " * moves_on
    return (
        f"{angle}a torus, chaos, a period above 8, or a very slow transient: look at the "
        f"stroboscopic states, or simulate {10 * periods}"
    )


def judge_changes(
    model: Model, changes: Sequence[ModeChange], tolerance: float, time: float
) -> Settlement:
    """Judge from the last changes of contacts whether an autonomous trajectory repeats itself.

    The last rounds of a cycle must have the same modes in the same order.
    """
    trends = list[Trend]()
    for length in range(1, min(CONVERGENCE.max_changes, len(changes) // CONVERGENCE.rounds) + 1):
        last = changes[-CONVERGENCE.rounds * length :]
        if any(last[i].mode != last[i + length].mode for i in range(len(last) - length)):
            continue
        states = np.array([change.state for change in last])
        apart = distances(model, states[length:], states[:-length])
        apart = apart.reshape(CONVERGENCE.rounds - 1, -1)
        first, middle, drift = apart.max(axis=1).tolist()
        trends.append(Trend(length, drift, (first, middle, drift), length))
        if not (drift <= tolerance and trends[-1].distance <= tolerance):
            continue
        trend = _shortest(trends, trends[-1], tolerance)
        duration = (last[-1].time - last[-1 - trend.period].time) * model.values["duration"]
        message = f"settled on {_cycle_text(duration)} with stick and slip; {_repeats(trend)}"
        rate = None if trend.rate is None else drift / first
        return Settlement(True, 1, drift, rate, message, duration=duration, kind="cycle")
    message = f"not settled after {time:.6g} s: stick and slip do not repeat yet; simulate longer"
    return not_converged(message)


def _cycle_text(duration: float) -> str:
    return f"a cycle of {duration:.9g} s ({1 / duration:.6g} Hz)"


def judge_autonomous(
    model: Model, states: Array, tolerance: float, held: Flow | None = None, kept: int = 0
) -> Settlement:
    """Judge from the end of a trajectory whether it has converged.

    It has converged to an equilibrium if it is near one that attracts. It has converged to a cycle
    if its returns to a plane repeat and the cycle attracts. Around a center all rounds repeat, but
    the trajectory has converged to none of them. `held` is the flow of a mode in which contacts
    stick or are open, which keeps some sums of states: equilibria of the model are others.

    Shapes: states (m, n).

    >>> from slipfold.flow.simulate import simulate
    >>> from slipfold.models.registry import model_named
    >>> round(simulate(model_named("vanderpol-free")).settlement.duration, 8)
    6.66328686
    """
    rest = equilibrium_near(model, states[-1]) if held is None else None
    if rest is not None and rest.distance <= tolerance:
        return _at_rest(rest)
    end = _End(model, states, held or flow_of(model), kept)
    returns, seen = None, 0.0
    for window in chain(
        map(end.window, CONVERGENCE.steps), map(end.stiff_window, CONVERGENCE.steps[:1])
    ):
        if window is None:
            break
        seen = window.end * end.unit
        returns = end.returns(window)
        trends = end.trends(returns.states)
        for trend in trends:
            if trend.drift <= tolerance:
                shortest = _shortest(trends, trend, tolerance)
                result = _on_cycle(end, window, returns.phases, shortest, tolerance)
                if result is not None:
                    return result
        if len(returns.phases) >= CONVERGENCE.enough or window.end >= len(states) - 1:
            break
    return _unsettled_autonomous(end, returns, seen, rest, tolerance)


@dataclass(frozen=True, eq=False)
class _Returns:
    """Where a trajectory crosses a plane, in one sense."""

    phases: Array  # shape (m,)
    states: Array  # shape (m, n)


@dataclass(frozen=True, eq=False)
class _End:
    """The end of a trajectory, integrated again as far back as requested."""

    model: Model
    states: Array
    flow: Flow
    kept: int

    @cached_property
    def constants(self) -> Constants:
        return self.flow.constants_of(self.model)

    @cached_property
    def scales(self) -> Array:
        return self.model.state_scales()

    @property
    def unit(self) -> float:
        """Seconds from state to state."""
        return float(self.model.values["duration"])

    @property
    def time(self) -> float:
        """Seconds that the trajectory lasts."""
        return self.unit * (len(self.states) - 1)

    def window(self, steps: int) -> DenseTrajectory | None:
        """Return the trajectory over about so many of its last steps."""
        return self._window(self.flow.dense(self.states[-2], self.constants, 1.0, steps), steps)

    def stiff_window(self, steps: int) -> DenseTrajectory | None:
        """Return the same in implicit steps; None where the trajectory is not stiff."""
        several = min(CONVERGENCE.stiff_intervals, len(self.states) - 1)
        # A cycle may be stiff in some of its intervals only.
        for count in range(several, max(several - CONVERGENCE.stiff_trials, 0), -1):
            start = self.states[-1 - count]
            last = self.flow.dense(start, self.constants, float(count), CONVERGENCE.stiff_steps)
            if last is not None and last.implicit:
                return self._window(last, steps)
        return None

    def _window(self, last: DenseTrajectory | None, steps: int) -> DenseTrajectory | None:
        """Return the trajectory over a number of steps of the length of the last ones."""
        if last is None:
            return None
        count = min(math.ceil(steps * last.end / len(last.phases)), len(self.states) - 1)
        return self.flow.dense(self.states[-1 - count], self.constants, float(count), 4 * steps)

    def returns(self, window: DenseTrajectory) -> _Returns:
        """Find where a trajectory returns to a plane, revolutions left out.

        The plane is perpendicular to the trajectory where its speed is the median of the second
        half, neither at rest nor in a jump.
        """
        phases, states = window.phases, window.at(window.phases) / self.scales
        half = np.flatnonzero(phases >= 0.5 * window.end)
        directions = self._rates(states[half])
        speeds = np.linalg.norm(directions, axis=1)
        typical = int(np.argsort(speeds)[len(speeds) // 2])
        if not speeds[typical] > 0:
            return _Returns(np.empty(0), np.empty((0, states.shape[1])))
        origin, normal = states[half[typical]], directions[typical] / speeds[typical]

        def away(states: Array) -> Array:
            return wrap_angles(states - origin, self.model.angle_periods / self.scales)

        height = away(states) @ normal
        (before,) = np.nonzero((height[:-1] < 0) & (height[1:] >= 0))
        low, high = phases[before], phases[before + 1]
        at, slack = 0.5 * (low + high), 1e-6 * (high - low)
        for _ in range(12):  # five are enough
            inner = window.at(at) / self.scales
            height = away(inner) @ normal
            low, high = np.where(height < 0, at, low), np.where(height < 0, high, at)
            with np.errstate(divide="ignore", invalid="ignore"):
                moved = at - height / (self._rates(inner) @ normal)
            # What is not finite is bisected; rounding may move a value beyond the end of a step.
            inside = (moved >= low - slack) & (moved <= high + slack)
            at = np.where(inside, np.clip(moved, low, high), 0.5 * (low + high))
        nearby = away(window.at(at) / self.scales)
        extent = float(np.linalg.norm(away(states[half]), axis=1).max())
        near = np.linalg.norm(nearby, axis=1) <= CONVERGENCE.near * extent
        return _Returns(at[near], (origin + nearby)[near] * self.scales)

    def _rates(self, scaled: Array) -> Array:
        states = scaled * self.scales
        return self.flow.rates(states, np.zeros(len(states)), self.constants) / self.scales

    def trends(self, returns: Array) -> list[Trend]:
        """Return the trends of the states at returns; none if there are too few returns."""
        if len(returns) <= CONVERGENCE.few:
            return []
        scaled = returns / self.scales
        # The rounding errors of states grow with their size.
        return trends_of(scaled / max(1.0, float(np.abs(scaled).max())))

    def largest_multiplier(self, window: DenseTrajectory, begin: float, end: float) -> float:
        """Return the largest modulus of a cycle's multipliers besides those that are always one."""
        inside = window.phases[(window.phases > begin) & (window.phases < end)]
        if window.implicit:
            edges = np.concatenate([[begin], inside, [end]])
            matrices = StiffFallback(self.flow, self.constants).matrices(window, edges)
            ratios = np.ones((1, 1))
        else:
            edges = np.concatenate([[begin], inside[::100], [end]])
            states, lengths = window.at(edges[:-1]), np.diff(edges)
            still, zero = np.zeros((len(self.constants.values), 1)), np.zeros(len(states))
            matrices = self.flow.linearize(states, zero, lengths, self.constants, still)[1]
            ratios = self.scales / self.scales[:, None]
        monodromy = reduce(lambda product, matrix: matrix @ product, matrices) * ratios
        if not np.isfinite(monodromy).all():
            return math.inf
        values = np.linalg.eigvals(monodromy)
        others = np.delete(values, np.argsort(np.abs(values - 1))[: 1 + self.kept])
        return float(np.abs(others).max(initial=0.0))


def _at_rest(rest: Equilibrium) -> Settlement:
    within = f"within {max(rest.distance, 1e-16):.1e}"
    if rest.growth > 0:
        return not_converged(
            f"not settled: it sits on an unstable equilibrium, {within}; a disturbance grows by "
            f"the factor 10 in {math.log(10) / rest.growth:.3g} s",
            rest.distance,
        )
    kind = "an equilibrium" if rest.growth < 0 else "an equilibrium that attracts nothing"
    message = f"settled on {kind}, {within}"
    return Settlement(True, 1, rest.distance, None, message, kind="equilibrium")


def _on_cycle(
    end: _End, window: DenseTrajectory, phases: Array, trend: Trend, tolerance: float
) -> Settlement | None:
    """Judge a cycle by its multipliers; None if the returns are not near enough to it yet.

    The drift will decrease by the largest multiplier, which rounding errors do not show.
    """
    begin, stop = float(phases[-1 - trend.period]), float(phases[-1])
    duration = (stop - begin) * end.unit
    multiplier = end.largest_multiplier(window, begin, stop)
    if multiplier < 1 - CONVERGENCE.neutral:
        if trend.drift * multiplier / (1 - multiplier) > tolerance:
            return None
        message = f"settled on {_cycle_text(duration)}; {_repeats(trend)}"
        return Settlement(
            True, 1, trend.drift, trend.rate, message, duration=duration, kind="cycle"
        )
    if multiplier > 1 + CONVERGENCE.neutral:
        message = (
            f"not settled: it follows an unstable cycle of {duration:.9g} s, from which a "
            f"disturbance grows by the factor {multiplier:.4g} a round; start near it"
        )
        return not_converged(message, trend.drift, trend.rate)
    message = (
        f"not settled: each round of {duration:.9g} s repeats the one before within "
        f"{max(trend.drift, 1e-16):.1e}, but nothing attracts the trajectory to it; it "
        "continues as it began, as round a center without damping"
    )
    return Settlement(False, None, trend.drift, trend.rate, message, neutral_round=duration)


def _unsettled_autonomous(
    end: _End, returns: _Returns | None, seen: float, rest: Equilibrium | None, tolerance: float
) -> Settlement:
    start = f"not settled after {end.time:.6g} s: "
    sizes = np.abs(end.states / end.scales).max(axis=1)
    if rest is not None and rest.growth < 0 and _approaches(end, rest):
        more = math.log(rest.distance / tolerance) / -rest.growth
        message = (
            f"{start}it approaches an equilibrium and is {rest.distance:.1e} away; about "
            f"{more:.3g} s more are needed"
        )
        return not_converged(message, rest.distance, more=more)
    count = 0 if returns is None else len(returns.phases)
    if returns is None or count <= CONVERGENCE.few:
        half = len(sizes) // 2
        grows = half and sizes[half:].max() > 2 * sizes[:half].max()
        how = "the trajectory still grows" if grows else _few(count, seen)
        return not_converged(f"{start}{how}; simulate longer")
    return _still_changing(end, returns, start, tolerance)


def _few(count: int, seen: float) -> str:
    lately = f"in the last {seen:.4g} s the trajectory has"
    if count == 0:
        return f"{lately} not come back to where it was"
    times = "once" if count == 1 else f"{count} times"
    return f"{lately} come back to where it was {times} only, too seldom to decide"


def _approaches(end: _End, rest: Equilibrium) -> bool:
    """Whether the distance to an equilibrium decays at the rate of its slowest eigenvalue."""
    away = np.abs((end.states - rest.state) / end.scales).max(axis=1)
    if len(away) < CONVERGENCE.fewest:
        return False
    quarters = [float(part.max()) for part in np.array_split(away, 4)][1:]
    shrinks = all(after < before for before, after in pairwise(quarters))
    expected = -rest.growth * end.time / 4
    return shrinks and 0.5 < math.log(quarters[-2] / quarters[-1]) / expected < 2.0


def _still_changing(end: _End, returns: _Returns, start: str, tolerance: float) -> Settlement:
    between = float(np.diff(returns.phases).mean()) * end.unit
    trends = end.trends(returns.states)
    for trend in trends:
        more = trend.more(tolerance)
        if more is not None and trend.rate is not None:
            return not_converged(
                f"{start}the trajectory comes back after about {trend.period * between:.4g} s, "
                f"still changed by {trend.drift:.1e}, shrinking by the factor "
                f"{trend.rate**trend.period:.6g}; about {_time_text(more * between)} more are "
                "needed",
                trend.drift,
                trend.rate,
                more * between,
            )
    first = trends[0]
    if first.growing:
        how = f"leaving an unstable cycle of about {between:.4g} s; simulate longer"
        return not_converged(f"{start}it is {how}", first.drift, first.rate)
    return not_converged(
        f"{start}the trajectory comes back after about {between:.4g} s, changed by "
        f"{first.drift:.1e}, and this does not shrink; a torus, chaos or a very slow transient: "
        f"look at the trajectory, or simulate {_time_text(10 * end.time)}",
        first.drift,
        first.rate,
    )


def _time_text(time: float) -> str:
    """Return a time in seconds with three digits, e.g. ``"30,000 s"``."""
    return f"{float(f'{time:.3g}'):,.6g} s"
