"""The points of a diagram that get a marker and a name: bifurcations, limits, failures, events."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from slipfold.branches.branch import Branch
from slipfold.branches.special_point import SpecialPoint
from slipfold.lines.of_branches import measured_along, measured_at
from slipfold.models.model import Model
from slipfold.plots.style import MARKERS


@dataclass(frozen=True)
class Mark:
    """A marked point."""

    type: str  # key of `slipfold.plots.style.MARKERS`
    name: str  # what stands beside it
    # Where it is
    parameter: float
    value: float
    hollow: bool = False  # whether the marker is open: a subcritical bifurcation


def marks_of(branch: Branch, output: str, measure: str = "max") -> tuple[Mark, ...]:
    """Return the marks of a branch."""
    found = [*_special(branch, output, measure), *_end(branch, output, measure)]
    return tuple(mark for mark in found if np.isfinite(mark.value))


def limit_name(model: Model, reason: str) -> str:
    """Return one word for a limit of a model, e.g. ``"collapse"``."""
    for limit in model.limits:
        if reason.startswith(limit.reason.partition("{")[0]):
            return limit.name.split()[-1]
    return "limit"


def _special(branch: Branch, output: str, measure: str) -> Iterator[Mark]:
    for point in branch.special:
        # A branch point lies on two branches; the one met first marks it.
        again = point.type == "BP" and (point.leads_to or branch.id) < branch.id
        if point.type in MARKERS and not again:
            value = measured_at(point, output, measure)
            hollow = point.criticality == "subcritical"
            yield Mark(point.type, _short_name(point), float(point.value), value, hollow)


def _end(branch: Branch, output: str, measure: str) -> Iterator[Mark]:
    if len(branch) == 0 or branch.stopped.kind not in ("limit", "failed"):
        return
    value = float(measured_along(branch, output, measure)[-1])
    place = float(branch.parameter[-1]), value
    if branch.stopped.kind == "failed":
        yield Mark("FAILED", "", *place)
        return
    yield Mark("LIMIT", limit_name(branch.model, branch.stopped.reason), *place)


def _short_name(point: SpecialPoint) -> str:
    return point.name if point.type == "EVENT" else point.type
