"""Steps of an explicit Runge-Kutta method of order eight, compiled for many trajectories at once.

Trajectories that take the same steps need no branches, and take a fifth of the time of Taylor's
method in batches. With all first derivatives, for multiple shooting, each trajectory has its own
step length.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from itertools import count
from typing import Any, NamedTuple

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array, Indices
from slipfold.flow.compiled_code import cached, numbers_of, shared_by_kind
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
    batch: int = 240  # trajectories; rows of a power of two would share few lines of the cache
    cubic_safety: float = 0.5  # of a minimum between the ends of a step
    ensemble_batch: int = 512  # trajectories without derivatives
    calls: tuple[int, ...] = (2, 3, 4, 5, 6, 8, 10, 12, 16, 24, 32, 48, 64, 96, 128)  # a period
    ensemble_tolerance: float = 1e-9  # estimated error of four steps; the error is a tenth


REGISTERS = 16
"""Trajectories that fill two registers of AVX-512."""

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
    options = f"{numbers_of(EXPLICIT)} {count, looped} limits={bounds!r} {VERSION}"
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


class PropagatedStates(NamedTuple):
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
    """A compiled step, and the control of its length.

    Arguments of the step, a row each: coefficients, scales, change of those that change, states,
    their derivatives by each of the first states and along the change, phase, length of the step.
    Values: states and derivatives after it, its error, outputs of limits and their rates before it,
    and both after it. The control takes them all, from the states on.
    """

    step: Any
    control: Any
    states: int
    limits: int
    changing: Indices  # coefficients that depend on the parameter

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
        n, watched, change = self.states, self.limits, change[:, self.changing]
        known = np.concatenate([coefficients, scales, change], axis=1)
        (rows, own), size = known.shape, n * (n + 2)
        bounds = own + size + 2
        work = np.zeros((bounds + 3 * watched + 2, rows))
        work[:own], work[own : own + n] = known.T, states.T
        derivatives = work[own + n : own + size].reshape(n, n + 1, rows)
        derivatives[np.arange(n), np.arange(n)] = 1.0
        work[own + size] = start
        work[-2:] = start + length, np.full(rows, tolerance)
        work[own + size + 1] = np.minimum(1 / 32, work[-2] - start)
        going = np.flatnonzero(np.isfinite(work).all(axis=0))
        work[bounds:-2] = np.inf
        left = np.full(rows, EXPLICIT.max_steps)
        while len(going):
            for first in range(0, len(going), EXPLICIT.batch):
                self._advance(work, own, going[first : first + EXPLICIT.batch], left)
            going = going[(work[own + size, going] < work[-2, going]) & (left[going] > 0)]
        work[own : own + size, ~(work[own + size] >= work[-2])] = np.nan
        derivatives = derivatives.transpose(2, 0, 1)
        found = work[own : own + n].T, derivatives[..., :n], derivatives[..., n]
        lowest, highest, above = work[bounds:-2].reshape(3, watched, rows).transpose(0, 2, 1)
        return PropagatedStates(*found, lowest, -highest, above)

    def _advance(self, whole: Array, own: int, rows: NDArray[np.int64], left: Indices) -> None:
        """Take steps with some trajectories until half have arrived, or all that fill a register.

        Their states follow `own` other rows; so many steps are `left` for each.
        """
        # Full registers: other code computes the remainder, so that results would depend on the
        # number of trajectories.
        lanes = np.concatenate([rows, np.full(-len(rows) % REGISTERS, rows[0])])
        known, size = len(whole), self.states * (self.states + 2)
        work = np.empty((known + size + 1 + 4 * self.limits, len(lanes)))
        whole.take(lanes, axis=1, out=work[:known], mode="clip")
        moving, phase, end = work[own : known - 2], work[own + size], work[known - 2]
        result = np.empty_like(moving)
        enough = len(lanes) // 2 if len(lanes) > REGISTERS else 0
        most = left[rows].min()
        for taken in count(1):
            self.step(work[: own + size + 2], outputs=work[known:])
            self.control(work[own:], outputs=result)
            moving[:] = result
            if taken == most or np.count_nonzero(phase < end) <= enough:
                break
        left[rows] -= taken
        whole[own : known - 2, rows] = moving[:, : len(rows)]


@cache
def linearized_steps_along(vary: str) -> Callable[[Model], LinearizedSteps | None]:
    """Return what gives the compiled steps of models, with derivatives along one parameter."""
    return shared_by_kind(partial(_linearized_steps, vary))


def _linearized_steps(vary: str, model: Model) -> LinearizedSteps | None:
    """Return the compiled steps of a model, None if they would be too long to compile.

    Most coefficients do not depend on the parameter: terms of all would be a third of the time.
    """
    equations = build_equations(model)
    parameter = str(equations.parameters[model.parameter_index(vary)])
    values = equations.coefficient_values
    changing = [i for i, value in enumerate(values) if parameter in hy.get_variables(value)]
    changes = [hy.expression(f"change of {equations.coefficients[i]}") for i in changing]
    along = np.full(len(values), hy.expression(0.0))
    along[changing] = changes
    whole = with_variations(equations, equations.dimension, [along.tolist()])
    if (
        len(method().B) * len(take_apart(equations)) * (equations.dimension + 2)
        > 5_000  # 3,000 take three seconds to compile
    ):
        return None
    bounds = [limit.output for limit in model.limits]
    watching = f"errors of derivatives too, by rows, watching rates of {bounds!r}"
    key = f"linearized explicit steps along {changes}, {watching}\n{equations.fingerprint()}"
    step = cached(key, lambda: _build_linearized(equations, whole, changes, model.limits))
    counts = equations.dimension, len(model.limits)
    made = f"control of {counts}\n{numbers_of(EXPLICIT)}"
    control = cached(made, lambda: _build_control(*counts))
    return LinearizedSteps(step, control, *counts, np.array(changing, int))


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
    arguments = [*whole.coefficients, *scales, *changes, *whole.states, whole.phase, step]
    return hy.cfunc([*ends, error, *watched, *after], vars=arguments, **FASTEST)


def _build_control(states: int, limits: int) -> Any:
    """Compile what follows a step: what counts of it, the next one, and bounds of outputs.

    Bounds are minima: of values at the ends of steps, of these with the other sign, and between.
    """
    size = states * (states + 2)
    counted = {"before": size, "after": size, "value": 4 * limits, "bound": 3 * limits}
    before, after, values, bounds = (
        [hy.expression(f"{name} {i}") for i in range(count)] for name, count in counted.items()
    )
    phase, step, end, tolerance, error = hy.make_vars("phase", "step", "end", "allowed", "error")
    none, shortest = hy.expression(0.0), hy.expression(EXPLICIT.shortest_ratio)
    good, last = hy.lte(error, tolerance), hy.lte(end - phase, step)
    factor = EXPLICIT.safety * (tolerance / error) ** (1 / EXPLICIT.order)
    longest = hy.select(good, none + EXPLICIT.longest_ratio, none + EXPLICIT.safety)
    factor = hy.select(hy.lte(shortest, factor), _least(factor, longest), shortest)
    new_phase = hy.select(good, hy.select(last, end, phase + step), phase)
    new_step = _least(factor * step, end - new_phase)
    new_states = [hy.select(good, *pair) for pair in zip(after, before, strict=True)]
    passed = [_passed(step, *values[i::limits]) for i in range(limits)]
    # A step of no length, of what has arrived, changes nothing.
    counts = hy.logical_and([good, hy.lt(none, step)])
    least = (_least(known, passed[i % limits][i // limits]) for i, known in enumerate(bounds))
    new_bounds = [hy.select(counts, *pair) for pair in zip(least, bounds, strict=True)]
    arguments = [*before, phase, step, *bounds, end, tolerance, *after, error, *values]
    results = [*new_states, new_phase, new_step, *new_bounds]
    return hy.cfunc(results, vars=arguments, opt_level=OPTIMIZATION)


def _passed(step: Any, before: Any, falls: Any, later: Any, rises: Any) -> tuple[Any, Any, Any]:
    """Return the bounds of an output from its values and rates at the ends of a step.

    A value that falls first and then rises follows a cubic, with a safety factor.
    """
    none, falls, rises = hy.expression(0.0), falls * step, rises * step
    cubic = 2.0 * (before - later) + falls + rises
    square = 3.0 * (later - before) - 2.0 * falls - rises
    turn = -falls / (square + hy.sqrt(square * square - 3.0 * cubic * falls))
    minimum = before + turn * (falls + turn * (square + turn * cubic))
    ends = _least(before, later)
    turns = hy.logical_and([hy.lt(falls, none), hy.lt(none, rises), hy.lt(minimum, ends)])
    between = hy.select(turns, minimum - EXPLICIT.cubic_safety * (ends - minimum), ends)
    return ends, _least(-before, -later), between


def _least(first: Any, second: Any) -> Any:
    """Return the least of two values; not a number if one is none."""
    other = hy.select(hy.lt(second, first), second, first + second)
    return hy.select(hy.lte(first, second), first, other)


def _rate(value: Any, equations: Equations) -> Any:
    """Return the rate of a value along the trajectory, in phase."""
    terms = [
        hy.diff(value, state) * rate
        for state, rate in zip(equations.states, equations.rates, strict=True)
    ]
    return hy.sum([*terms, hy.diff(value, equations.phase)])
