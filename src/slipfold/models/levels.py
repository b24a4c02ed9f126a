"""Levels in decibels of outputs."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import NamedTuple

from slipfold.errors import InputError, unknown
from slipfold.models.model import Model
from slipfold.models.quantities import Output, State
from slipfold.models.units import parse_quantity


class Reference(NamedTuple):
    """What the level of an output is relative to."""

    value: float  # in the unit of the output
    text: str  # as it is written beside dB
    decade: float  # dB of a factor of ten: 20 of a field, 10 of a power or an energy

    def level(self, size: float) -> float:
        """Return the level of a size; minus infinity if it is zero."""
        return self.decade * math.log10(size / self.value) if size > 0 else -math.inf


POWERS = ("W", "J")
"""Units of outputs whose mean is their size; that of others is their root mean square."""

STANDARD = {
    "m": (1e-12, "1 pm"),
    "m/s": (1e-9, "1 nm/s"),
    "m/s^2": (1e-6, "1 um/s^2"),
    "N": (1e-6, "1 uN"),
    "Pa": (20e-6, "20 uPa"),
    "W": (1e-12, "1 pW"),
    "J": (1e-12, "1 pJ"),
}
"""References of ISO 1683 by unit."""


def quantity_of(model: Model, name: str, others: Collection[str] = ()) -> State | Output:
    """Return a state or output by name, or raise an error that knows other names as well."""
    items: dict[str, State | Output] = {item.name: item for item in model.states}
    items |= {item.name: item for item in model.outputs()}
    if name not in items:
        raise unknown(f"{model.name} has no output", name, [*items, *others])
    return items[name]


def reference_of(unit: str, given: float | str | None = None) -> Reference:
    """Return the reference of levels of an output: that of ISO 1683, or a given one.

    >>> round(reference_of("m").level(1e-6))
    120
    >>> reference_of("m", "1 um").text
    '1 um'
    """
    decade = 10.0 if unit in POWERS else 20.0
    if given is None:
        if unit not in STANDARD:
            of = f"in {unit}" if unit else "without unit"
            raise InputError(
                f"no standard has a reference for outputs {of}; give one, such as reference=1"
            )
        return Reference(*STANDARD[unit], decade)
    value = parse_quantity(given, unit, "reference")
    if not 0 < value < math.inf:
        raise InputError(f"reference = {value:g} {unit}; give a finite number > 0")
    text = given.strip() if isinstance(given, str) else f"{value:g}"
    bare = text.replace(".", "").replace("-", "").replace("e", "").isdigit()
    return Reference(value, f"{text} {unit}".strip() if bare else text, decade)
