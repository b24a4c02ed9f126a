"""A structure as plain data: the tables that its file would have."""

from __future__ import annotations

import dataclasses
from typing import Any

from slipfold.models.friction.law import FrictionLaw
from slipfold.models.friction.record import law_record
from slipfold.models.structures.components.direction import Direction
from slipfold.models.structures.components.normal_loads import NormalLoad
from slipfold.models.structures.definition import Definition
from slipfold.models.structures.matrices.damping import Damping
from slipfold.models.structures.matrices.matrices import Matrix
from slipfold.models.structures.matrices.matrix_reader import matrix_table


def structure_tables(definition: Definition) -> dict[str, Any]:
    """Return a structure as tables that `read_structure` reads: numbers, texts, lists, mappings."""
    damping = definition.C
    tables = {
        "name": definition.name,
        "title": definition.title,
        "structure": {
            "M": matrix_table(definition.M),
            "K": matrix_table(definition.K),
            **({"C": matrix_table(damping)} if isinstance(damping, Matrix) else {}),
            **({"triangles": "whole"} if _has_whole_triangle(definition) else {}),
            "names": list(definition.names),
            "length_scale": definition.length_scale,
        },
        "damping": _part(damping) if isinstance(damping, Damping) else None,
        "reduction": None if definition.reduction is None else _part(definition.reduction),
        "elements": [_part(item) for item in definition.elements],
        "contacts": [_part(item) for item in definition.contacts],
        "forcing": [_part(item) for item in definition.forcing],
        "watch": {name: _plain(direction) for name, direction in definition.watch},
    }
    return {name: table for name, table in tables.items() if table}


def _has_whole_triangle(definition: Definition) -> bool:
    """Whether a matrix would be read as half of a symmetric one."""
    matrices = (definition.C, definition.K)
    return any(isinstance(item, Matrix) and item.one_sided for item in matrices)


def _part(part: Any) -> dict[str, Any]:
    """A part by the name of its class, with the arguments that make it again."""
    arguments = {
        "friction" if isinstance(value, FrictionLaw) else item.name: _plain(value)
        for item in dataclasses.fields(part)
        if (value := getattr(part, item.name)) is not None and value != ""
    }
    return {"type": type(part).__name__, **arguments}


def _plain(value: Any) -> Any:
    if isinstance(value, Direction):
        name, weight = value.weights[0]
        return name if len(value.weights) == 1 and weight == 1 else dict(value.weights)
    if isinstance(value, FrictionLaw):
        return law_record(value)
    if isinstance(value, NormalLoad):
        return _part(value)
    if isinstance(value, tuple):
        if value and all(isinstance(item, tuple) for item in value):
            # Coefficients by power or harmonic: a file has them as a table.
            return {str(key): _sole(rest) for key, *rest in value}
        return [_plain(item) for item in value]
    return value


def _sole(values: list[Any]) -> Any:
    return values[0] if len(values) == 1 else values
