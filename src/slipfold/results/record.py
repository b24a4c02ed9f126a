"""A diagram as plain data for JSON: the schema slipfold.response/1 of the command line."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from slipfold.branches.branch import Branch, End
from slipfold.branches.special_point import SpecialPoint
from slipfold.results.checked_parts import checked_record
from slipfold.results.diagram_table import SCHEMA

if TYPE_CHECKING:
    from slipfold.models.model import Model
    from slipfold.results.diagram import Diagram

__all__ = ["diagram_record", "number", "numbers", "pairs", "record_head"]


def diagram_record(diagram: Diagram) -> dict[str, Any]:
    """Return special points and ends of all branches."""
    return {
        **record_head(SCHEMA, diagram.model),
        "vary": diagram.vary,
        "branches": [_branch_record(branch) for branch in diagram.branches],
        **checked_record(diagram.checked),
    }


def record_head(schema: str, model: Model) -> dict[str, Any]:
    """Return what every record begins with: its form and the model."""
    parameters = {name: number(value) for name, value in model.values.items()}
    return {"schema": schema, "model": model.name, "parameters": parameters}


def number(value: float | None) -> float | None:
    """Return a number that JSON can hold; what is not finite becomes None.

    Examples
    --------
    >>> number(float("inf")) is None
    True
    """
    return float(value) if value is not None and math.isfinite(value) else None


def numbers(values: Iterable[float]) -> list[float | None]:
    """Return numbers that JSON can hold."""
    return [number(value) for value in values]


def pairs(values: Iterable[complex]) -> list[list[float | None]]:
    """Return complex numbers as pairs that JSON can hold."""
    return [numbers((value.real, value.imag)) for value in values]


def _branch_record(branch: Branch) -> dict[str, Any]:
    return {
        "id": branch.id,
        "kind": branch.kind,
        "period": branch.period,
        "parent": branch.parent,
        "points": len(branch),
        "special": [_point_record(point, branch.kind) for point in branch.special],
        "begun": _end_record(branch.begun),
        "stopped": _end_record(branch.stopped),
    }


def _end_record(end: End) -> dict[str, Any]:
    return {"kind": end.kind, "reason": end.reason, "value": number(end.value)}


def _point_record(point: SpecialPoint, kind: str) -> dict[str, Any]:
    # An equilibrium has no duration, but at a Hopf point that of the cycle born there.
    lasts = kind != "equilibrium" or point.type == "HB"
    return {
        "type": point.type,
        "name": point.name,
        "value": number(point.value),
        "uncertainty": number(point.uncertainty),
        "duration": number(point.duration) if lasts else None,
        "state": numbers(point.state),
        "multipliers": pairs(point.multipliers),
        "multiplier_uncertainty": numbers(point.multiplier_uncertainty),
        "criticality": point.criticality,
        "undecided": point.undecided,
        "coefficient": number(point.coefficient),
        "leads_to": point.leads_to,
    }
