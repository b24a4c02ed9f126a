"""What friction laws share: parameters, and functions of numbers and of symbols alike."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, fields
from typing import Any

import heyoka as hy
import numpy as np

from slipfold.errors import InputError
from slipfold.models.output import Expression
from slipfold.models.parameter import Parameter, nonnegative, positive


def is_symbolic(*values: Any) -> bool:
    """Whether any of the values is a symbolic expression."""
    return any(isinstance(value, hy.expression) for value in values)


def exp(value: Expression) -> Expression:
    """Return the exponential."""
    return hy.exp(value) if is_symbolic(value) else _plain(np.exp(value))


def tanh(value: Expression) -> Expression:
    """Return the hyperbolic tangent."""
    return hy.tanh(value) if is_symbolic(value) else _plain(np.tanh(value))


def arctan(value: Expression) -> Expression:
    """Return the inverse tangent."""
    return hy.atan(value) if is_symbolic(value) else _plain(np.arctan(value))


def sqrt(value: Expression) -> Expression:
    """Return the square root."""
    return hy.sqrt(value) if is_symbolic(value) else _plain(np.sqrt(value))


def _plain(value: Any) -> Any:
    """Return a number of NumPy's as one of Python's, which prints as it is typed."""
    return value.item() if np.ndim(value) == 0 else value


STATIC = nonnegative("mu_s", 0.5, "", "static friction coefficient, reached at rest", r"$\mu_s$")
KINETIC = nonnegative("mu_k", 0.3, "", "kinetic friction coefficient", r"$\mu_k$")
STRIBECK_SPEED = positive("vs", 0.1, "m/s", "speed over which friction falls", "$v_s$")
VISCOUS = nonnegative(
    "s2", 0.0, "s/m", "viscous friction: coefficient per slip speed", r"$\sigma_2$"
)
BRISTLE_STIFFNESS = positive(
    "s0", 1e4, "1/m", "stiffness of the contact over the normal force", r"$\sigma_0$"
)
REST_SPEED = positive(
    "e", 1e-4, "m/s", "speed below which |v| is rounded off to sqrt(v^2 + e^2)", r"$\varepsilon$"
)


def described(parameter: Parameter) -> Any:
    """Return the dataclass field that holds the value of a parameter."""
    return field(default=parameter.default, metadata={"parameter": parameter})


def declared(cls: type) -> tuple[Parameter, ...]:
    """Return the parameters whose values a dataclass holds."""
    found = (item.metadata.get("parameter") for item in fields(cls))
    return tuple(item for item in found if item is not None)


def check_static(values: Mapping[str, float]) -> None:
    """Refuse a static coefficient below the kinetic one."""
    if values["mu_s"] < values["mu_k"]:
        raise InputError(
            f"mu_s = {values['mu_s']:g} is below mu_k = {values['mu_k']:g}; friction at rest is no "
            "less than in motion, give mu_s >= mu_k"
        )


def checked_exponent(exponent: Any) -> int:
    """Return the exponent of a knee as a whole number."""
    number = isinstance(exponent, int | float) and not isinstance(exponent, bool)
    if not (number and exponent >= 2 and exponent % 2 == 0):
        raise InputError(
            f"exponent = {exponent!r} is not an even whole number; with others |z| is not smooth "
            "at z = 0, give e.g. 2"
        )
    return int(exponent)
