"""(exp(x) - 1)/x with its value 1 at x = 0, as rates of ion channels and reactions have it."""

from __future__ import annotations

import math

import heyoka as hy
import numpy as np

from slipfold.models.output import Expression

NEAR = 2.0
"""Where the quotient takes over. From here a Taylor step cannot lead past zero, where its series
is not known, and nothing cancels in its numerator."""

NODES = 10
"""Of Gauss's quadrature: exact to rounding up to x = 5, farther than a step from `NEAR` leads."""


def exprel(x: Expression) -> Expression:
    """Return it with all derivatives exact to rounding, at and about zero too.

    About zero it is the integral of exp(s x) over s from 0 to 1 by Gauss's quadrature: a sum of
    exponentials, and so are its derivatives. What is not selected stays finite: it is multiplied
    by zero in derivatives.
    """
    is_near = hy.lt(x * x, hy.expression(NEAR**2))
    near = hy.select(is_near, x, hy.expression(0.0))
    far = hy.select(is_near, hy.expression(NEAR), x)
    places, weights = np.polynomial.legendre.leggauss(NODES)
    nodes = zip(places, weights, strict=True)
    integral = hy.sum([w / 2 * hy.exp((1 + s) / 2 * near) for s, w in nodes])
    return hy.select(is_near, integral, (hy.exp(x) - 1.0) / far)


def exprel_value(x: float) -> float:
    """Return it of a number.

    >>> exprel_value(0.0), exprel_value(-700.0) * 700
    (1.0, 1.0)
    """
    return math.expm1(x) / x if x else 1.0
