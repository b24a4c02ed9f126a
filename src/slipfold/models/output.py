"""What a model gives besides its equations: outputs and limits of validity."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

Expression = Any
"""A symbolic expression (`heyoka.expression`)."""

Symbols = Mapping[str, Expression]
"""Named symbolic expressions."""


@dataclass(frozen=True)
class Output:
    """A scalar function of the state, the coefficients and the forcing phase.

    Parameters
    ----------
    name
        Name in results, e.g. ``"Vrel"``.
    expression
        ``expression(q, c, phase)`` with the states `q` and coefficients `c` by name and the forcing
        phase (one per period) as symbols; returns a symbolic expression.
    unit
        SI unit as text.
    doc
        One line that says what it is.
    label
        Axis label in mathtext; the name itself if empty.
    """

    name: str
    expression: Callable[[Any, Symbols, Expression], Expression]
    unit: str = ""
    doc: str = ""
    label: str = ""


@dataclass(frozen=True)
class Limit:
    """A bound of validity: the model holds while `output` stays above `bound` over the orbit.

    Parameters
    ----------
    name
        Short name, e.g. ``"stick"``.
    output
        Name of the output that is watched.
    bound
        Value at which a branch stops, in the unit of the output. It lies a little before the
        singularity itself, where no method can follow.
    reason
        The sentence to show; ``{value}`` is replaced by the minimum of the output.
    """

    name: str
    output: str
    bound: float
    reason: str


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
