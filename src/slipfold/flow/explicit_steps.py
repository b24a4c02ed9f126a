"""Steps of an explicit Runge-Kutta method of order eight, compiled for many trajectories at once.

Trajectories that take the same steps need no branches, and take a fifth of the time of Taylor's
method in batches. With all first derivatives, for multiple shooting, each trajectory has its own
step length.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.compiled_code import cached, shared_by_kind
from slipfold.flow.equations import Equations, build_equations, with_variations
from slipfold.flow.sharp_turns import TURNS, VERSION, sharp_turns, take_apart
from slipfold.models.formulas.functions import OPTIMIZATION
from slipfold.models.model import Model
from slipfold.models.quantities import Expression, Limit


class EXPLICIT:
    """Accuracy and size of the explicit steps."""

    # Distance of a limit, in changes over a step: beyond 1/3 a cubic does not reach it
    limit_distance: float = 0.4
    # Change of a sharp function's argument that misses no bend
    sharp_change: float = TURNS.flat / 4
    tiny: float = 1e-100  # smallest denominator of a quotient of squares
    steps_per_call: int = 4  # which stay in registers; a call costs as much as a step
    operations: int = 3000  # in a compiled function, a second to compile; beyond it one step a call
    tolerance: float = 1e-10  # error of a step and its derivatives in scales: orbits to 1e-9
    order: int = 8
    safety: float = 0.9
    shortest_ratio: float = 0.2  # of two steps
    longest_ratio: float = 4.0
    max_steps: int = 600  # after which a trajectory is left behind
    steps_per_round: int = 6  # after which trajectories that have not arrived form new batches
    batch: int = 256  # trajectories: many for the cost of a call, few for the processor's cache
    cubic_safety: float = 0.5  # of a minimum between the ends of a step
    ensemble_batch: int = 512  # trajectories without derivatives
    calls: tuple[int, ...] = (2, 3, 4, 5, 6, 8, 10, 12, 16, 24, 32, 48, 64, 96, 128)  # a period
    ensemble_tolerance: float = 1e-9  # estimated error of four steps; the error is a tenth


# Reordered sums take half of the time; NaN remains NaN.
FASTEST = {"fast_math": True, "opt_level": OPTIMIZATION}


@dataclass(frozen=True)
class ExplicitSteps:
    """Compiled steps of one length.

    Arguments of the function, a row each: states, phase, length of a step in phase, coefficients,
    scales. Values: states after them, and the sum of their errors, in scales; 1 is added wherever a
    step might pass a limit or a sharp turn.
    """

    function: Any
    count: int


@cache
def method() -> Any:
    """Return the tableau; its import takes half a second."""
    from scipy.integrate import DOP853

    return DOP853


@shared_by_kind
def explicit_steps_of(model: Model) -> ExplicitSteps:
    """Return the compiled steps of a model; models with the same equations share them."""
    equations = build_equations(model)
    bounds = [(limit.output, limit.bound) for limit in model.limits]
    operations = len(method().B) * len(take_apart(equations))
    count = max(1, min(EXPLICIT.steps_per_call, EXPLICIT.operations // operations))
    looped = operations > 2 * EXPLICIT.operations
    options = f"{EXPLICIT} {count, looped} limits={bounds!r} {VERSION}"
    key = f"explicit steps {options}\n{equations.fingerprint()}"
    function = cached(key, lambda: _build_plain(equations, model.limits, count, looped=looped))
    return ExplicitSteps(function, count)


def _build_plain(equations: Equations, limits: Sequence[Limit], count: int, *, looped: bool) -> Any:
    step = hy.expression("length of the step")
    scales = [hy.expression(f"scale of {name}") for name in equations.names]
    one = _step(equations, limits, step, scales)
    states, error = list(equations.states), hy.expression(0.0)
    for index in range(count):
        there: dict[str, Expression] = dict(zip(equations.names, states, strict=True))
        there[str(equations.phase)] = equations.phase + float(index) * step
        *states, more = hy.subs(one, there)
        error = error + more
    arguments = [*equations.states, equations.phase, step, *equations.coefficients, *scales]
    return hy.cfunc([*states, error], vars=arguments, compact_mode=looped, **FASTEST)


def _step(
    equations: Equations, limits: Sequence[Limit], step: Expression, scales: Sequence[Expression]
) -> list[Expression]:
    """States after one step, and its error."""
    slopes = stage_slopes(equations, step)
    ends = moved_by(equations, slopes, method().B)
    away = [*_limits_away(equations, step, limits), *_turns_away(equations, step)]
    none, one = hy.expression(0.0), hy.expression(1.0)
    near = [hy.select(hy.lt(none, item), none, one) for item in away]
    return [*ends, hy.sum([step_error(slopes, ends, scales), *near])]


def stage_slopes(equations: Equations, step: Expression) -> list[list[Expression]]:
    """Changes of the states over the step at the rates of each stage."""
    result = list[list[Expression]]()
    for row, fraction in zip(method().A, method().C, strict=True):
        there: dict[str, Expression] = dict(
            zip(equations.names, moved_by(equations, result, row[: len(result)]), strict=True)
        )
        there[str(equations.phase)] = equations.phase + float(fraction) * step
        length = step * equations.coefficients[-1]
        result.append([length * rate for rate in hy.subs(list(equations.field), there)])
    return result


def moved_by(
    equations: Equations, slopes: Sequence[Sequence[Expression]], weights: Sequence[float]
) -> list[Expression]:
    """States moved by a weighted sum of stages."""
    changes = _combined(slopes, weights, len(equations.states))
    return [state + change for state, change in zip(equations.states, changes, strict=True)]


def _combined(
    slopes: Sequence[Sequence[Expression]], weights: Sequence[float], count: int
) -> list[Expression]:
    used = [(float(w), slope) for w, slope in zip(weights, slopes, strict=True) if w != 0]
    return [hy.sum([w * slope[i] for w, slope in used]) for i in range(count)]


def step_error(
    slopes: Sequence[Sequence[Expression]], ends: Sequence[Expression], scales: Sequence[Expression]
) -> Expression:
    """Hairer's estimate from two embedded methods, of the fifth and the third order."""
    stages, n = len(slopes), len(scales)
    sizes = [scale**2.0 + end**2.0 for scale, end in zip(scales, ends, strict=True)]
    fifth, third = (
        hy.sum([
            part**2.0 / size
            for part, size in zip(_combined(slopes, weights[:stages], n), sizes, strict=True)
        ])
        for weights in (method().E5, method().E3)
    )  # fmt: skip
    return fifth * (n * (fifth + 0.01 * third) + EXPLICIT.tiny) ** -0.5


