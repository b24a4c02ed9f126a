"""Steps of an explicit Runge-Kutta method of order eight, compiled for many motions at once.

Where all motions take steps of the same length at the same phase, lanes of a register never wait
for each other, and some steps are one function without a branch: a fifth of the time of Taylor's
method in batches, whose lanes go each at a pace of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any

import heyoka as hy

from slipfold.flow.cache import cached
from slipfold.flow.elementary import take_apart
from slipfold.flow.equations import Equations, build_equations
from slipfold.flow.sharp_turns import FLAT, VERSION, WEIGHT, sharp_turns
from slipfold.models.model import Kind, Model
from slipfold.models.output import Expression, Limit

BEFORE = 0.4
"""Change over a step, at the present rate, by which a limit must be away: more than 1/3, so that a
cubic between two places that are that far does not reach it."""

SHORT = FLAT / 4
"""Change over a step of the argument of a function that turns sharply, so that none is missed."""

TINY = 1e-100
"""What a square must be above for a quotient of two to mean anything."""

MOST = 4
"""Steps in one call: the states stay in registers, and a call costs as much as a step."""

COMPILED = 3000
"""Operations compiled into one function at most, about a second; of larger models each step is a
call, and from twice as many on it is compiled as a loop."""


@dataclass(frozen=True)
class ExplicitSteps:
    """Some steps of one length, compiled.

    Arguments of the function, a row each: states, phase, length of a step in phase, coefficients,
    scales. Values: states after them, and the sum of their errors, in scales; 1 is added wherever a
    step might pass a limit or a sharp turn.
    """

    function: Any
    count: int


def explicit_steps_of(model: Model) -> ExplicitSteps:
    """Return the compiled steps of a model; models with the same equations share them."""
    return _shared_steps(model.kind)


@cache
def method() -> Any:
    """Return the tableau; half a second to import, which searches alone should take."""
    from scipy.integrate import DOP853

    return DOP853


@lru_cache(maxsize=64)
def _shared_steps(kind: Kind) -> ExplicitSteps:
    model = kind.make()
    equations = build_equations(model)
    bounds = [(limit.output, limit.bound) for limit in model.limits]
    operations = len(method().B) * len(take_apart(equations))
    count = max(1, min(MOST, COMPILED // operations))
    looped = operations > 2 * COMPILED
    options = f"{BEFORE, SHORT, TINY, count, looped} limits={bounds!r} {VERSION}"
    key = f"explicit steps {options}\n{equations.fingerprint()}"
    function = cached(key, lambda: _build(equations, model.limits, count, looped=looped))
    return ExplicitSteps(function, count)


def _build(equations: Equations, limits: Sequence[Limit], count: int, *, looped: bool) -> Any:
    step = hy.expression("length of the step")
    scales = [hy.expression(f"scale of {name}") for name in equations.names]
    one = _step(equations, limits, step, scales)
    states, error = list(equations.states), hy.expression(0.0)
    for place in range(count):
        there: dict[str, Expression] = dict(zip(equations.names, states, strict=True))
        there[str(equations.phase)] = equations.phase + float(place) * step
        *states, more = hy.subs(one, there)
        error = error + more
    arguments = [*equations.states, equations.phase, step, *equations.coefficients, *scales]
    # Free to reorder sums: half of the time, and what is no number remains none.
    return hy.cfunc([*states, error], vars=arguments, compact_mode=looped, fast_math=True)


def _step(
    equations: Equations,
    limits: Sequence[Limit],
    step: Expression,
    scales: Sequence[Expression],
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
    found = list[list[Expression]]()
    for row, place in zip(method().A, method().C, strict=True):
        there: dict[str, Expression] = dict(
            zip(equations.names, moved_by(equations, found, row[: len(found)]), strict=True)
        )
        there[str(equations.phase)] = equations.phase + float(place) * step
        length = step * equations.coefficients[-1]
        found.append([length * rate for rate in hy.subs(list(equations.field), there)])
    return found


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
    slopes: Sequence[Sequence[Expression]],
    ends: Sequence[Expression],
    scales: Sequence[Expression],
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
    return fifth * (n * (fifth + 0.01 * third) + TINY) ** -0.5


def _limits_away(
    equations: Equations, step: Expression, limits: Sequence[Limit]
) -> Iterator[Expression]:
    """How far each limit is, less what may be lost of that over the step."""
    outputs = dict(equations.outputs)
    for limit in limits:
        margin = outputs[limit.output] - limit.bound
        yield margin - BEFORE * _change(equations, step, margin)


def _turns_away(equations: Equations, step: Expression) -> Iterator[Expression]:
    """Whether the step is short beside each sharp turn, or far from it."""
    turns = sharp_turns(equations)
    for item in (*turns.rising, *turns.falling):
        argument = item / WEIGHT
        change = _change(equations, step, argument)
        far = _absolute(argument) - FLAT - BEFORE * change
        yield hy.select(hy.lt(change, hy.expression(SHORT)), hy.expression(1.0), far)
    for item in turns.watched:  # logarithms of what must not vanish
        yield SHORT / 2 - _change(equations, step, (item - 1.0) / WEIGHT)


def _change(equations: Equations, step: Expression, value: Expression) -> Expression:
    """How much a value changes over the step at its present rate."""
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
