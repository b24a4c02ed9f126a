"""The table of all special points of all curves."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping

from slipfold.branches.branch import Branch
from slipfold.branches.special_point import SpecialPoint
from slipfold.paper.cases import Cases, Curve
from slipfold.plots.response import HasBranches

PARAMETERS = ("f", "Nd", "Ns", "mu", "alpha", "Vd")

COLUMNS = (
    "figures",
    "curve",
    "vary",
    *PARAMETERS,
    "branch",
    "period",
    "type",
    "name",
    "value",
    "uncertainty",
    "criticality",
    "coefficient",
    "leads_to",
    "x",
    "y",
    "vx",
    "vy",
    "multiplier_real",
    "multiplier_imag",
)
"""Columns; SI units, angles in radians, x and y over L, their rates in 1/s."""


def thresholds_csv(cases: Cases, diagrams: Mapping[Curve, HasBranches]) -> str:
    """Return every special point of every curve as comma-separated values.

    Numbers are written so that they read back exactly. What has no value is empty.
    """
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for curve in cases.needs:
        if not isinstance(curve, Curve) or curve not in diagrams:
            continue
        for branch in diagrams[curve].branches:
            for point in branch.special:
                writer.writerow(_cells(cases, curve, branch, point))
    return text.getvalue()


def _cells(cases: Cases, curve: Curve, branch: Branch, point: SpecialPoint) -> dict[str, object]:
    critical = point.critical_multiplier
    states = zip(point.model.states, point.state, strict=True)
    return {
        "figures": " ".join(str(number) for number in cases.shown_in(curve)),
        "curve": curve.key,
        "vary": curve.vary,
        **{name: point.model.values[name] for name in PARAMETERS},
        "branch": branch.id,
        "period": branch.period,
        "type": point.type,
        "name": point.name,
        "value": float(point.value),
        "uncertainty": float(point.uncertainty),
        "criticality": point.criticality,
        "coefficient": None if point.coefficient is None else float(point.coefficient),
        "leads_to": point.leads_to,
        **{state.name: float(value) for state, value in states},
        "multiplier_real": None if critical is None else critical.real,
        "multiplier_imag": None if critical is None else critical.imag,
    }