def _limits_away(
    equations: Equations, step: Expression, limits: Sequence[Limit]
) -> Iterator[Expression]:
    """Yield margins of limits less their possible decrease over the step."""
    outputs = dict(equations.outputs)
    for limit in limits:
        margin = outputs[limit.output] - limit.bound
        yield margin - EXPLICIT.limit_distance * _change(equations, step, margin)


def _turns_away(equations: Equations, step: Expression) -> Iterator[Expression]:
    """Yield positive values if the step is short near a sharp turn, or far from it."""
    turns = sharp_turns(equations)
    for item in (*turns.rising, *turns.falling):
        argument = item / TURNS.weight
        change = _change(equations, step, argument)
        far = _absolute(argument) - TURNS.flat - EXPLICIT.limit_distance * change
        yield hy.select(
            hy.lt(change, hy.expression(EXPLICIT.sharp_change)), hy.expression(1.0), far
        )
    for item in turns.watched:  # logarithms of sums that must not vanish
        yield EXPLICIT.sharp_change / 2 - _change(equations, step, (item - 1.0) / TURNS.weight)


def _change(equations: Equations, step: Expression, value: Expression) -> Expression:
    """Return the change of a value over the step at its present rate."""
    part = float(method().C[1])
    length = part * step * equations.coefficients[-1]
    soon: dict[str, Expression] = {
        name: state + length * rate
        for name, state, rate in zip(
            equations.names, equations.states, equations.field, strict=True
        )
    }
    soon[str(equations.phase)] = equations.phase + part * step
    (later,) = hy.subs([value], soon)
    return _absolute(later - value) / part


def _absolute(value: Expression) -> Expression:
    return hy.sqrt(value**2.0)


