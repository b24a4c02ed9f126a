"""Whether a trajectory has converged to a steady state, judged from states that should repeat."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.batches import ROUNDING
from slipfold.flow.switched_motion import Change
from slipfold.models.turns import NO_TURNS, without_turns
from slipfold.text.one_line import number_text

LARGEST_PERIOD = 8
SHORTEST = 16
"""Forcing periods below which nothing can be said."""

SHORT = 200
"""Forcing periods below which a transient cannot be told from a torus."""


TREND = 0.9
"""Ratio of the changes in successive windows that counts as shrinking (growing: its inverse)."""


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
        Largest change of a strobe state from one response period to the next at the end, in scaled
        states; with respect to one forcing period if not settled and not approaching anything.
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
    turns
        Full revolutions of each angle in that response, by name; empty if not settled.
    """

    settled: bool
    period: int | None
    drift: float
    rate: float | None
    message: str
    duration: float | None = None
    kind: str | None = None
    turns: Mapping[str, int] = field(default_factory=dict)

    def __repr__(self) -> str:
        """One line: on what, if on anything, and how nearly."""
        if self.kind == "cycle":
            on = f"a cycle of {number_text(self.duration)} s"
        elif self.kind == "equilibrium":
            on = "an equilibrium"
        else:
            on = f"period {self.period}"
        found = f"settled on {on}" if self.settled else "not settled"
        return f"<Settlement: {found}, drift {self.drift:.1e}>"

    def __str__(self) -> str:
        """Return the sentence."""
        return self.message


def not_converged(message: str, drift: float = math.nan, rate: float | None = None) -> Settlement:
    """Return that a trajectory has not converged, and why."""
    return Settlement(False, None, drift, rate, message)


@dataclass(frozen=True)
class Trend:
    """Change of states over k of them: at the end, and in three successive windows."""

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
        least = 2.0 if last > ROUNDING else 10.0
        steady = first < TREND * middle < TREND**2 * last
        return steady and last > least * first and last > 1e-2 * ROUNDING

    @property
    def shrinking(self) -> bool:
        """Whether it shrinks steadily."""
        first, middle, last = self.windows
        # Maxima of a few changes scatter, so a short run must show more of a trend.
        most = 1.0 if 8 * self.width >= SHORT else 1 / 3
        return last < TREND * middle < TREND**2 * first and last < most * first

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

    def more(self, tolerance: float) -> int | None:
        """Return how many states more bring it within a tolerance; None if it does not shrink."""
        rate = self.rate
        if not self.shrinking or rate is None or not self.distance < math.inf:
            return None
        return math.ceil(math.log(tolerance / self.distance) / math.log(rate))


def trends_of(scaled: Array, turns: Array = NO_TURNS) -> list[Trend]:
    """Return how states change over 1 to 8 of them but for whole turns. Shapes: scaled (m, n)."""
    return [_measure(scaled, turns, period) for period in range(1, LARGEST_PERIOD + 1)]


def judge_settlement(
    strobe: Array, scales: Array, tolerance: float, turns: Array = NO_TURNS
) -> Settlement:
    """Judge from the states at phase zero whether a trajectory has converged.

    Shapes: strobe (m, n); scales (n,); turns (n,), of angles.

    The drift ``d_k`` is the largest change over k periods near the end. It shrinks by a factor
    ``r`` a period, measured over the last three eighths of the run, so the response is still
    ``d_k r^k / (1 - r^k)`` away. A small drift that hardly shrinks is thus not taken for a settled
    response.

    >>> import numpy as np
    >>> decay = 0.5 ** np.arange(101.0)[:, None]
    >>> judge_settlement(decay, np.ones(1), 1e-9).period
    1
    """
    if len(strobe) <= SHORTEST:
        count = len(strobe) - 1
        return not_converged(
            f"not settled: {count} forcing periods are too few to tell; simulate {5 * SHORT}"
        )
    trends = trends_of(strobe / scales, turns / scales)
    for trend in trends:
        if trend.distance <= tolerance:
            return _settled(_shortest(trends, trend, tolerance))
    return _unsettled(trends, len(strobe) - 1, tolerance)


