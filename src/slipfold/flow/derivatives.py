"""Equations of a motion and of all its first derivatives."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import heyoka as hy

from slipfold.flow.equations import Equations
from slipfold.flow.scaled import Scaled


def with_derivatives(
    equations: Equations, scaled: Scaled, starts: int, directions: int, first: int
) -> list[tuple[Any, Any]]:
    r"""Add derivatives with respect to the first states' start, and along changes of coefficients.

    In scaled states :math:`y = q / s` each column v of them satisfies, d being its change,

    .. math:: s_i v_i' = T \sum_j \partial_j f_i \, (s_j v_j)
              + T \sum_k \partial_{c_k} f_i \, d_k + d_T f_i

    and only those along a change have the last terms; the changes are parameters of the integrator
    from the given one on. Numbers are applied one after the other: multiplied by each other they
    would be series to the integrator, and a product of series takes ten times as long as one by a
    number.
    """
    states, coefficients, scales = equations.states, equations.coefficients, scaled.scales
    count, zero = len(coefficients), hy.expression(0.0)
    slopes = hy.diff_tensors(
        list(equations.field), diff_args=[*states, *coefficients], diff_order=1
    ).jacobian
    field = scaled.express(equations.field)
    own = [scaled.express(row) for row in slopes.tolist()]
    columns = [
        [hy.expression(f"derivative {column} of {state}") for state in states]
        for column in range(starts + directions)
    ]
    system = list(zip(states, scaled.rates, strict=True))
    for i, row in enumerate(own):
        for column, symbols in enumerate(columns):
            along = [scale * symbol for scale, symbol in zip(scales, symbols, strict=True)]
            if column >= starts:
                begin = first + (column - starts) * count
                along += [hy.par[begin + k] for k in range(count)]
            terms = [slope * each for slope, each in zip(row, along, strict=False) if slope != zero]
            rate = coefficients[-1] * hy.sum(terms) if terms else zero
            if column >= starts:
                rate += along[-1] * field[i]
            system.append((symbols[i], rate / scales[i]))
    return system


def with_tangent(equations: Equations) -> Equations:
    """Add one perturbation of the states, which the linearised equations carry along."""
    carried = [hy.expression(f"carried_{state}") for state in equations.states]
    slopes = [
        hy.sum(
            [
                hy.diff(item, state) * along
                for state, along in zip(equations.states, carried, strict=True)
            ]
        )
        for item in equations.field
    ]
    return replace(
        equations,
        names=(*equations.names, *map(str, carried)),
        states=(*equations.states, *carried),
        field=(*equations.field, *slopes),
    )
