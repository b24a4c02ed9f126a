"""Linear equations in symbols, small ones, solved by elimination."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import heyoka as hy

from slipfold.models.output import Expression


def is_zero(expression: Expression) -> bool:
    """Whether it is the number zero."""
    return bool(expression == hy.expression(0.0))


def rate_along(value: Expression, rates: Mapping[str, Expression]) -> Expression:
    """Return the rate of a function of states and phase, by the rates of these."""
    terms = []
    for name, rate in rates.items():
        slope = hy.diff(value, hy.expression(name))
        if not is_zero(slope):
            terms.append(slope * rate)
    return hy.sum(terms) if terms else hy.expression(0.0)


def solve(matrix: Sequence[Sequence[Expression]], right: Sequence[Expression]) -> list[Expression]:
    """Solve equations with a definite matrix, which needs no pivots."""
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    size = len(rows)
    for place in range(size):
        for below in range(place + 1, size):
            if not is_zero(rows[below][place]):
                factor = rows[below][place] / rows[place][place]
                rows[below] = [
                    low - factor * high for low, high in zip(rows[below], rows[place], strict=True)
                ]
    found: list[Expression] = [None] * size
    for place in reversed(range(size)):
        known = rows[place][size]
        for after in range(place + 1, size):
            if not is_zero(rows[place][after]):
                known = known - rows[place][after] * found[after]
        found[place] = known / rows[place][place]
    return found


def solve_for_states(
    zeros: Sequence[Expression], names: Sequence[str]
) -> dict[str, Expression] | None:
    """Solve linear functions of states that are to vanish, each for one of the states.

    None if they contradict or repeat each other.
    """
    found: dict[str, Expression] = {}
    for zero in zeros:
        value = hy.subs(zero, found)
        for name in names:
            slope = hy.diff(value, hy.expression(name))
            if not is_zero(slope):
                break
        else:
            return None
        rest = hy.subs(value, {name: hy.expression(0.0)})
        solved = {name: -rest / slope}
        found = {key: hy.subs(item, solved) for key, item in found.items()} | solved
    return found