def _measure(scaled: Array, turns: Array, period: int) -> Trend:
    change = np.abs(without_turns(scaled[period:] - scaled[:-period], turns)).max(axis=1)
    width = max(min(len(scaled) // 8, len(change) // 3), 1)
    windows = tuple(
        float(change[len(change) - (i + 1) * width : len(change) - i * width].max())
        for i in (2, 1, 0)
    )
    drift = float(change[-min(width, LARGEST_PERIOD) :].max())
    return Trend(period, drift, (windows[0], windows[1], windows[2]), width)


def _shortest(trends: list[Trend], settled: Trend, tolerance: float) -> Trend:
    """Return the shortest period of which the settled one is a multiple but for errors.

    A multiplier near minus one makes a response alternate that converges to period 1. Each of two
    states is known within the tolerance, once those of one more period have faded.
    """
    fading = min(settled.rate or 1.0, 1.0) ** settled.period
    parts = (trend for trend in trends if settled.period % trend.period == 0)
    return next(
        trend for trend in parts if trend is settled or trend.drift * fading <= 2 * tolerance
    )


def _settled(trend: Trend) -> Settlement:
    plural = "" if trend.period == 1 else "s"
    return Settlement(
        True,
        trend.period,
        trend.drift,
        trend.rate,
        f"settled on a response of {trend.period} forcing period{plural}; "
        f"it repeats within {max(trend.drift, 1e-16):.1e}",
        kind="response",
    )


def _unsettled(trends: list[Trend], periods: int, tolerance: float) -> Settlement:
    start = f"not settled after {periods} forcing periods: "
    for trend in trends:
        rate, more = trend.rate, trend.more(tolerance)
        if rate is not None and more is not None:
            over = "a period" if trend.period == 1 else f"{trend.period} periods"
            return not_converged(
                f"{start}the state still changes by {trend.drift:.1e} over {over}, shrinking by "
                f"the factor {rate:.6g} a period; about {more} more periods are needed",
                trend.drift,
                rate,
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
        f"shrink; {_advice(periods)}",
        first.drift,
        first.rate,
    )


def _advice(periods: int) -> str:
    if periods < SHORT:
        return f"so short a run cannot tell a transient from a torus: simulate {5 * SHORT}"
    return (
        "a torus, chaos, a period above 8 or a very slow transient: look at the strobe states, or "
        f"simulate {10 * periods}"
    )


LONGEST = 64
"""Changes in a cycle at most."""

ROUNDS = 4
"""Rounds that must repeat each other."""


def judge_changes(
    changes: list[Change], scales: Array, tolerance: float, unit: float, time: float
) -> Settlement:
    """Judge from the last changes whether a trajectory repeats itself.

    Of a cycle of k changes the last rounds must have the same modes in the same order. It is
    settled where states differ by less than the tolerance from round to round, and by as much as
    they will still do, if that shrinks from round to round. `unit` is the duration of a phase.

    Shapes: scales (n,).
    """
    for length in range(1, min(LONGEST, len(changes) // ROUNDS) + 1):
        last = changes[-ROUNDS * length :]
        if any(last[i].mode != last[i + length].mode for i in range(len(last) - length)):
            continue
        gaps = [_distance(last, i, length, scales) for i in range(ROUNDS - 1)]
        drift = gaps[-1]
        rate = drift / gaps[0] if gaps[0] > ROUNDING else None
        if drift > tolerance or (rate is not None and rate >= 1 and drift > ROUNDING):
            continue
        left = drift if rate is None else drift * math.sqrt(rate) / (1 - math.sqrt(rate))
        if left > tolerance:
            continue
        duration = (last[-1].time - last[-1 - length].time) * unit
        message = (
            f"settled on a cycle of {duration:.9g} s ({1 / duration:.6g} Hz) with stick and slip; "
            f"it repeats within {max(drift, 1e-16):.1e}"
        )
        return Settlement(True, 1, drift, rate, message, duration=duration, kind="cycle")
    message = f"not settled after {time:.6g} s: stick and slip do not repeat yet; simulate longer"
    return not_converged(message)


def _distance(last: list[Change], turn: int, length: int, scales: Array) -> float:
    """Return how far a round is from the next one."""
    first = last[turn * length : (turn + 1) * length]
    second = last[(turn + 1) * length : (turn + 2) * length]
    return max(
        float(np.abs((after.state - before.state) / scales).max())
        for before, after in zip(first, second, strict=True)
    )
