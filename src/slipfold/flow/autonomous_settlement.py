"""Whether an autonomous trajectory has converged to an equilibrium or to a cycle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, reduce
from itertools import chain, pairwise

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.equilibrium import Equilibrium, equilibrium_near
from slipfold.flow.flow import Flow, flow_of
from slipfold.flow.implicit_steps import StiffFallback
from slipfold.flow.polynomials import DenseMotion
from slipfold.flow.settlement import SHORTEST, Settlement, Trend, not_converged, trends_of
from slipfold.models.model import Model
from slipfold.models.turns import without_turns

NEAR = 0.3
"""Crossings farther from where the plane was placed than this fraction of the trajectory's extent
are other parts of the trajectory."""

CORRECTIONS = 12
"""Newton steps to a crossing; five are enough, and a step that leaves its bracket is halved."""


ROUNDING = 1e-6
"""Fraction of a step by which rounding may place a crossing beyond it."""


@dataclass(frozen=True, eq=False)
class Returns:
    """Where a trajectory crosses a plane, in one sense."""

    phases: Array  # when, shape (m,)
    states: Array  # where, shape (m, n)

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.phases)


def find_returns(
    flow: Flow, constants: Constants, motion: DenseMotion, scales: Array, turns: Array
) -> Returns:
    """Find where a trajectory returns to a plane through its end, but for full revolutions.

    The plane stands across the trajectory where the speed is typical of its second half, neither at
    rest nor in a jump.
    """
    phases = motion.phases
    states = motion.at(phases) / scales
    half = phases >= 0.5 * motion.end
    places = np.flatnonzero(half)
    directions = _rates(flow, constants, motion.at(phases[half])) / scales
    speeds = np.linalg.norm(directions, axis=1)
    typical = int(np.argsort(speeds)[len(speeds) // 2])
    if not speeds[typical] > 0:
        return Returns(np.empty(0), np.empty((0, states.shape[1])))
    origin, normal = states[places[typical]], directions[typical] / speeds[typical]
    away = without_turns(states - origin, turns / scales)
    ahead = away @ normal
    before = np.flatnonzero((ahead[:-1] < 0) & (ahead[1:] >= 0))
    plane = origin, normal, turns / scales
    crossings = _crossings(flow, constants, motion, scales, plane, before)
    beside = without_turns(motion.at(crossings) / scales - origin, turns / scales)
    extent = float(np.linalg.norm(away[half], axis=1).max())
    near = np.linalg.norm(beside, axis=1) <= NEAR * extent
    return Returns(crossings[near], (origin + beside)[near] * scales)


def _rates(flow: Flow, constants: Constants, states: Array) -> Array:
    return flow.rates(states, np.zeros(len(states)), constants)


def _crossings(
    flow: Flow,
    constants: Constants,
    motion: DenseMotion,
    scales: Array,
    plane: tuple[Array, Array, Array],
    before: NDArray[np.intp],
) -> Array:
    """Correct the crossings inside the steps that hold one, all at once."""
    origin, normal, turns = plane
    low, high = motion.phases[before], motion.phases[before + 1]
    at, slack = 0.5 * (low + high), ROUNDING * (high - low)
    for _ in range(CORRECTIONS):
        states = motion.at(at)
        ahead = without_turns(states / scales - origin, turns) @ normal
        slope = (_rates(flow, constants, states) / scales) @ normal
        low, high = np.where(ahead < 0, at, low), np.where(ahead < 0, high, at)
        with np.errstate(divide="ignore", invalid="ignore"):
            moved = at - ahead / slope
        # Not where it is no number; one at the very end of a step may lie beyond by rounding.
        inside = (moved >= low - slack) & (moved <= high + slack)
        at = np.where(inside, np.clip(moved, low, high), 0.5 * (low + high))
    return at


STEPS = (4_000, 16_000, 64_000)
"""Steps of the integrator at the end of a trajectory that are looked at: a round of a smooth cycle
takes fifty, one with jumps a thousand."""

SEVERAL, TRIED, PROBE = 100, 10, 500
"""Intervals before the end from which is tried whether a trajectory is stiff, in how many of them,
and steps of each trial."""

ENOUGH = 60
"""Returns that suffice: a trend over them is one, and a cycle has repeated."""

NEUTRAL = 1e-5
"""Distance from one of a multiplier that may be one: of a center two are, known to 1e-6 only."""

PIECE = 100
"""Steps over which derivatives are carried at once."""

FEWEST = 40
"""States below which no trend can be seen."""

GROWS = 2.0
"""Factor by which a trajectory that grows without end exceeds what it was before."""


def judge_autonomous(model: Model, strobe: Array, tolerance: float) -> Settlement:
    """Judge from the end of a trajectory whether it has converged.

    On an equilibrium, if it is that near to one that attracts. On a cycle, if its returns to a
    plane across it repeat as the states of a forced trajectory must, and the cycle attracts: in a
    center each round repeats the one before without any having been converged to.

    Shapes: strobe (m, n).

    >>> from slipfold.flow.simulate import simulate
    >>> from slipfold.models import model_named
    >>> round(simulate(model_named("vanderpol-free")).settlement.duration, 8)
    6.66328686
    """
    rest = equilibrium_near(model, strobe[-1])
    if rest is not None and rest.distance <= tolerance:
        return _at_rest(rest)
    end = _End(model, strobe)
    returns, seen = None, 0.0
    for window in chain(map(end.window, STEPS), map(end.stiff_window, STEPS[:1])):
        if window is None:
            break
        seen = window.end * end.unit
        returns = end.returns(window)
        trends = end.trends(returns)
        for trend in trends:
            if trend.drift <= tolerance:
                found = _on_cycle(end, window, returns, trend, tolerance)
                if found is not None:
                    return found
        if len(returns) >= ENOUGH or end.is_whole(window):
            break
    return _unsettled(end, returns, seen, rest, tolerance)


@dataclass(frozen=True, eq=False)
class _End:
    """The end of a trajectory, integrated again as far back as asked."""

    model: Model
    strobe: Array

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
        return self.unit * (len(self.strobe) - 1)

    def window(self, steps: int) -> DenseMotion | None:
        """Return the trajectory over about so many of its last steps."""
        flow = flow_of(self.model)
        constants = flow.constants_of(self.model)
        return self._window(flow.dense(self.strobe[-2], constants, 1.0, steps), steps)

    def stiff_window(self, steps: int) -> DenseMotion | None:
        """Return the same in implicit steps; None where the trajectory is not stiff."""
        flow, whole = flow_of(self.model), len(self.strobe) - 1
        constants, several = flow.constants_of(self.model), min(SEVERAL, whole)
        for count in range(several, max(several - TRIED, 0), -1):  # in a round it is so at times
            last = flow.dense(self.strobe[-1 - count], constants, float(count), PROBE)
            if last is not None and last.implicit:
                return self._window(last, steps)
        return None

    def _window(self, last: DenseMotion | None, steps: int) -> DenseMotion | None:
        """Return so many steps, which are as long as the last ones."""
        if last is None:
            return None
        flow = flow_of(self.model)
        count = min(math.ceil(steps * last.end / len(last.phases)), len(self.strobe) - 1)
        start, constants = self.strobe[-1 - count], flow.constants_of(self.model)
        return flow.dense(start, constants, float(count), 4 * steps)

    def is_whole(self, window: DenseMotion) -> bool:
        """Whether there is no more of the trajectory."""
        return window.end >= len(self.strobe) - 1

    def returns(self, window: DenseMotion) -> Returns:
        """Return where the end of the trajectory comes back to a plane across it."""
        flow = flow_of(self.model)
        constants = flow.constants_of(self.model)
        return find_returns(flow, constants, window, self.scales, self.model.whole_turns)

    def trends(self, returns: Returns) -> list[Trend]:
        """Return how the returns change; nothing where they are too few to tell."""
        if len(returns) <= SHORTEST:
            return []
        scaled = returns.states / self.scales
        # States of hundreds of scales are known to as many times the rounding of others.
        return trends_of(scaled / max(1.0, float(np.abs(scaled).max())))

    def largest_multiplier(self, window: DenseMotion, begin: float, end: float) -> float:
        """Return the largest modulus of a cycle's multipliers besides that of its own direction."""
        flow = flow_of(self.model)
        constants = flow.constants_of(self.model)
        inside = window.phases[(window.phases > begin) & (window.phases < end)]
        if window.implicit:
            edges = np.concatenate([[begin], inside, [end]])
            matrices = StiffFallback(flow, constants).matrices(window, edges)
            return _largest_besides_one(reduce(lambda product, matrix: matrix @ product, matrices))
        edges = np.concatenate([[begin], inside[::PIECE], [end]])
        states, lengths = window.at(edges[:-1]), np.diff(edges)
        still = np.zeros((len(constants.values), 1))
        zero = np.zeros(len(states))
        matrices = flow.linearize(states, zero, lengths, constants, still)[1]
        monodromy = reduce(lambda product, matrix: matrix @ product, matrices)
        return _largest_besides_one(monodromy * (self.scales / self.scales[:, None]))