@dataclass(frozen=True, eq=False)
class PropagatedStates:
    """Final states, NaN where not reached; everything in the states' own units."""

    ends: Array  # shape (l, n)
    matrices: Array  # derivatives by the first states, shape (l, n, n)
    vectors: Array  # derivatives along the change of coefficients, shape (l, n)
    lowest: Array  # minimum of each limit's output at the ends of steps, shape (l, n_limits)
    highest: Array  # and the maximum
    # Lower bound between these from values and slopes, shape (l, n_limits)
    above: Array


@dataclass(frozen=True)
class LinearizedSteps:
    """A compiled step.

    Arguments, a row each: states, then their derivatives by each of the first states and along the
    change of coefficients, phase, length of the step, coefficients, scales, change of coefficients.
    Values: states and derivatives after it, its error, outputs of limits and their rates before it,
    and both after it.
    """

    function: Any
    states: int
    limits: int

    def propagate(
        self,
        states: Array,
        start: Array,
        length: float,
        coefficients: Array,
        scales: Array,
        change: Array,
        tolerance: float = EXPLICIT.tolerance,
    ) -> PropagatedStates:
        """Propagate states and their derivatives over a piece of a forcing period.

        Shapes: states, scales (l, n); start (l,); coefficients, change (l, n_c).
        """
        n, count = self.states, len(states)
        size = n * (n + 2)
        work = np.zeros((size + 2 + coefficients.shape[1] * 2 + n, count))
        work[:n] = states.T
        rows = work[n:size].reshape(n, n + 1, count)
        rows[np.arange(n), np.arange(n)] = 1.0
        work[size], work[size + 1] = start, min(1 / 32, length)
        work[size + 2 :] = np.concatenate([coefficients, scales, change], axis=1).T
        passed = _Passed()
        going = np.flatnonzero(np.isfinite(work).all(axis=0))
        arrived = np.zeros(count, bool)
        for _ in range(0, EXPLICIT.max_steps, EXPLICIT.steps_per_round):
            for first in range(0, len(going), EXPLICIT.batch):
                some = going[first : first + EXPLICIT.batch]
                with np.errstate(all="ignore"):
                    arrived[some] = self._advance(
                        work, some, start[some] + length, passed, tolerance
                    )
            going = going[~arrived[going] & np.isfinite(work[size + 1, going])]
            if not len(going):
                break
        work[:size, ~arrived] = np.nan
        derivatives = work[n:size].reshape(n, n + 1, count).transpose(2, 0, 1)
        bounds = passed.bounds(count, self.limits)
        return PropagatedStates(work[:n].T, derivatives[..., :n], derivatives[..., n], *bounds)

    def _advance(
        self, whole: Array, rows: NDArray[np.int64], ends: Array, passed: _Passed, tolerance: float
    ) -> NDArray[np.bool_]:
        """Take a few steps with some trajectories; return which have arrived."""
        size, count, watched = self.states * (self.states + 2), len(rows), self.limits
        # Full registers: other code computes the remainder, so that results would depend on the
        # number of trajectories.
        more = -count % 16
        work = np.ascontiguousarray(whole[:, np.concatenate([rows, np.full(more, rows[0])])])
        ends = np.concatenate([ends, np.full(more, ends[0])])
        phase, step = work[size], work[size + 1]
        values = np.empty((size + 1 + 4 * watched, work.shape[1]))
        left = phase < ends
        for _ in range(EXPLICIT.steps_per_round):
            last = phase + step >= ends
            step[last] = (ends - phase)[last]
            self.function(work, outputs=values)
            factor = EXPLICIT.safety * (tolerance / values[size]) ** (1 / EXPLICIT.order)
            good = (values[size] <= tolerance) & left
            np.copyto(work[:size], values[:size], where=good)
            kept = good[:count]
            passed.add(rows[kept], step[:count][kept], values[size + 1 :, :count][:, kept])
            phase[good] = np.where(last, ends, phase + step)[good]
            left &= ~(good & last)
            longest = np.where(good, EXPLICIT.longest_ratio, EXPLICIT.safety)
            requested = step * np.fmin(np.fmax(factor, EXPLICIT.shortest_ratio), longest)
            requested[np.isnan(factor)] = 0.25 * step[np.isnan(factor)]
            step[:] = np.where(left, requested, 0.0)
            if not left.any():
                break
        whole[:, rows] = work[:, :count]
        return ~left[:count]


