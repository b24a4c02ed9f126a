"""A response diagram as lines and marks."""

from __future__ import annotations

from typing import Any

from slipfold.branches.branch import Branch
from slipfold.branches.special_point import BIFURCATIONS, SpecialPoint
from slipfold.explorer.views.checked import checked_view
from slipfold.explorer.views.labels import axis_of
from slipfold.explorer.views.numbers import number, short
from slipfold.lines import measure_of, stretches_of
from slipfold.results.diagram import Diagram
from slipfold.text.one_line import certain


def diagram_view(diagram: Diagram, show: str, statistic: str) -> dict[str, Any]:
    """Return a diagram as plain data."""
    model = diagram.model
    return {
        "x": axis_of(model, diagram.vary),
        "y": {**axis_of(model, show), "statistic": statistic},
        "branches": [_branch(branch, show, statistic) for branch in diagram.branches],
        "checked": checked_view(diagram.checked),
    }


def _branch(branch: Branch, show: str, statistic: str) -> dict[str, Any]:
    x: list[float] = []
    y: list[float] = []
    s: list[float] = []
    stretches = []
    for line in stretches_of(branch, show, statistic):
        first = max(len(x) - 1, 0)
        skip = 1 if x else 0  # a stretch begins where the one before ends
        x += line.parameter[skip:].tolist()
        y += line.value[skip:].tolist()
        s += line.arclength[skip:].tolist()
        stretches.append({"kind": line.kind, "first": first, "last": len(x) - 1})
    return {
        "id": branch.id,
        "kind": branch.kind,
        "period": branch.period,
        "parent": branch.parent,
        "x": short(x),
        "y": short(y),
        "arclength": short(s),
        "stretches": stretches,
        "special": [
            _special(point, show, statistic)
            for point in branch.special
            if point.type in BIFURCATIONS
        ],
        "begun": _end(branch, "begun"),
        "stopped": _end(branch, "stopped"),
    }


def _special(point: SpecialPoint, show: str, statistic: str) -> dict[str, Any]:
    y = float(measure_of(point.orbit.extrema_of(show), show, statistic)[0])
    return {
        "type": point.type,
        "name": point.name,
        "value": certain(point.value, point.uncertainty),
        "uncertainty": number(point.uncertainty),
        "y": y,
        "arclength": point.arclength,
        "period": point.period,
        "criticality": point.criticality,
        "coefficient": number(point.coefficient),
        "leads_to": point.leads_to,
        "words": _words(point),
        "sentence": _sentence(point),
    }


def _words(point: SpecialPoint) -> str:
    return " ".join(filter(None, [point.criticality, point.name]))


def _sentence(point: SpecialPoint) -> str:
    unit = point.model.parameter(point.vary).unit
    value = certain(point.value, point.uncertainty)
    at = f"at {point.vary} = {value:.6g} {unit}".rstrip()
    lead = "" if point.leads_to is None else f"; branch {point.leads_to} leaves here"
    period = f" of period {point.period}" if point.model.forced else ""
    text = f"{_words(point)}{period} {at}{lead}"
    return text[0].upper() + text[1:]


def _end(branch: Branch, which: str) -> dict[str, Any]:
    end = branch.begun if which == "begun" else branch.stopped
    return {"kind": end.kind, "reason": end.reason, "value": number(end.value)}
