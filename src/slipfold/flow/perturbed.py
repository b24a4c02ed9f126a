"""Equations of a motion and of a few perturbations that it carries along."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import heyoka as hy

from slipfold.models.output import Expression


def perturbed_system(
    states: Sequence[Expression],
    rates: Sequence[Expression],
    changing: Sequence[Expression],
    columns: int,
    *,
    first: int,
) -> list[tuple[Any, Any]]:
    r"""Add perturbations to a system.

    Each column is one derivative of the motion, with respect to its start or along a change
    :math:`d_j` of coefficients,

    .. math:: v_j' = \partial_x f \, v_j + \partial_c f \, d_j,

    so a system with few of them serves any number, one group after the other: its size grows with
    the number of states and not with its square.
    """
    count = len(changing)
    slopes = hy.diff_tensors(list(rates), diff_args=[*states, *changing], diff_order=1).jacobian
    zero = hy.expression(0.0)
    symbols, expressions = list(states), list(rates)
    for column in range(columns):
        carried = [hy.expression(f"perturbed_{column}_{state}") for state in states]
        symbols += carried
        carried += [hy.par[first + column * count + i] for i in range(count)]
        for row in slopes:
            terms = [
                slope * along for slope, along in zip(row, carried, strict=True) if slope != zero
            ]
            expressions.append(hy.sum(terms) if terms else zero)
    return list(zip(symbols, expressions, strict=True))