class _Passed:
    """Outputs of limits before and after all steps of many trajectories."""

    def __init__(self) -> None:
        self._motions = [np.empty(0, dtype=np.int64)]
        self._steps, self._seen = list[Array](), list[Array]()

    def add(self, rows: NDArray[np.int64], steps: Array, seen: Array) -> None:
        """Add steps of some trajectories. Shapes: steps (k,); seen (4 n_limits, k)."""
        self._motions.append(rows)
        self._steps.append(steps)
        self._seen.append(seen)

    def bounds(self, count: int, watched: int) -> tuple[Array, Array, Array]:
        """Return minimum and maximum values, and lower bounds between them, each (l, n_limits).

        A value that falls first and then rises follows a cubic, with a safety factor.
        """
        lowest, above = np.full((2, watched, count), np.inf)
        highest = np.full((watched, count), -np.inf)
        trajectories = np.concatenate(self._motions)
        if len(trajectories) and watched:
            steps = np.concatenate(self._steps)
            seen = np.concatenate(self._seen, axis=1).reshape(4, watched, -1)
            before, falls, after, rises = seen * np.array([np.ones_like(steps), steps] * 2)[:, None]
            cubic = 2 * (before - after) + falls + rises
            square = 3 * (after - before) - 2 * falls - rises
            with np.errstate(all="ignore"):
                turn = -falls / (square + np.sqrt(square * square - 3 * cubic * falls))
                minimum = before + turn * (falls + turn * (square + turn * cubic))
            ends = np.minimum(before, after)
            minimum = np.where((falls < 0) & (rises > 0), np.fmin(minimum, ends), ends)
            for row in range(watched):
                np.minimum.at(lowest[row], trajectories, ends[row])
                np.maximum.at(highest[row], trajectories, np.maximum(before, after)[row])
                np.minimum.at(
                    above[row],
                    trajectories,
                    (minimum - EXPLICIT.cubic_safety * (ends - minimum))[row],
                )
        return lowest.T, highest.T, above.T


@shared_by_kind
def linearized_steps_of(model: Model) -> LinearizedSteps | None:
    """Return the compiled steps of a model, None if they would be too long to compile."""
    equations = build_equations(model)
    changes = [hy.expression(f"change of {symbol}") for symbol in equations.coefficients]
    whole = with_variations(equations, equations.dimension, [changes])
    if (
        len(method().B) * len(take_apart(equations)) * (equations.dimension + 2)
        > 5_000  # 3,000 take three seconds to compile
    ):
        return None
    bounds = [limit.output for limit in model.limits]
    watching = f"errors of derivatives too, by rows, watching rates of {bounds!r}"
    key = f"linearized explicit steps, {watching}\n{equations.fingerprint()}"
    function = cached(key, lambda: _build_linearized(equations, whole, changes, model.limits))
    return LinearizedSteps(function, equations.dimension, len(model.limits))


def _build_linearized(
    equations: Equations, whole: Equations, changes: Sequence[Any], limits: Sequence[Limit]
) -> Any:
    step = hy.expression("length of the step")
    scales = [hy.expression(f"scale of {name}") for name in equations.names]
    slopes = stage_slopes(whole, step)
    ends = moved_by(whole, slopes, method().B)
    # Derivatives count as well: states that hardly move show nothing of the rates around them.
    rows = [[*(own / first for first in scales), own] for own in scales]
    sizes = [*scales, *(size for row in rows for size in row)]
    own_slopes = [row[: len(scales)] for row in slopes]
    error = step_error(own_slopes, ends[: len(scales)], scales)
    error += step_error(slopes, ends, sizes)
    outputs = dict(equations.outputs)
    watched = [outputs[limit.output] for limit in limits]
    watched += [_rate(item, equations) for item in watched]
    there: dict[str, Any] = dict(zip(whole.names, ends, strict=True))
    there[str(whole.phase)] = whole.phase + step
    after = list(hy.subs(watched, there)) if watched else []
    arguments = [*whole.states, whole.phase, step, *whole.coefficients, *scales, *changes]
    return hy.cfunc([*ends, error, *watched, *after], vars=arguments, **FASTEST)


def _rate(value: Any, equations: Equations) -> Any:
    """Return the rate of a value along the trajectory, in phase."""
    terms = [
        hy.diff(value, state) * rate
        for state, rate in zip(equations.states, equations.rates, strict=True)
    ]
    return hy.sum([*terms, hy.diff(value, equations.phase)])
