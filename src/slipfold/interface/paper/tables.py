"""Tables of the results: special points, and the summary of each bifurcation set."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.interface.paper.cases import Case, Cases, Figure
from slipfold.results.tables import Frame


def number(value: float | None) -> str:
    """Return a number with six digits, or that there is none.

    >>> number(0.043578911491), number(None)
    ('0.0435789', 'none')
    """
    return "none" if value is None else f"{value:.6g}"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table.

    >>> print(table(["f (Hz)", "PD"], [["12.5", "0.0436"]]))
    | f (Hz) | PD |
    |---|---|
    | 12.5 | 0.0436 |
    """
    lines = [head, ["---"] * len(head), *rows]
    joined = ["| " + " | ".join(line) + " |" for line in lines]
    joined[1] = "|" + "---|" * len(head)
    return "\n".join(joined)


PARAMETERS = ("f", "Nd", "Ns", "mu", "alpha", "Vd")

COLUMNS = (
    *("figures", "curve", "vary", *PARAMETERS, "branch", "period", "type", "name", "value"),
    *("uncertainty", "criticality", "coefficient", "leads_to", "x", "y", "vx", "vy"),
    *("multiplier_real", "multiplier_imag"),
)
"""Columns; SI units, angles in radians, x and y over L, their rates in 1/s."""


def thresholds_csv(cases: Cases, results: Mapping[Case, Any]) -> str:
    """Return every special point of every curve as comma-separated values.

    Numbers are written so that they read back exactly. What has no value is empty.
    """
    rows = [
        _cells(cases, curve, branch, point)
        for curve in cases.needs
        if curve.kind == "response" and curve in results
        for branch, point in results[curve].special
    ]
    return Frame({name: [row[name] for row in rows] for name in COLUMNS}, {}).to_csv()


def _cells(cases: Cases, curve: Case, branch: Branch, point: SpecialPoint) -> dict[str, object]:
    critical = point.critical_multiplier
    states = zip(point.model.states, point.state, strict=True)
    return {
        "figures": " ".join(str(number) for number in cases.shown_in(curve)),
        "curve": curve.key,
        "vary": point.vary,
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


def planes_markdown(figures: Sequence[Figure], results: Mapping[Case, Any]) -> str:
    """Return the summary of each bifurcation set as Markdown."""
    parts = [
        "# Bifurcation sets",
        "Loci of LP, PD and NS of the responses of period 1 and 2, beyond what the source paper "
        "shows. What is not varied has the value of the base case: f = 12.5 Hz, Vd = 0.6 m/s, "
        "Ns = 1 N, mu = 0.5, alpha = 60°. The files in `data` have all digits, with the computed "
        "uncertainty of each point.",
    ]
    for figure in figures:
        (plane,) = figure.cases
        parts.append(f"## {figure.title}: {plane.vary[0]} and {plane.vary[1]}")
        diagram = results.get(plane)
        parts.append("Not computed." if diagram is None else f"```text\n{diagram.summary()}\n```")
    return "\n\n".join(parts) + "\n"
