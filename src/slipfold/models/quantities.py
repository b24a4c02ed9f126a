"""Parameters, states, outputs and limits of a model: name, unit, bounds and meaning."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from slipfold.errors import InputError
from slipfold.read_only import Documented

Expression = Any
"""A symbolic expression (`heyoka.expression`)."""

Symbols = Mapping[str, Expression]
"""Named symbolic expressions."""

StateSymbols = Annotated[Symbols, "The states by name."]
CoefficientSymbols = Annotated[Symbols, "The coefficients by name."]
ParameterSymbols = Annotated[Symbols, "The parameters by name."]
Phase = Annotated[Expression, "Time divided by the forcing period."]
ParameterName = Annotated[str, "Name of the parameter."]
OutputName = Annotated[str, "A state or output of the model."]


@dataclass(frozen=True)
class Parameter(Documented):
    """A number a model depends on.

    Examples
    --------
    >>> Parameter("mu", 0.5, "", "friction coefficient", lower=0).check(0.3)
    0.3
    """

    name: Annotated[str, 'The symbol used in formulas, arguments and files, e.g. ``"Nd"``.']
    default: Annotated[float, "Value in SI units where the user gives none."]
    unit: Annotated[
        str, 'SI unit as text (``"N"``, ``"m/s"``, ``"rad"``), ``""`` for a pure number.'
    ] = ""
    doc: Annotated[str, "One line that says what it is."] = ""
    lower: Annotated[float, "Bounds of what is allowed, in the unit of the parameter."] = -math.inf
    upper: Annotated[float, ""] = math.inf
    lower_open: Annotated[bool, "Whether the bound itself is excluded."] = False
    upper_open: Annotated[bool, ""] = False
    symbol: Annotated[
        str, "How figures write it (matplotlib mathtext); the name itself if empty."
    ] = ""
    why: Annotated[str, "What a refusal says after the bounds: why, and what else to do."] = ""

    @property
    def label(self) -> str:
        """Axis label: symbol and unit."""
        symbol = self.symbol or self.name
        return f"{symbol} ({self.unit})" if self.unit else symbol

    @property
    def bounds(self) -> str:
        """The allowed values as a sentence fragment, e.g. ``"> 0 m/s"``."""
        unit = f" {self.unit}" if self.unit else ""
        parts = []
        if math.isfinite(self.lower):
            parts.append(f"{'>' if self.lower_open else '>='} {self.lower:g}{unit}")
        if math.isfinite(self.upper):
            parts.append(f"{'<' if self.upper_open else '<='} {self.upper:g}{unit}")
        return " and ".join(parts) or "any finite number"

    def check(self, value: float) -> float:
        """Return `value` as a float, or raise if it is outside the bounds.

        Parameters
        ----------
        value
            Candidate in the unit of the parameter.
        """
        value = float(value)
        if self.lower < value < self.upper:  # as nearly all are
            return value
        if not math.isfinite(value):
            raise InputError(f"{self.name} = {value} is not a finite number; give {self.bounds}")
        below = value <= self.lower if self.lower_open else value < self.lower
        above = value >= self.upper if self.upper_open else value > self.upper
        if below or above:
            raise InputError(
                f"{self.name} = {value:g} is outside its bounds; {self.name} must be {self.bounds}"
                f"{self.why}"
            )
        return value


def positive(name: str, default: float, unit: str, doc: str = "", symbol: str = "") -> Parameter:
    """Describe a parameter that must be > 0."""
    return Parameter(name, default, unit, doc, 0, lower_open=True, symbol=symbol)


def nonnegative(name: str, default: float, unit: str, doc: str = "", symbol: str = "") -> Parameter:
    """Describe a parameter that must be >= 0."""
    return Parameter(name, default, unit, doc, 0, symbol=symbol)


DURATION = positive("duration", 1.0, "s", "period of a cycle; elsewhere a unit of time")
"""Parameter of every autonomous model, in the place of the forcing period."""


@dataclass(frozen=True)
class State(Documented):
    """A state variable of a model.

    Examples
    --------
    >>> State("x", "", "horizontal displacement over L", "$x/L$").label
    '$x/L$'
    """

    name: Annotated[str, 'Name in results and on the command line, e.g. ``"vx"``.']
    unit: Annotated[str, 'Unit as text; ``""`` for a pure number.'] = ""
    doc: Annotated[str, "One line that says what it is."] = ""
    label: Annotated[str, "Axis label in mathtext; the name itself if empty."] = ""
    angle: Annotated[
        bool, "Whether it is an angle in rad: after a revolution the state is the same."
    ] = False


def check_state_name(name: str, what: str = "a state") -> None:
    """Refuse names that the compiled equations give to phase, coefficients and variations."""
    inside = ("c_", "p_", "carried_")
    if name == "phase" or name.startswith(inside):
        raise InputError(
            f"{what} cannot be called {name}: phase and names that begin with {', '.join(inside)} "
            f"are used inside; call it e.g. q_{name}"
        )


@dataclass(frozen=True)
class Output(Documented):
    """A scalar function of the state, the coefficients and the forcing phase."""

    name: Annotated[str, 'Name in results, e.g. ``"Vrel"``.']
    expression: Annotated[
        Callable[[Any, Symbols, Expression], Expression],
        "``expression(q, c, phase)`` with the states `q` and coefficients `c` by name and the "
        "forcing phase (one per period) as symbols; returns a symbolic expression.",
    ]
    unit: Annotated[str, "SI unit as text."] = ""
    doc: Annotated[str, "One line that says what it is."] = ""
    label: Annotated[str, "Axis label in mathtext; the name itself if empty."] = ""


@dataclass(frozen=True)
class Limit(Documented):
    """A bound of validity: the model holds while `output` stays above `bound` over the orbit."""

    name: Annotated[str, 'Short name, e.g. ``"stick"``.']
    output: Annotated[str, "Name of the output that is watched."]
    bound: Annotated[
        float,
        "Value at which a branch stops, in the unit of the output. It lies a little before the "
        "singularity itself, where no method can follow.",
    ]
    reason: Annotated[
        str, "The sentence to show; ``{value}`` is replaced by the minimum of the output."
    ]


STICK = 0.01
"""Slip speed over the speed of the moving surface at which a branch in slip ends."""

STICK_LIMIT = Limit(
    "stick",
    "Vrel_ratio",
    STICK,
    "stick: the relative speed fell to {value:.3g} of Vd; the sliding model ends here, raise Vd or "
    "stay below this value",
)
# A contact cannot pull: the branch ends just before the normal force vanishes.
PULSATING_LIMIT = Limit(
    "lost contact", "N", 1e-9, "lost contact: the normal force fell to {value:.3g} N; keep Nd < Ns"
)
# Where the length vanishes, the force of the spring has no direction.
COLLAPSE_LIMIT = Limit(
    "spring collapse",
    "l",
    1e-4,
    "spring collapsed: l/L fell to {value:.3g}; the model ends here, stay below this value",
)
