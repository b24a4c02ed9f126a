"""Equations of a motion and of a few perturbations that it carries along."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import heyoka as hy

from slipfold.models.output import Expression

__all__ = ["perturbed_system"]


def perturbed_system(
    states: Sequence[Expression],
    rates: Sequence[Expression],
    coefficients: Sequence[Expression],
    columns: int,
    *,
    changed: bool,
) -> list[tuple[Any, Any]]:
    r"""Add perturbations to a system.

    Each column is one derivative of the motion, with respect to its start or, if `changed`, along
    a change :math:`d_j` of the coefficients,

    .. math:: v_j' = \partial_x f \, v_j + \partial_c f \, d_j,

    so a system with few of them serves any number, one group after the other: its size grows with
    the number of states and not with its square.

    Parameters
    ----------
    states
        Symbols, length N.
    rates
        Their rates, length N.
    coefficients
        Symbols of what is constant, length n_c.
    columns
        Number of perturbations.
    changed
        Whether coefficients change; where they do not, there is a third less to compute.

    Returns
    -------
    list of (symbol, rate)
        The states and then the perturbations, column by column, length N (1 + columns).
        Parameters are the coefficients and then, if they change, the changes of the columns, n_c
        numbers each.
    """
    count = len(coefficients)
    arguments = [*states, *coefficients] if changed else list(states)
    slopes = hy.diff_tensors(list(rates), diff_args=arguments, diff_order=1).jacobian
    zero = hy.expression(0.0)
    symbols, expressions = list(states), list(rates)
    for column in range(columns):
        carried = [hy.expression(f"perturbed_{column}_{state}") for state in states]
        symbols += carried
        if changed:
            carried += [hy.par[(1 + column) * count + i] for i in range(count)]
        for row in slopes:
            terms = [
                slope * along for slope, along in zip(row, carried, strict=True) if slope != zero
            ]
            expressions.append(hy.sum(terms) if terms else zero)
    known = {str(symbol): hy.par[i] for i, symbol in enumerate(coefficients)}
    known["phase"] = hy.time
    return list(zip(symbols, hy.subs(expressions, known), strict=True))
