"""Friction laws as tables of files and records: read, and written."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from slipfold.errors import InputError
from slipfold.models.definitions.source import Keys, Source
from slipfold.models.definitions.tables import part_table, read_part
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
from slipfold.text.validated import type_name

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
    """Return the friction laws that come with the package, by the names of their classes.

    >>> friction_laws()["Stribeck"](vs=0.2).vs
    0.2
    """
    return {law.__name__: law for law in _LAWS}


def law_record(law: FrictionLaw) -> dict[str, Any]:
    """Return a law as plain data for JSON.

    >>> from slipfold import RationalStribeck
    >>> law_record(RationalStribeck(mu_s=0.5, d=2.0))
    {'law': 'RationalStribeck', 'mu_s': 0.5, 'd': 2.0}
    """
    if type(law) not in _LAWS:
        raise InputError(
            f"{type(law).__name__} is not among the friction laws of the package, so it cannot be "
            "written to a file; write its values, and make it again when reading"
        )
    return part_table(law, "law", _plain)


def law_from_record(record: Mapping[str, Any]) -> FrictionLaw:
    """Make a law from what `law_record` made of one.

    >>> law_from_record({"law": "RationalStribeck", "mu_s": 0.5, "d": 2.0})
    RationalStribeck(mu_s=0.5, d=2.0)
    """
    return read_law(Source({}), ("friction",), record)


def _plain(value: Any) -> Any:
    if isinstance(value, FrictionLaw):
        return law_record(value)
    return [_plain(item) for item in value] if isinstance(value, tuple) else value


def read_law(source: Source, path: Keys, value: object) -> FrictionLaw:
    """Make a friction law of what stands in a file.

    >>> from slipfold.models.definitions.source import Source
    >>> table = {"law": "Regularized", "of": "Coulomb", "e": "1 mm/s"}
    >>> read_law(Source({"friction": table}), ("friction",), table).law
    Coulomb(mu_s=0.5, mu_k=0.5)
    """
    readers = {"of": read_law, "elements": _laws}
    law: FrictionLaw = read_part(source, path, value, friction_laws(), "law", readers)
    return law


def _laws(source: Source, path: Keys, value: Any) -> Any:
    if not isinstance(value, list | tuple):
        raise source.error(path, f"{path[-1]} is {type_name(value)}; give an array of laws")
    return tuple(read_law(source, (*path, str(n)), item) for n, item in enumerate(value))
