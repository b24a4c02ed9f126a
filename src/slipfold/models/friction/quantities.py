"""Parameters that several friction laws share, and how a law declares its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, fields
from typing import Any

from slipfold.errors import InputError
from slipfold.models.parameter import Parameter

STATIC = Parameter(
    "mu_s", 0.5, "", "static friction coefficient, reached at rest", 0, symbol=r"$\mu_s$"
)
KINETIC = Parameter("mu_k", 0.3, "", "kinetic friction coefficient", 0, symbol=r"$\mu_k$")
STRIBECK_SPEED = Parameter(
    "vs", 0.1, "m/s", "speed over which friction falls", 0, lower_open=True, symbol="$v_s$"
)
VISCOUS = Parameter(
    "s2", 0.0, "s/m", "viscous friction: coefficient per slip speed", 0, symbol=r"$\sigma_2$"
)
BRISTLE_STIFFNESS = Parameter(
    "s0",
    1e4,
    "1/m",
    "stiffness of the contact over the normal force",
    0,
    lower_open=True,
    symbol=r"$\sigma_0$",
)
REST_SPEED = Parameter(
    "e",
    1e-4,
    "m/s",
    "speed below which |v| is rounded off to sqrt(v^2 + e^2)",
    0,
    lower_open=True,
    symbol=r"$\varepsilon$",
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
