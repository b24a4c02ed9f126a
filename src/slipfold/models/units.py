"""Numbers with units as people write them: ``60deg``, ``5mm``, ``0.6 m/s``, ``8/3``, ``pi/4``."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping
from typing import Any

import numpy as np

from slipfold.errors import InputError
from slipfold.models.quantities import Parameter

_UNITS: dict[str, dict[str, float]] = {
    "": {"%": 1e-2},
    "rad": {"rad": 1.0, "deg": math.pi / 180, "°": math.pi / 180},
    "rad/s": {"rad/s": 1.0, "rpm": math.pi / 30},
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9},
    "N": {"N": 1.0, "uN": 1e-6, "mN": 1e-3, "kN": 1e3, "MN": 1e6},
    "Hz": {"Hz": 1.0, "mHz": 1e-3, "kHz": 1e3, "MHz": 1e6, "GHz": 1e9},
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6},
    "kg": {"kg": 1.0, "g": 1e-3, "t": 1e3},
    "m/s": {"m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2, "m/min": 1 / 60, "km/h": 1 / 3.6},
    "N/m": {"N/m": 1.0, "kN/m": 1e3, "N/mm": 1e3, "MN/m": 1e6, "N/um": 1e6, "kN/mm": 1e6},
}
"""Units in which a quantity may be given, and their factors, by its SI unit."""

_QUANTITY = re.compile(
    r"\s*([-+−]?(?:[0-9]+\.?[0-9]*(?:e[-+−]?[0-9]+)?|\.[0-9]+(?:e[-+−]?[0-9]+)?|inf|nan))"
    r"(\s*[^0-9.,\s].*?|\s+1/.*?|)\s*",
    re.IGNORECASE,
)
"""The page reads numbers in the same way, without arithmetic: explorer/page/quantities.js."""

_COMMA = re.compile(r"\s*[-+−]?[0-9]+,[0-9]+(?![0-9.,])")
"""What is meant as a decimal comma: one that digits and no point surround."""

_SYMBOLS = (
    *(*"mgsAKNJWVCFSTHΩLlMUP", "Hz", "Pa", "mol", "cd", "Wb", "ohm", "bar", "eV", "Wh", "Ah"),
    *("Bq", "Gy", "Sv", "kat", "lm", "lx", "cal", "Da", "dyn", "erg", "St", "Torr", "VA"),
)
"""Symbols of units that may have a prefix."""

_PREFIXES = ("", *"TGMkhdcmunpfµμ")

_WORDS = """
rad mrad sr deg arcmin arcsec rpm rps rev turn cycle cycles degC degF dB Np Å ha ppm ppb IU
min h hr d day days week month yr year years t daN kgf gf tf mmHg atm hp BTU Btu cell cells
psi ksi slug lb lbs lbm lbf kip oz ozf in inch ft yd mi mph gal
"""

_KNOWN = {*(prefix + symbol for prefix in _PREFIXES for symbol in _SYMBOLS), *_WORDS.split()}
"""Words that units consist of."""

_MEANT = {
    **{unit.lower(): unit for unit in ("Hz", "kHz", "MHz", "kg", "N", "kN", "Pa", "rad", "deg")},
    **dict.fromkeys(("sec", "secs", "second", "seconds", "ss"), "s"),
    **dict.fromkeys(("meter", "meters", "metre", "metres"), "m"),
    **dict.fromkeys(("newton", "newtons"), "N"),
    **dict.fromkeys(("radian", "radians", "rads"), "rad"),
    **dict.fromkeys(("degree", "degrees", "degs"), "deg"),
    **dict.fromkeys(("kilo", "kilos", "kilogram", "kilograms", "kgs"), "kg"),
    **dict.fromkeys(("hour", "hours", "hrs"), "h"),
    **dict.fromkeys(("minute", "minutes", "mins"), "min"),
    **{
        unit.replace(" ", "").lower(): unit
        for unit in ("N m", "kN m", "N mm", "N s", "N m s", "kg m")
    },
    "hertz": "Hz",
    "pascal": "Pa",
    "feet": "ft",
}
"""The unit that is meant by a word in small letters."""


def check_unit(unit: str) -> str:
    """Return the unit of an entry, or refuse one with a word that is no unit.

    >>> check_unit("N s/m"), check_unit("1/yr")
    ('N s/m', '1/yr')
    """
    for word in re.findall(r"[^\W\d_]+", unicodedata.normalize("NFKC", unit)):  # ² becomes 2
        if word not in _KNOWN:
            meant = _MEANT.get(word.lower())
            hint = f"did you mean {meant}? " if meant else ""
            raise InputError(
                f"the unit {unit!r} has {word!r}, which is no known unit; {hint}write e.g. m/s, "
                f"N s/m or 1/s, of {', '.join(_SYMBOLS[:12])}, Hz, Pa, mol, rad, deg, min, h, d, "
                "yr, or leave the unit out and name it in doc"
            )
    return unit


def units_of(unit: str) -> dict[str, float]:
    """Return the units in which a quantity may be given, and their factors to the SI unit."""
    return dict(sorted(_UNITS.get(unit, {unit: 1.0}).items()))


def wanted_text(unit: str) -> str:
    """Return the accepted forms of a quantity, for messages."""
    return (
        f"a number, or a number with one of the units {', '.join(units_of(unit))}"
        if unit
        else "a number"
    )


def parse_quantity(text: str | float, unit: str, name: str = "value") -> float:
    """Convert a number or arithmetic of numbers, with an optional unit, to the SI value."""
    if type(text) is float:  # as nearly all are
        return text
    if isinstance(text, bool):
        raise InputError(f"{name} = {text} is not a number; give a number")
    if not isinstance(text, str):
        try:
            return float(text)
        except (TypeError, ValueError, OverflowError):
            raise InputError(f"{name} = {text!r} is not a number; give a number") from None
    match = _QUANTITY.fullmatch(text)
    suffix = "" if match is None else match.group(2).lstrip()
    factor = units_of(unit).get(suffix) if suffix else 1.0
    if match is not None and factor is not None:
        return float(match.group(1).replace("−", "-")) * factor
    calculated = _calculated(text.replace("−", "-"), units_of(unit))
    if calculated is not None:
        return calculated
    wrong = f"has the unit {suffix!r}" if suffix else "is not a number"
    if match is None and _COMMA.match(text):
        wrong = f"has a decimal comma, write {text.strip().replace(',', '.', 1)}"
    wanted = wanted_text(unit)
    if suffix.startswith(("*", "+", "-", "^")) or (match is None and "*" in text):
        wrong = "is no calculation of numbers"
        wanted += "; what depends on states is written into the equations of a System"
    raise InputError(f"{name} = {text!r} {wrong}; give {wanted}")


def _calculated(text: str, units: Mapping[str, float]) -> float | None:
    """Return the value of arithmetic with an optional unit; None if the text is not arithmetic."""
    # The grammar of formulas takes long to load; most numbers do without it.
    from slipfold.models.formulas.functions import CONSTANTS
    from slipfold.models.formulas.grammar import (
        FormulaError,
        Negative,
        Number,
        names_in,
        parse_formula,
    )
    from slipfold.models.formulas.values import value_of

    for unit, factor in {"": 1.0, **units}.items():
        try:
            tree = parse_formula(text.strip().removesuffix(unit))
        except FormulaError:
            continue
        unsigned = tree.argument if isinstance(tree, Negative) else tree
        single = isinstance(unsigned, Number | Negative)  # "--3" is a typing error
        if not single and set(names_in(tree)) <= set(CONSTANTS):
            return float(value_of(tree, CONSTANTS)) * factor
    return None


def pair(given: Any, sentence: str) -> tuple[Any, Any]:
    """Return both items of a pair; text is none, even of two letters."""
    try:
        items = tuple(given)
    except TypeError:
        items = ()
    if isinstance(given, str) or len(items) != 2:
        raise InputError(sentence)
    return items[0], items[1]


def interval(
    parameter: Parameter, given: Any, what: str = "span", rising: bool = False
) -> tuple[float, float]:
    """Return two different values of a parameter, in SI units, or raise."""
    unit, name = parameter.unit, parameter.name
    ends = pair(
        given, f"the {what} of {name} is {given!r}, which is not a pair of numbers; give two values"
    )
    for end in ends:
        if isinstance(end, bool | np.bool_):
            raise InputError(f"the {what} of {name} holds {end}, which is not a number; give one")
    first, last = (parameter.check(parse_quantity(end, unit, name)) for end in ends)
    if first == last or (rising and first > last):
        how = "the lower value first" if rising else "two different values"
        raise InputError(f"the {what} of {name} from {first:g} to {last:g} is empty; give {how}")
    return first, last
