"""Parameters and states of a model: name, unit, bounds and meaning."""

from __future__ import annotations

import math
from dataclasses import dataclass

from slipfold.errors import InputError


@dataclass(frozen=True)
class Parameter:
    """A number a model depends on.

    Parameters
    ----------
    name
        The symbol used in formulas, arguments and files, e.g. ``"Nd"``.
    default
        Value in SI units where the user gives none.
    unit
        SI unit as text (``"N"``, ``"m/s"``, ``"rad"``), ``""`` for a pure number.
    doc
        One line that says what it is.
    lower, upper
        Bounds of what is allowed, in the unit of the parameter.
    lower_open, upper_open
        Whether the bound itself is excluded.
    symbol
        How figures write it (matplotlib mathtext); the name itself if empty.

    Examples
    --------
    >>> Parameter("mu", 0.5, "", "friction coefficient", lower=0).check(0.3)
    0.3
    """

    name: str
    default: float
    unit: str = ""
    doc: str = ""
    lower: float = -math.inf
    upper: float = math.inf
    lower_open: bool = False
    upper_open: bool = False
    symbol: str = ""

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

        Raises
        ------
        InputError
            If `value` is not finite or outside the bounds.
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
class State:
    """A state variable of a model.

    Parameters
    ----------
    name
        Name in results and on the command line, e.g. ``"vx"``.
    unit
        Unit as text; ``""`` for a pure number.
    doc
        One line that says what it is.
    label
        Axis label in mathtext; the name itself if empty.
    angle
        Whether it is an angle in rad: after a revolution the state is the same.

    Examples
    --------
    >>> State("x", "", "horizontal displacement over L", "$x/L$").label
    '$x/L$'
    """

    name: str
    unit: str = ""
    doc: str = ""
    label: str = ""
    angle: bool = False
