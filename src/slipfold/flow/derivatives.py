"""Equations of a motion and of all its first derivatives."""

from __future__ import annotations

from typing import Any

import heyoka as hy

from slipfold.flow.equations import Equations
from slipfold.flow.scaled import Scaled

__all__ = ["with_derivatives"]


def with_derivatives(
    equations: Equations, scaled: Scaled, directions: int, first: int
) -> list[tuple[Any, Any]]:
    r"""Add derivatives with respect to the start, and along changes d of the coefficients c.

    In scaled states :math:`y = q / s` each column v of them satisfies

    .. math:: s_i v_i' = T \sum_j \partial_j f_i \, (s_j v_j)
              + T \sum_k \partial_{c_k} f_i \, d_k + d_T f_i

    and only those along a change have the last terms; the changes are parameters of the integrator
    from the given one on. Numbers are applied one after the other: multiplied by each other they
    would be series to the integrator, and a product of series takes ten times as long as one by a
    number.
    """
    states, coefficients, scales = equations.states, equations.coefficients, scaled.scales
    n, count, zero = len(states), len(coefficients), hy.expression(0.0)
    slopes = hy.diff_tensors(
        list(equations.field), diff_args=[*states, *coefficients], diff_order=1
    ).jacobian
    field = scaled.express(equations.field)
    own = [scaled.express(row) for row in slopes.tolist()]
    columns = [
        [hy.expression(f"derivative {column} of {state}") for state in states]
        for column in range(n + directions)
    ]
    system = list(zip(states, scaled.rates, strict=True))
    for i, row in enumerate(own):
        for column, symbols in enumerate(columns):
            along = [scale * symbol for scale, symbol in zip(scales, symbols, strict=True)]
            if column >= n:
                begin = first + (column - n) * count
                along += [hy.par[begin + k] for k in range(count)]
            terms = [slope * each for slope, each in zip(row, along, strict=False) if slope != zero]
            rate = coefficients[-1] * hy.sum(terms) if terms else zero
            if column >= n:
                rate += along[-1] * field[i]
            system.append((symbols[i], rate / scales[i]))
    return system