def _largest_besides_one(monodromy: Array) -> float:
    if not np.isfinite(monodromy).all():
        return math.inf
    values = np.linalg.eigvals(monodromy)
    others = np.delete(values, np.abs(values - 1).argmin())
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
    end: _End, window: DenseMotion, returns: Returns, trend: Trend, tolerance: float
) -> Settlement | None:
    """Judge a cycle that returns come to by its multipliers; None if it is not near enough yet.

    The largest one is the rate at which drift will shrink: among rounding errors the drift itself
    shows none.
    """
    begin, stop = float(returns.phases[-1 - trend.period]), float(returns.phases[-1])
    duration = (stop - begin) * end.unit
    multiplier = end.largest_multiplier(window, begin, stop)
    repeats = f"{max(trend.drift, 1e-16):.1e}"
    if multiplier < 1 - NEUTRAL:
        if trend.drift * multiplier / (1 - multiplier) > tolerance:
            return None
        return Settlement(
            True,
            1,
            trend.drift,
            trend.rate,
            f"settled on a cycle of {duration:.9g} s ({1 / duration:.6g} Hz); it repeats within "
            f"{repeats}",
            duration=duration,
            kind="cycle",
        )
    if multiplier > 1 + NEUTRAL:
        message = (
            f"not settled: it follows an unstable cycle of {duration:.9g} s, from which a "
            f"disturbance grows by the factor {multiplier:.4g} a round; start beside it"
        )
    else:
        message = (
            f"not settled: each round of {duration:.9g} s repeats the one before within {repeats}, "
            "but nothing attracts the motion to it; it goes on as it began, as round a center "
            "without damping"
        )
    return not_converged(message, trend.drift, trend.rate)


