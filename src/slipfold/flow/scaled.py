"""Equations in scaled states: integrators measure errors there, and absolutely below one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import heyoka as hy
import numpy as np

from slipfold.arrays import Array
from slipfold.flow.equations import Equations
from slipfold.models.output import Expression

FAR = 16.0
"""Length of a direction beyond which its third power hides the first one from the tolerance."""


@dataclass(frozen=True)
class Scaled:
    """A model's equations for ``y = q / s``, the scales s being symbols: one code serves all."""

    scales: tuple[Expression, ...]  # symbols of the scales, length n
    rates: tuple[Expression, ...]  # ``dy/dphase`` in y, under the names of the states q, length n
    _states: dict[str, Expression]

    @classmethod
    def of(cls, equations: Equations) -> Scaled:
        """Write equations in scaled states."""
        scales = tuple(hy.expression(f"scale of {name}") for name in equations.names)
        states = {
            name: scale * state
            for name, scale, state in zip(equations.names, scales, equations.states, strict=True)
        }
        rates = hy.subs(list(equations.rates), states)
        scaled = (rate / scale for rate, scale in zip(rates, scales, strict=True))
        return cls(scales, tuple(scaled), states)

    def express(self, expressions: Sequence[Expression]) -> list[Expression]:
        """Write expressions of the states q in y and the scales."""
        return list(hy.subs(list(expressions), self._states))


def power_of_two(sizes: Array) -> Array:
    """Return the powers of two nearest to sizes: scaling by them rounds nothing."""
    return np.asarray(np.exp2(np.round(np.log2(sizes))))


def of_order_one(directions: Array) -> tuple[Array, Array]:
    """Return directions over powers of two, so that no jet of theirs hides another, and these."""
    lengths = np.abs(directions).max(axis=1)
    far = (lengths > FAR) | ((lengths > 0) & (lengths < 1 / FAR))
    lengths = power_of_two(np.where(far & np.isfinite(lengths), lengths, 1.0))
    return directions / lengths[:, None], lengths
