"""Friction laws in files: the name of a law, or a table with its values."""

from __future__ import annotations

from typing import Any

from slipfold.models.definitions.source import Source
from slipfold.models.definitions.toml_entries import type_name
from slipfold.models.definitions.toml_parts import read_part
from slipfold.models.definitions.toml_places import Path
from slipfold.models.friction.law import FrictionLaw
from slipfold.models.friction.record import friction_laws


def read_law(source: Source, path: Path, value: object) -> FrictionLaw:
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


def _laws(source: Source, path: Path, value: Any) -> Any:
    if not isinstance(value, list | tuple):
        raise source.error(path, f"{path[-1]} is {type_name(value)}; give an array of laws")
    return tuple(read_law(source, (*path, str(n)), item) for n, item in enumerate(value))