def _unsettled(
    end: _End, returns: Returns | None, seen: float, rest: Equilibrium | None, tolerance: float
) -> Settlement:
    start = f"not settled after {end.time:.6g} s: "
    sizes = np.abs(end.strobe / end.scales).max(axis=1)
    if rest is not None and rest.growth < 0 and _approaches(end, rest):
        more = math.log(rest.distance / tolerance) / -rest.growth
        message = (
            f"{start}it approaches an equilibrium and is {rest.distance:.1e} away; about "
            f"{more:.3g} s more are needed"
        )
        return not_converged(message, rest.distance)
    count = 0 if returns is None else len(returns)
    if returns is None or count <= SHORTEST:
        half = len(sizes) // 2
        grows = half and sizes[half:].max() > GROWS * sizes[:half].max()
        how = "the motion still grows" if grows else _few(count, seen)
        return not_converged(f"{start}{how}; simulate longer")
    return _still_changing(end, returns, start, tolerance)


def _few(count: int, seen: float) -> str:
    lately = f"in the last {seen:.4g} s the motion has"
    if count == 0:
        return f"{lately} not come back to where it was"
    times = "once" if count == 1 else f"{count} times"
    return f"{lately} come back to where it was {times} only, too seldom to tell"


def _approaches(end: _End, rest: Equilibrium) -> bool:
    """Whether the trajectory comes nearer to an equilibrium as its slowest eigenvalue says."""
    away = np.abs((end.strobe - rest.state) / end.scales).max(axis=1)
    if len(away) < FEWEST:
        return False
    quarters = [float(part.max()) for part in np.array_split(away, 4)][1:]
    shrinks = all(after < before for before, after in pairwise(quarters))
    expected = -rest.growth * end.time / 4
    return shrinks and 0.5 < math.log(quarters[-2] / quarters[-1]) / expected < 2.0


def _still_changing(end: _End, returns: Returns, start: str, tolerance: float) -> Settlement:
    between = float(np.diff(returns.phases).mean()) * end.unit
    trends = end.trends(returns)
    for trend in trends:
        more = trend.more(tolerance)
        if more is not None and trend.rate is not None:
            return not_converged(
                f"{start}the motion comes back after about {trend.period * between:.4g} s, still "
                f"changed by {trend.drift:.1e}, shrinking by the factor "
                f"{trend.rate**trend.period:.6g}; about {more * between:.3g} s more are needed",
                trend.drift,
                trend.rate,
            )
    first = trends[0]
    if first.growing:
        how = f"leaving an unstable cycle of about {between:.4g} s; simulate longer"
        return not_converged(f"{start}it is {how}", first.drift, first.rate)
    return not_converged(
        f"{start}the motion comes back after about {between:.4g} s, changed by {first.drift:.1e}, "
        "and this does not shrink; a torus, chaos or a very slow transient: look at the motion, or "
        f"simulate {10 * end.time:.3g} s",
        first.drift,
        first.rate,
    )
