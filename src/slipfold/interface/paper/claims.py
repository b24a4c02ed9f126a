"""The claims of the source paper, each decided by computed numbers alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, cast

import numpy as np

from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.interface.paper.cases import Case, Cases, Row
from slipfold.interface.paper.tables import number, table
from slipfold.lines import branch_segments
from slipfold.long_term.spectrum import Spectrum
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.results.diagram import Diagram


class NotComputed(LookupError):
    """A result that a claim needs is not there, e.g. because the run was interrupted."""


@dataclass(frozen=True)
class Findings:
    """Results by case."""

    cases: Cases  # what was to be computed
    results: Mapping[Case, Any] = field(default_factory=dict)

    def diagram(self, vary: str = "Nd", **parameters: Any) -> Diagram:
        """Return the response diagram of a case."""
        model = SlidingOscillator(**parameters)
        for case, result in self.results.items():
            if (case.kind, case.vary, case.model) == ("response", (vary,), model):
                return cast("Diagram", result)
        raise NotComputed(f"the response in {vary} of {model!r}")

    def spectrum(self, **parameters: Any) -> Spectrum:
        """Return the spectrum of a case."""
        case = Case("spectrum", SlidingOscillator(**parameters))
        if case not in self.results:
            raise NotComputed(f"the spectrum of {case.model!r}")
        return cast("Spectrum", self.results[case])

    def rows(self, figure: int) -> tuple[Row, ...]:
        """Return the families of a figure."""
        for item in self.cases.figures:
            if item.number == figure:
                return item.rows
        raise NotComputed(f"figure {figure}")

    def family(self, row: Row) -> list[tuple[float, Diagram]]:
        """Return the diagrams of a family with the value in which they differ, ascending."""
        missing = [curve.key for curve in row.curves if curve not in self.results]
        if missing:
            raise NotComputed(", ".join(missing))
        members = [(curve.model.values[row.member], self.results[curve]) for curve in row.curves]
        return sorted(members, key=lambda member: member[0])


def on_branches(diagram: Diagram, type_: str, doubled: bool) -> list[SpecialPoint]:
    """Return special points of one type by value."""
    result = [
        point
        for branch in diagram.branches
        if (branch.period > 1) == doubled
        for point in branch.special
        if point.type == type_
    ]
    return sorted(result, key=lambda point: point.value)


def first(diagram: Diagram, type_: str, doubled: bool) -> SpecialPoint | None:
    """Return the special point of one type with the smallest value, or None."""
    return next(iter(on_branches(diagram, type_, doubled)), None)


def band(branches: Sequence[Branch]) -> tuple[float, float]:
    """Return the smallest and the largest parameter that branches reach."""
    values = [branch.parameter for branch in branches]
    values += [np.array([point.value for point in branch.special]) for branch in branches]
    together = np.concatenate(values)
    return float(together.min()), float(together.max())


def reached(branch: Branch, output: str, value: float, measure: str = "max") -> list[float]:
    """Return what an output reaches where a branch passes a value of the parameter."""
    result = []
    for segment in branch_segments(branch, output, measure):
        ahead = segment.parameter - value
        for i in np.flatnonzero(ahead[:-1] * ahead[1:] <= 0):
            width = ahead[i] - ahead[i + 1]
            fraction = ahead[i] / width if width else 0.0
            step = segment.value[i + 1] - segment.value[i]
            result.append(float(segment.value[i] + fraction * step))
    return result


ABSENT = 1e-6
"""Subharmonic over fundamental below which there is none."""

PRESENT = 1e-2
"""Subharmonic over fundamental above which there is one."""


@dataclass(frozen=True)
class Claim:
    """A claim of the paper with its verdict."""

    number: int
    statement: str  # what the paper says
    # True if the numbers confirm it, False if they do not, None if they were not computed
    verdict: bool | None
    evidence: str  # the numbers, as Markdown

    @property
    def verdict_text(self) -> str:
        """The verdict in words."""
        return {True: "confirmed", False: "not confirmed", None: "not computed"}[self.verdict]


Judgment = tuple[bool, str]


def _subharmonic(findings: Findings) -> Judgment:
    below, above = 0.05, 0.15
    diagram = findings.diagram(f=12.2)
    threshold = first(diagram, "PD", doubled=False)
    rows, ratios, settled = [], [], []
    for force in (below, above):
        spectrum = findings.spectrum(f=12.2, Nd=force)
        lines = {name: [spectrum.line(name, order) for order in (0.5, 1, 1.5)] for name in "xy"}
        ratios.append(lines["x"][0] / lines["x"][1])
        settled.append(spectrum.settled)
        rows += [
            [f"{force:g}", f"{name}/L", *(f"{value:.4g}" for value in lines[name])] for name in "xy"
        ]
    between = threshold is not None and below < threshold.value < above
    verdict = between and all(settled) and ratios[0] < ABSENT and ratios[1] > PRESENT
    fold = first(diagram, "LP", doubled=True)
    text = (
        "Amplitudes of the steady response from zero initial conditions at f = 12.2 Hz:\n\n"
        + table(["Nd (N)", "output", "f/2", "f", "3f/2"], rows)
        + f"\n\nThe response with f alone loses its stability (PD) at Nd = "
        f"{_value(threshold)} N. Besides it a response with f/2 exists from "
        f"the fold (LP) at {_value(fold)} N on."
    )
    return verdict, text


def _criticality(findings: Findings) -> Judgment:
    expected = {12.2: "subcritical", 12.5: "supercritical"}
    rows, verdict = [], True
    for frequency, kind in expected.items():
        point = first(findings.diagram(f=frequency), "PD", doubled=False)
        verdict &= point is not None and point.criticality == kind
        if point is not None:
            cells = [number(point.value), str(point.criticality), number(point.coefficient)]
            rows.append([f"{frequency:g}", *cells])
    return verdict, table(["f (Hz)", "PD at Nd (N)", "criticality", "coefficient"], rows)


def _torus_follows(findings: Findings) -> Judgment:
    diagram = findings.diagram(f=12.5)
    doubling, torus = first(diagram, "PD", False), first(diagram, "NS", True)
    verdict = doubling is not None and torus is not None and torus.value > doubling.value
    doublings, tori = _listed(diagram)
    return verdict, f"PD at Nd = {doublings} N; NS at Nd = {tori} N."


def _split_response(findings: Findings) -> Judgment:
    [row] = findings.rows(3)
    rows, widths, peaks, split, bent = [], [], [], [], []
    for force, diagram in findings.family(row):
        doublings = [point.value for point in on_branches(diagram, "PD", False)]
        doubled = [branch for branch in diagram.branches if branch.period > 1]
        if len(doublings) < 2 or not doubled:
            return False, f"At Nd = {force:g} N no branch leaves the response between two PD."
        low, high = band(doubled)
        peak_x, at_x = _peak(doubled, "x")
        peak_y, at_y = _peak([diagram.branches[0]], "y")
        beside = [value for branch in doubled for value in reached(branch, "y", at_y)]
        inside = doublings[0] < at_y < doublings[-1]
        split.append(inside and bool(beside) and max(beside) < peak_y)
        widths.append(high - low)
        peaks.append(at_x)
        bent.append(low < doublings[0])
        cells = [low, high, high - low, doublings[0], doublings[-1], peak_x, at_x, peak_y]
        rows.append([f"{force:g}", *(f"{value:.5g}" for value in cells), _range(beside)])
    softens = all(bent) and _rises(peaks, falling=True)
    head = ["Nd (N)", "x active from (Hz)", "to (Hz)", "width (Hz)", "lower PD (Hz)"]
    head += ["upper PD (Hz)", "largest x/L", "at (Hz)"]
    head += ["peak y/L of period 1", "y/L there with x active"]
    text = (
        "The band in which x is active reaches from the end of the period-2 branch, a fold below "
        f"the lower PD, to the upper PD. It widens: {_yes(_rises(widths))}. It reaches below the "
        "lower PD, and the largest x/L moves to lower frequencies (softening): "
        f"{_yes(softens)}. Where y/L of the period-1 response peaks, that response is unstable, "
        f"and y/L of the response with x active is smaller (splitting): {_yes(all(split))}.\n\n"
    )
    return all(split) and _rises(widths) and softens, text + table(head, rows)


def _folds_and_tori(findings: Findings) -> Judgment:
    [row] = findings.rows(3)
    rows, folds, tori = [], 0, 0
    for force, diagram in findings.family(row):
        result = [point.value for point in on_branches(diagram, "LP", True)]
        intervals = [pair for branch in diagram.branches for pair in _torus_intervals(branch)]
        folds += len(result)
        tori += len(intervals)
        cells = [", ".join(f"{low:.6g} to {high:.6g}" for low, high in intervals) or "none"]
        rows.append([f"{force:g}", ", ".join(map(number, result)) or "none", *cells])
    head = ["Nd (N)", "folds at f (Hz)", "unstable between two NS, f (Hz)"]
    return folds > 0 and tori > 0, table(head, rows)


def _speed_lowers(findings: Findings) -> Judgment:
    [row] = findings.rows(4)
    values = _thresholds(findings, row, "PD")
    return _rises(values, falling=True), _family_table(findings, row)


def _slow_removes(findings: Findings) -> Judgment:
    [row] = findings.rows(4)
    values = _thresholds(findings, row, "NS")
    verdict = values[0] is None and all(value is not None for value in values[1:])
    return verdict, _family_table(findings, row)


def _static_force(findings: Findings) -> Judgment:
    [row] = findings.rows(5)
    doubling, torus = _thresholds(findings, row, "PD"), _thresholds(findings, row, "NS")
    force = 0.5
    reach: dict[tuple[str, str], list[float | None]] = {}
    for _, diagram in findings.family(row):
        doubled = [branch for branch in diagram.branches if branch.period > 1]
        for output in "xy":
            for measure in ("max", "peak_to_peak"):
                result = [v for branch in doubled for v in reached(branch, output, force, measure)]
                reach.setdefault((output, measure), []).append(max(result, default=None))
    lower = {key: _rises(values) for key, values in reach.items()}
    verdict = _rises(doubling) and _rises(torus) and lower["x", "max"] and lower["y", "max"]
    rows = [
        [f"{key[1].replace('_', '-')} {key[0]}/L", *map(number, values), _yes(lower[key])]
        for key, values in reach.items()
    ]
    members = [f"Ns = {value:g} N" for value, _ in findings.family(row)]
    head = ["", *members, "smaller with smaller Ns"]
    text = (
        f"\n\nVibration with x active at Nd = {force:g} N, where the three curves can be compared "
        "(the verdict rests on the largest value, which the paper shows):\n\n"
    )
    return verdict, _family_table(findings, row) + text + table(head, rows)


def _friction(findings: Findings) -> Judgment:
    [row] = findings.rows(6)
    further = [item for number_, item in findings.cases.further if number_ == 9]
    if not further:
        raise NotComputed("the curves of claim 9")
    verdict = all(_rises(_thresholds(findings, row, kind), falling=True) for kind in ("PD", "NS"))
    texts = []
    for item in (row, *further):
        speed = item.curves[0].model.values["Vd"]
        lines = [f"Vd = {speed:g} m/s:\n", _family_table(findings, item), ""]
        members = [value for value, _ in findings.family(item)]
        for kind in ("PD", "NS"):
            values = _thresholds(findings, item, kind)
            fails = [
                f"mu = {mu:g} to {less:g} ({number(high)} to {number(low)})"
                for (less, low), (mu, high) in pairwise(zip(members, values, strict=True))
                if not _rises([low, high], falling=True)
            ]
            holds = f"fails from {', '.join(fails)}" if fails else "holds throughout"
            lines.append(f"- A smaller mu raises {kind}: {holds}.")
        texts.append("\n".join(lines))
    note = "The verdict is that for Vd = 1 m/s, the speed of figure 6.\n\n"
    return verdict, note + "\n\n".join(texts)


def _direction(findings: Findings) -> Judgment:
    texts, verdict = [], True
    for row in findings.rows(7):
        doubling = _thresholds(findings, row, "PD")
        torus = _thresholds(findings, row, "NS")
        present = [value for value in doubling if value is not None]
        changes = len(present) == len(doubling) and max(present) > 1.01 * min(present)
        removes = None in torus and any(value is not None for value in torus)
        verdict &= changes and removes
        speed = row.curves[0].model.values["Vd"]
        texts.append(f"Vd = {speed:g} m/s:\n\n{_family_table(findings, row)}")
    return verdict, "\n\n".join(texts)


CLAIMS: tuple[tuple[str, Callable[[Findings], Judgment]], ...] = (
    (
        "Below a threshold of Nd the response has only the forcing frequency; above it f/2 "
        "appears in x.",
        _subharmonic,
    ),
    ("PD is subcritical at 12.2 Hz and supercritical at 12.5 Hz.", _criticality),
    ('An NS ("Hopf") follows PD at 12.5 Hz as Nd grows.', _torus_follows),
    (
        "The frequency response splits in y, and x is active over a band that widens with Nd, "
        "softening.",
        _split_response,
    ),
    ("Folds and an interval of NS instability exist on the frequency response.", _folds_and_tori),
    ("A larger Vd lowers the PD threshold.", _speed_lowers),
    ("A small Vd removes the NS.", _slow_removes),
    ("A smaller Ns lowers both thresholds and the vibration.", _static_force),
    ("A smaller mu raises both thresholds.", _friction),
    ("alpha changes the PD threshold and can remove the NS.", _direction),
)
"""Statement and judge of each claim, in order; a judge raises `NotComputed` if data are missing."""


def judge_claims(findings: Findings) -> tuple[Claim, ...]:
    """Judge all claims."""
    claims = []
    for index, (statement, judge) in enumerate(CLAIMS, start=1):
        try:
            verdict, evidence = judge(findings)
            claims.append(Claim(index, statement, bool(verdict), evidence))
        except NotComputed as missing:
            claims.append(Claim(index, statement, None, f"Missing: {missing}."))
    return tuple(claims)


def claims_markdown(claims: Sequence[Claim]) -> str:
    """Return the claims with verdicts and evidence as Markdown."""
    summary = table(
        ["", "claim", "verdict"],
        [[str(claim.number), claim.statement, claim.verdict_text] for claim in claims],
    )
    parts = [
        "# The paper's claims, decided by computed numbers",
        "PD: period doubling of the period-1 response. NS: first Neimark-Sacker bifurcation of the "
        'response of period 2, which the paper calls "Hopf"; "none" if there is none up to the '
        "largest Nd computed, 0.98 Ns. Amplitudes are maxima over the continuous orbit, over L. "
        "`thresholds.csv` lists all special points.",
        summary,
    ]
    for claim in claims:
        parts.append(f"## {claim.number}. {claim.statement}\n\n**{claim.verdict_text}**")
        parts.append(claim.evidence)
    return "\n\n".join(parts) + "\n"


def _thresholds(findings: Findings, row: Row, type_: str) -> list[float | None]:
    """Return the PD of period 1, or the first NS of period 2, of each member of a family."""
    points = [first(diagram, type_, type_ == "NS") for _, diagram in findings.family(row)]
    return [None if point is None else point.value for point in points]


def _family_table(findings: Findings, row: Row) -> str:
    parameter = row.curves[0].model.parameter(row.member)
    head = f"{row.member} ({parameter.unit})" if parameter.unit else row.member
    rows = []
    for value, diagram in findings.family(row):
        shown = np.degrees(value) if parameter.unit == "rad" else value
        rows.append([f"{shown:.6g}", *_listed(diagram)])
    return table([head.replace("rad", "°"), "PD at Nd (N)", "NS at Nd (N)"], rows)


def _listed(diagram: Diagram) -> list[str]:
    result = on_branches(diagram, "PD", False), on_branches(diagram, "NS", True)
    return [", ".join(number(point.value) for point in points) or "none" for points in result]


def _value(point: SpecialPoint | None) -> str:
    return number(None if point is None else point.value)


def _rises(values: Sequence[float | None], falling: bool = False) -> bool:
    """Whether values rise strictly (or fall); one that is missing does neither."""
    known = [value for value in values if value is not None]
    if len(known) < len(values) or len(known) < 2:
        return False
    return all((b < a) if falling else (b > a) for a, b in pairwise(known))


def _peak(branches: Sequence[Branch], output: str) -> tuple[float, float]:
    """Return the largest value of an output over branches, and the parameter there."""
    lines = [line for branch in branches for line in branch_segments(branch, output)]
    best = max(lines, key=lambda line: line.value.max())
    index = int(best.value.argmax())
    return float(best.value[index]), float(best.parameter[index])


def _torus_intervals(branch: Branch) -> list[tuple[float, float]]:
    """Return pairs of successive NS between which all orbits are unstable."""
    tori = [point for point in branch.special if point.type == "NS"]
    pairs = []
    for start, end in pairwise(tori):
        between = (branch.arclength > start.arclength) & (branch.arclength < end.arclength)
        if between.any() and (branch.unstable[between] > 0).all():
            low, high = sorted((start.value, end.value))
            pairs.append((low, high))
    return pairs


def _range(values: Sequence[float]) -> str:
    return ", ".join(f"{value:.5g}" for value in values) or "none"


def _yes(value: bool) -> str:
    return "yes" if value else "no"
