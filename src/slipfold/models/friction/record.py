"""Friction laws as tables of files and records: read, and written."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from slipfold.errors import InputError
from slipfold.models.definitions.source import Source
from slipfold.models.definitions.tables import WrongEntry, part_table, read_part, type_name
from slipfold.models.friction.jenkins import Iwan, Jenkins
from slipfold.models.friction.law import FrictionLaw
from slipfold.models.friction.with_memory import BoucWen, Dahl, LuGre
from slipfold.models.friction.without_memory import (
    Coulomb,
    CoulombViscous,
    CubicStribeck,
    RationalStribeck,
    Regularized,
    Stribeck,
)

_LAWS: tuple[type[FrictionLaw], ...] = (
    Coulomb,
    CoulombViscous,
    Stribeck,
    RationalStribeck,
    CubicStribeck,
    Regularized,
    Dahl,
    LuGre,
    BoucWen,
    Jenkins,
    Iwan,
)


def friction_laws() -> dict[str, type[FrictionLaw]]:
    """Return the friction laws that come with the package, by the names of their classes."""
    return {law.__name__: law for law in _LAWS}


def law_record(law: FrictionLaw) -> dict[str, Any]:
    """Return a law as plain data for JSON."""
    if type(law) not in _LAWS:
        raise InputError(
            f"{type(law).__name__} is not among the friction laws of the package, so it cannot be "
            "written to a file; write its values, and make it again when reading"
        )
    return part_table(law, "law", _plain)


def law_from_record(record: Mapping[str, Any]) -> FrictionLaw:
    """Make a law from what `law_record` made of one."""
    return Source({}).read(read_law, record, ("friction",))


def _plain(value: Any) -> Any:
    if isinstance(value, FrictionLaw):
        return law_record(value)
    return [_plain(item) for item in value] if isinstance(value, tuple) else value


def read_law(given: Any) -> FrictionLaw:
    """Make a friction law from an entry of a file; raise `WrongEntry` if it is wrong."""
    return read_part(given, friction_laws(), "law", {"of": read_law, "elements": _laws})


def _laws(given: Any) -> tuple[FrictionLaw, ...]:
    if not isinstance(given, list | tuple):
        raise WrongEntry(f"is {type_name(given)}; give an array of laws")
    laws = []
    for number, item in enumerate(given):
        try:
            laws.append(read_law(item))
        except WrongEntry as wrong:
            raise wrong.below([str(number)]) from None
    return tuple(laws)
