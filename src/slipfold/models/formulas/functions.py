"""The functions and constants that formulas may use, in symbols and in numbers."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import heyoka as hy
import numpy as np

from slipfold.errors import not_supported, suggest
from slipfold.models.quantities import Expression


def exprel(x: Expression) -> Expression:
    """Return ``(exp(x) - 1)/x`` with all derivatives exact to rounding, also near zero.

    Near zero it is the integral of exp(s x) over s from 0 to 1 by Gauss's quadrature: a sum of
    exponentials, and so are its derivatives. The branch that is not selected stays finite, since
    derivatives multiply it by zero.
    """
    bound = 2.0  # no Taylor step from there passes zero, and nothing cancels in the quotient
    is_near = hy.lt(x * x, hy.expression(bound**2))
    near = hy.select(is_near, x, hy.expression(0.0))
    far = hy.select(is_near, hy.expression(bound), x)
    # Exact to rounding up to x = 5; a step from the bound ends before
    locations, weights = np.polynomial.legendre.leggauss(10)
    nodes = zip(locations, weights, strict=True)
    integral = hy.sum([w / 2 * hy.exp((1 + s) / 2 * near) for s, w in nodes])
    return hy.select(is_near, integral, (hy.exp(x) - 1.0) / far)


def exprel_value(x: float) -> float:
    """Return `exprel` of a number."""
    return math.expm1(x) / x if x else 1.0


def whole_power(base: Expression, exponent: int) -> Expression:
    """Return a power as a product: the series of a power divides by its base, which may be zero.

    >>> import heyoka as hy
    >>> whole_power(hy.expression("u"), 3)
    (u * (u * u))
    >>> whole_power(2.0, 7)
    128.0
    """
    result: Expression = None
    # By squaring: the squares are shared, so this stays short.
    while exponent:
        if exponent & 1:
            result = base if result is None else result * base
        exponent >>= 1
        if exponent:
            base = base * base
    return 1.0 if result is None else result


OPTIMIZATION = int(os.environ.get("SLIPFOLD_OPTIMIZATION", "2"))
"""LLVM's level for all that is compiled. At 3 integrators take a quarter longer to compile and give
the same digits as fast; at 0 they run half as fast, which suits tests, where most run once."""

SHORT = 500
"""Terms of functions up to which code is not compact: it is compiled in a third of the time, but
more take ever longer."""


def compiled_function(expressions: Iterable[Expression], symbols: Sequence[Expression]) -> Any:
    """Compile functions of n symbols, called with their values, shape (n,) or (n, m).

    Little is optimized: only integrators run long enough to repay it. Batches have the size one, so
    that a value does not depend on the number of others.
    """
    # heyoka's own disk cache is unchecked and shared by all programs.
    hy.llvm_state.set_diskcache_enabled(False)
    level, written = min(1, OPTIMIZATION), list(expressions)
    compact = sum(map(len, written)) > SHORT
    return hy.cfunc(
        written, vars=list(symbols), compact_mode=compact, opt_level=level, batch_size=1
    )


CONSTANTS = {"pi": math.pi}

TIME = "t"
"""Name of the time in seconds, in formulas of forced systems."""


@dataclass(frozen=True)
class Function:
    """A smooth function, of which Taylor series and all derivatives can be computed."""

    count: int  # number of arguments
    symbolic: Callable[..., Expression]  # the function of symbols
    # The function of floats; may raise `ArithmeticError` or `ValueError` outside its domain
    numeric: Callable[..., float]


FUNCTIONS: dict[str, Function] = {
    "sin": Function(1, hy.sin, math.sin),
    "cos": Function(1, hy.cos, math.cos),
    "tan": Function(1, hy.tan, math.tan),
    "asin": Function(1, hy.asin, math.asin),
    "acos": Function(1, hy.acos, math.acos),
    "atan": Function(1, hy.atan, math.atan),
    "atan2": Function(2, hy.atan2, math.atan2),
    "sinh": Function(1, hy.sinh, math.sinh),
    "cosh": Function(1, hy.cosh, math.cosh),
    "tanh": Function(1, hy.tanh, math.tanh),
    "asinh": Function(1, hy.asinh, math.asinh),
    "acosh": Function(1, hy.acosh, math.acosh),
    "atanh": Function(1, hy.atanh, math.atanh),
    "exp": Function(1, hy.exp, math.exp),
    "log": Function(1, hy.log, math.log),
    "sqrt": Function(1, hy.sqrt, math.sqrt),
    "erf": Function(1, hy.erf, math.erf),
    "exprel": Function(1, exprel, exprel_value),
    "sigmoid": Function(1, hy.sigmoid, lambda value: 0.5 * (1.0 + math.tanh(0.5 * value))),
}

_CORNER = (
    "is not smooth, and flows and their derivatives need smooth rates; write tanh(x/e) for a sign, "
    "sqrt(x^2 + e^2) for a modulus or (x + sqrt(x^2 + e^2))/2 for a gap with a small e, or the "
    "formula of one side with an entry in [limits] where that side ends"
)

_DRY = (
    "; friction that sticks is a force declared in [contacts] by its slip and normal force, or "
    "belongs to a contact of a Structure, FrictionContact with an exact law such as Coulomb"
)

_NOT_SMOOTH = frozenset(
    (
        *("abs", "sign", "sgn", "min", "max", "clip", "saturate", "relu"),
        *("floor", "ceil", "round", "mod", "fmod"),
        *("step", "heaviside", "heav", "if", "where", "select", "piecewise"),
    )
)

_INSTEAD = {
    "ln": "log(x)",
    "log10": "log(x)/log(10)",
    "log2": "log(x)/log(2)",
    "pow": "x^y",
    "cbrt": "x^(1/3)",
    "arcsin": "asin(x)",
    "arccos": "acos(x)",
    "arctan": "atan(x)",
    "arctan2": "atan2(y, x)",
    "arcsinh": "asinh(x)",
    "arccosh": "acosh(x)",
    "arctanh": "atanh(x)",
    "sec": "1/cos(x)",
    "csc": "1/sin(x)",
    "cot": "1/tan(x)",
    "sech": "1/cosh(x)",
    "logistic": "sigmoid(x)",
    "erfc": "1 - erf(x)",
    "expm1": "x*exprel(x)",
    "sum": "sum(i=1:3, x[i]), with a range for the index",
    "vtrap": "y/exprel(x/y)",
}


def explain_unknown_function(name: str) -> str:
    """Return the message about a function that formulas do not have."""
    if name in _NOT_SMOOTH:
        return f"{name} {_CORNER}{_DRY if name in ('sign', 'sgn') else ''}"
    if name in _INSTEAD:
        return f"there is no function {name!r}; write {_INSTEAD[name]}"
    return (
        f"there is no function {name!r}; {not_supported(name) or suggest(name, FUNCTIONS)}"
        f"the functions are {', '.join(FUNCTIONS)}"
    )
