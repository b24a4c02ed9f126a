"""What was computed, as tables: special points, and the bifurcation sets in words."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from slipfold.branches.branch import Branch
from slipfold.branches.special_point import SpecialPoint
from slipfold.lines import locus_segments
from slipfold.loci.locus import CODIMENSION_TWO, Locus, LocusPoint
from slipfold.loci.region_map import Region
from slipfold.models.parameter import Parameter
from slipfold.paper.cases import Cases, Curve, Plane, PlaneFigure
from slipfold.plots.loci import HasLoci
from slipfold.plots.response import HasBranches
from slipfold.plots.style import quantity_text


def number(value: float | None, missing: str = "none") -> str:
    """Return a number with six digits, or what stands for none.

    >>> number(0.043578911491), number(None)
    ('0.0435789', 'none')
    """
    return missing if value is None else f"{value:.6g}"


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


def planes_markdown(figures: Sequence[PlaneFigure], diagrams: Mapping[Plane, HasLoci]) -> str:
    """Return what was found in each plane as Markdown."""
    parts = [
        "# Bifurcation sets",
        "Loci of LP, PD and NS of the responses of period 1 and 2, beyond what the source paper "
        "shows. What is not varied has the value of the base case: f = 12.5 Hz, Vd = 0.6 m/s, "
        "Ns = 1 N, mu = 0.5, alpha = 60°. Uncertainties are how much values move when the orbit "
        "and its derivatives are integrated anew with other steps.",
    ]
    for figure in figures:
        parts.append(f"## {figure.title}: {figure.plane.vary[0]} and {figure.plane.vary[1]}")
        diagram = diagrams.get(figure.plane)
        parts += ["Not computed."] if diagram is None else _sections(diagram)
    return "\n\n".join(parts) + "\n"


def _sections(diagram: HasLoci) -> Iterator[str]:
    doublings = [locus for locus in diagram.loci if (locus.type, locus.period) == ("PD", 1)]
    for locus in doublings:
        yield _criticality(locus)
        yield _lowest(locus)
    if not doublings:
        yield "The response of period 1 has no PD in this window."
    yield _loci(diagram.loci)
    for title, types in (
        ("Points of codimension two", tuple(CODIMENSION_TWO)),
        ("Extrema of the loci", ("MIN", "MAX")),
    ):
        result = [(o, p) for o in diagram.loci for p in o.special if p.type in types]
        yield f"{title}: " + (f"{len(result)}.\n\n{_points(result)}" if result else "none.")
    if diagram.regions is not None:
        yield _regions(diagram.regions.regions, _parameters_of(diagram))


# -- the threshold of period 1 -----------------------------------------------------------------


def _criticality(locus: Locus) -> str:
    """Return where along the locus the PD is supercritical and where subcritical."""
    first, second = _parameters_of(locus)
    stretches = locus_segments(locus)
    turns = [point for point in locus.special if point.type == "GPD"]
    if not turns:
        kind = stretches[0].kind if stretches else ""
        return f"**The PD of period 1 is {kind or 'of unknown criticality'} throughout.**"
    spans = []
    for stretch in stretches:
        low, high = np.sort(stretch.points[[0, -1], 0])
        spans.append(
            f"{stretch.kind} for {first.name} from {quantity_text(first, low, 8)} to "
            f"{quantity_text(first, high, 8)}"
        )
    places = "; ".join(_place((first, second), point) for point in turns)
    return (
        "**The criticality of the PD of period 1 changes at the generalized period doubling GPD, "
        f"{places}.** It is {', '.join(spans)}."
    )


def _lowest(locus: Locus) -> str:
    """Return where the threshold is lowest: at a minimum of the locus, or at an end."""
    parameters = first, second = _parameters_of(locus)
    minima = [
        point
        for point in locus.special
        if point.type == "MIN" and point.name.endswith(f" {second.name}")
    ]
    end = locus.values[locus.values[:, 1].argmin()]
    if minima:
        least = min(minima, key=lambda point: point.values[1])
        if least.values[1] <= end[1]:
            return f"**The threshold is lowest at {_place(parameters, least)}** (MIN)."
    return (
        f"**The threshold is lowest at an end of the locus, {first.name} = "
        f"{quantity_text(first, end[0], 8)}: {second.name} = {quantity_text(second, end[1], 8)}.**"
    )


def _place(parameters: Sequence[Parameter], point: LocusPoint) -> str:
    return ", ".join(
        f"{parameter.name} = {quantity_text(parameter, value, 10)} "
        f"(± {_shown(parameter, uncertainty):.1g})"
        for parameter, value, uncertainty in zip(
            parameters, point.values, point.uncertainty, strict=True
        )
    )


# -- tables ------------------------------------------------------------------------------------


def _loci(loci: Sequence[Locus]) -> str:
    rows = [
        [
            str(locus.id),
            f"{locus.type} of period {locus.period}",
            str(len(locus)),
            _end(locus, locus.begun.values),
            locus.begun.reason,
            _end(locus, locus.stopped.values),
            locus.stopped.reason,
        ]
        for locus in loci
    ]
    return table(["", "locus", "points", "from", "because", "to", "because"], rows)


def _end(locus: Locus, values: tuple[float, ...]) -> str:
    return ", ".join(
        f"{parameter.name} = {quantity_text(parameter, value, 6)}"
        for parameter, value in zip(_parameters_of(locus), values, strict=True)
    )


def _points(result: Sequence[tuple[Locus, LocusPoint]]) -> str:
    parameters = _parameters_of(result[0][0])
    rows = []
    for locus, point in result:
        values = zip(parameters, point.values, point.uncertainty, strict=True)
        cells = [
            cell
            for parameter, value, uncertainty in values
            for cell in (
                f"{_shown(parameter, value):.10g}",
                f"{_shown(parameter, uncertainty):.1e}",
            )
        ]
        forms = ", ".join(f"{name} = {value:.6g}" for name, value in point.coefficients.items())
        rows.append([point.type, point.name, f"{locus.id} ({locus.type})", *cells, forms or "none"])
    head = ["", "name", "on locus"]
    for parameter in parameters:
        head += [_head(parameter), "±"]
    return table([*head, "normal form"], rows)


def _regions(regions: Sequence[Region], parameters: Sequence[Parameter]) -> str:
    checks = [check for region in regions for check in region.checks]
    agreeing = sum(check.agrees for check in checks)
    rows = []
    for region in regions:
        place = [
            f"{_shown(parameter, value):.6g}"
            for parameter, value in zip(parameters, region.place, strict=True)
        ]
        settled = [f"from {_start(c.start)}: {_settled(c.settled)}" for c in region.checks]
        agree = sum(check.agrees for check in region.checks)
        verdict = f"{agree} of {len(region.checks)} agree" if region.checks else "none"
        rows.append(
            [
                str(region.id),
                region.name,
                f"{region.share:.2%}",
                *place,
                verdict,
                "; ".join(settled) or "none",
            ]
        )
    head = ["", "stable", "share", *(_head(item) for item in parameters)]
    counts = Counter(region.name for region in regions)
    kinds = ", ".join(f"{name} ({count})" for name, count in counts.items())
    return (
        f"Regions by their stable responses: {kinds}. Simulations that agree: {agreeing} of "
        f"{len(checks)}.\n\n" + table([*head, "simulations", "which settle on"], rows)
    )


def _start(start: str) -> str:
    return start if start in ("rest", "elsewhere") else f"beside {start}"


def _settled(period: int) -> str:
    return f"period {period}" if period else "nothing periodic"


# -- quantities --------------------------------------------------------------------------------


def _parameters_of(given: Locus | HasLoci) -> tuple[Parameter, Parameter]:
    first, second = given.vary
    return given.model.parameter(first), given.model.parameter(second)


def _shown(parameter: Parameter, value: float) -> float:
    return float(np.degrees(value)) if parameter.unit == "rad" else value


def _head(parameter: Parameter) -> str:
    unit = "°" if parameter.unit == "rad" else parameter.unit
    return f"{parameter.name} ({unit})" if unit else parameter.name
