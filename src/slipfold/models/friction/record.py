"""Friction laws as tables of files and records: read, and written."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from slipfold.errors import InputError
from slipfold.models.definitions.source import Keys, Source
from slipfold.models.definitions.tables import read_part, type_name
from slipfold.models.friction.jenkins import Iwan, Jenkins
from slipfold.models.friction.law import FrictionLaw
from slipfold.models.friction.with_memory import BoucWen, Dahl, LuGre
from slipfold.models.friction.without_memory import (
    Coulomb,
    CoulombViscous,
    CubicStribeck,
    RationalStribeck,
    Regularised,
    Stribeck,
)
from slipfold.models.suggestion import suggest, unknown

_LAWS: tuple[type[FrictionLaw], ...] = (
    Coulomb,
    CoulombViscous,
    Stribeck,
    RationalStribeck,
    CubicStribeck,
    Regularised,
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

    >>> from slipfold.models.friction import RationalStribeck
    >>> law_record(RationalStribeck(mu_s=0.5, d=2.0))
    {'law': 'RationalStribeck', 'mu_s': 0.5, 'd': 2.0}
    """
    if type(law) not in _LAWS:
        raise InputError(
            f"{type(law).__name__} is not among the friction laws of the package, so it cannot be "
            "written to a file; write its values, and make it again when reading"
        )
    values = {item.name: _plain(getattr(law, item.name)) for item in dataclasses.fields(law)}
    # The law that is regularised is a field called `law` itself.
    return {"law": type(law).__name__, **{_key(name): value for name, value in values.items()}}


def law_from_record(record: Mapping[str, Any]) -> FrictionLaw:
    """Make a law from what `law_record` made of one.

    >>> law_from_record({"law": "RationalStribeck", "mu_s": 0.5, "d": 2.0})
    RationalStribeck(mu_s=0.5, d=2.0)
    """
    known = friction_laws()
    name = record.get("law")
    if name not in known:
        raise InputError(
            f"there is no friction law {name!r}; {suggest(str(name), known)}"
            f"there are {', '.join(known)}"
        )
    law = known[name]
    fields = {_key(item.name): item.name for item in dataclasses.fields(law)}
    values = {key: _restored(value) for key, value in record.items() if key != "law"}
    for key in values:
        if key not in fields:
            raise unknown(f"{name} has no parameter", key, fields)
    if law is Regularised and "of" not in values:
        raise InputError("Regularised needs the law that it regularises, as 'of'")
    return law(**{fields[key]: value for key, value in values.items()})


def _key(name: str) -> str:
    return "of" if name == "law" else name


def _plain(value: Any) -> Any:
    if isinstance(value, FrictionLaw):
        return law_record(value)
    return [_plain(item) for item in value] if isinstance(value, tuple) else value


def _restored(value: Any) -> Any:
    if isinstance(value, Mapping):
        return law_from_record(value)
    return tuple(_restored(item) for item in value) if isinstance(value, list) else value


def read_law(source: Source, path: Keys, value: object) -> FrictionLaw:
    """Make a friction law of what stands in a file.

    >>> from slipfold.models.definitions.source import source_of_tables
    >>> table = {"law": "Regularised", "of": "Coulomb", "e": "1 mm/s"}
    >>> read_law(source_of_tables({"friction": table}), ("friction",), table).law
    Coulomb(mu_s=0.5, mu_k=0.5)
    """
    law: FrictionLaw = read_part(
        source,
        path,
        value,
        friction_laws(),
        "law",
        readers={"of": read_law, "elements": _laws},
        fields={"of": "law"},
    )
    return law


def _laws(source: Source, path: Keys, value: Any) -> Any:
    if not isinstance(value, list | tuple):
        raise source.error(path, f"{path[-1]} is {type_name(value)}; give an array of laws")
    return tuple(read_law(source, (*path, str(n)), item) for n, item in enumerate(value))
