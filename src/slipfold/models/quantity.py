"""Numbers with units as people write them: ``60deg``, ``5mm``, ``12.5Hz``, ``0.6 m/s``."""

from __future__ import annotations

import math
import re

from slipfold.errors import InputError

__all__ = ["parse_quantity", "units_of", "wanted_text"]

_FACTORS: dict[str, tuple[str, float]] = {
    "deg": ("rad", math.pi / 180),
    "°": ("rad", math.pi / 180),
    "rad": ("rad", 1.0),
    "m": ("m", 1.0),
    "cm": ("m", 1e-2),
    "mm": ("m", 1e-3),
    "um": ("m", 1e-6),
    "N": ("N", 1.0),
    "mN": ("N", 1e-3),
    "kN": ("N", 1e3),
    "Hz": ("Hz", 1.0),
    "kHz": ("Hz", 1e3),
    "mHz": ("Hz", 1e-3),
    "s": ("s", 1.0),
    "ms": ("s", 1e-3),
    "kg": ("kg", 1.0),
    "g": ("kg", 1e-3),
    "m/s": ("m/s", 1.0),
    "mm/s": ("m/s", 1e-3),
    "cm/s": ("m/s", 1e-2),
    "N/m": ("N/m", 1.0),
    "kN/m": ("N/m", 1e3),
    "N/mm": ("N/m", 1e3),
    "N s/m": ("N s/m", 1.0),
    "rad/s": ("rad/s", 1.0),
    "1/s": ("1/s", 1.0),
    "%": ("", 1e-2),
}

_QUANTITY = re.compile(
    r"\s*([-+−]?(?:[0-9]+\.?[0-9]*(?:e[-+−]?[0-9]+)?|\.[0-9]+(?:e[-+−]?[0-9]+)?|inf|nan))"
    r"(\s*[^0-9.,\s].*?|\s+1/.*?|)\s*",
    re.IGNORECASE,
)
"""The page reads numbers in the same way: explorer/page/quantity_text.js."""


def units_of(unit: str) -> dict[str, float]:
    """Return the units in which a quantity may be given, and what each is in its SI unit.

    >>> units_of("N")
    {'N': 1.0, 'kN': 1000.0, 'mN': 0.001}
    """
    known = {text: factor for text, (kind, factor) in sorted(_FACTORS.items()) if kind == unit}
    return known if unit in known or not unit else {unit: 1.0, **known}


def wanted_text(unit: str) -> str:
    """Return what may be given for a quantity, as the end of a sentence.

    >>> wanted_text("m")
    'a number, or a number with one of the units cm, m, mm, um'
    """
    return (
        f"a number, or a number with one of the units {', '.join(units_of(unit))}"
        if unit
        else "a number"
    )


def parse_quantity(text: str | float, unit: str, name: str = "value") -> float:
    """Convert a number with an optional unit to the SI value.

    >>> parse_quantity("5mm", "m")
    0.005
    """
    if not isinstance(text, str):
        try:
            return float(text)
        except (TypeError, ValueError, OverflowError):
            raise InputError(f"{name} = {text!r} is not a number; give a number") from None
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise InputError(f"{name} = {text!r} is not a number; give {wanted_text(unit)}")
    number, suffix = float(match.group(1).replace("−", "-")), match.group(2).lstrip()
    factor = units_of(unit).get(suffix) if suffix else 1.0
    if factor is None:
        raise InputError(f"{name} = {text!r} has the unit {suffix!r}; give {wanted_text(unit)}")
    return number * factor
