"""A diagram as a table of its ends and special points, in text and in HTML."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.branch import Branch
from slipfold.branches.special_point import BIFURCATIONS, SpecialPoint, sensitive_to
from slipfold.continuation.end import End
from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.models.suggestion import suggest
from slipfold.orbits.extrema import Extrema
from slipfold.results.sentences import uncertain_point, without_defaults
from slipfold.text.one_line import certain, headed
from slipfold.text.printed_table import PrintedTable, html_list, with_unit
from slipfold.text.stability import stability_word
from slipfold.text.turns import turns_text

SHOWN = 2
"""States shown where nobody says which."""

ROUNDING = 1e-14
"""What is smaller than this share of the size of its column is rounding, and shown as zero."""

WORDS = {"stable": "yes", "unstable": "no", "neutral": "neutral"}
"""What the column that asks whether an orbit is stable says."""

GRADIENTS = "Derivatives of {} at special points (LAB), by each parameter in SI units:"

LOCATED = 1e-9
"""What special points are located to, over the largest value of the span."""


@dataclass(frozen=True, eq=False)
class _Row:
    """One line: an end of a branch, or a special point; `note` is what else there is to say."""

    branch: Branch
    index: int
    type: str
    value: float
    extrema: Extrema
    stable: str
    note: str


@dataclass(frozen=True, eq=False)
class DiagramSummary:
    """Both ends and all special points of each branch, and sentences below."""

    model: Model
    vary: str
    span: tuple[float, float]
    branches: Sequence[Branch]
    remarks: Sequence[str]

    def text(self, outputs: Sequence[str] | None = None) -> str:
        """Return the table as lines of text, with a title above and why branches stop below."""
        cells = self._cells(outputs).text()
        lines = [self._title(), "", *cells, "", *self._sentences()]
        moved = self._gradients()
        if moved is not None:
            lines += ["", GRADIENTS.format(self.vary), "", *moved.text()]
        return "\n".join(lines)

    def html(self) -> str:
        """Return the table as HTML, for notebooks."""
        moved = self._gradients()
        found = self._cells(None).html(self._title()) + html_list(self._sentences())
        return found if moved is None else found + moved.html(GRADIENTS.format(self.vary))

    def _title(self) -> str:
        first, last = self.span
        unit = self.model.parameter(self.vary).unit
        span = with_unit(f"{self.vary} from {first:g} to {last:g}", unit)
        return f"{self.model.name}: {span}{without_defaults(self.model, [self.vary])}"

    def _cells(self, outputs: Sequence[str] | None) -> PrintedTable:
        known = [state.name for state in self.model.states]
        names = known[:SHOWN] if outputs is None else list(outputs)
        known += [output.name for output in self.model.outputs()]
        for name in names:
            if name not in known:
                listed = ", ".join(known)
                raise InputError(f"no output {name!r}; {suggest(name, known)}it has {listed}")
        heads = ["BR", "period", "PT", "TY", "LAB", self.vary]
        heads += [f"{which} {name}" for name in names for which in ("max", "min")]
        noise = self._noise()
        rows = [row for branch in self.branches for row in _rows(branch, noise)]
        sizes = {name: self._size(rows, name) for name in names}
        lines = []
        for label, row in enumerate(rows, 1):
            line = [str(row.branch.id), str(row.branch.period), str(row.index), row.type]
            line += [str(label), f"{row.value:.10g}"]
            for name in names:
                low, high = row.extrema.of(name)
                line += [_shown(value, sizes[name]) for value in (high[0], low[0])]
            lines.append([*line, row.stable, row.note])
        return PrintedTable([*heads, "stable", ""], lines, words=("TY", "stable", ""))

    def _gradients(self) -> PrintedTable | None:
        """Return how special points move with each parameter, if that was asked for."""
        points = points_by_label(self.branches).items()
        known = {label: point for label, point in points if point.gradients}
        if not known:
            return None
        lines = [
            [headed(self.model.parameter(name))]
            + [f"{(point.gradients or {})[name]:.8g}" for point in known.values()]
            for name in sensitive_to(self.model, self.vary)
        ]
        heads = [f"{point.type} ({label})" for label, point in known.items()]
        return PrintedTable(["by", *heads], lines, words=("by",))

    def _noise(self) -> float:
        """Return what an end may differ from zero by and be there: branches begin at points."""
        wide = max(map(abs, self.span))
        specials = [point for branch in self.branches for point in branch.special]
        zeros = [
            point.uncertainty
            for point in specials
            if abs(point.value) <= point.uncertainty <= LOCATED * wide
        ]
        return max([ROUNDING * wide, *zeros])

    def _size(self, rows: Sequence[_Row], name: str) -> float:
        """Return how large a state or output is, by its scale or at the rows of the table."""
        scales = zip(self.model.states, self.model.state_scales(), strict=True)
        own = {state.name: float(scale) for state, scale in scales}.get(name, 0.0)
        ends = [end[0] for row in rows for end in row.extrema.of(name)]
        return float(np.nanmax([own, *np.abs(ends)]))

    def _sentences(self) -> list[str]:
        return [*self._endings(), *self._uncertain(), *self.remarks]

    def _endings(self) -> list[str]:
        unit = self.model.parameter(self.vary).unit
        sentences, noise = [], self._noise()
        for branch in self.branches:
            size = f"period {branch.period}, {len(branch)} points"
            size = ", ".join(filter(None, [size, turns_text(branch.turns), _stuck(branch)]))
            value = with_unit(f"{self.vary} = {certain(branch.stopped.value, noise):.8g}", unit)
            closed = branch.begun.reason == branch.stopped.reason  # it ends where it begins
            if branch.parent is None and not closed and branch.begun.value != self.span[0]:
                sentences.append(f"Branch {branch.id}: {branch.begun.reason}")
            if branch.parent is not None and branch.begun.kind != "born":
                begun = certain(branch.begun.value, noise)
                begins = with_unit(f"{self.vary} = {begun:.8g}", unit)
                sentences.append(f"Branch {branch.id} begins at {begins}: {branch.begun.reason}")
            stopped = f"Branch {branch.id} ({size}) stopped at {value}: {branch.stopped.reason}"
            sentences.append(stopped)
        return sentences

    def _uncertain(self) -> list[str]:
        parameters, spans = [self.model.parameter(self.vary)], [self.span]
        return [
            sentence
            for branch in self.branches
            for point in branch.special
            for sentence in uncertain_point(
                f"{point.type} of branch {branch.id}",
                parameters, [point.value], [point.uncertainty], spans,
            )
        ]  # fmt: skip


def points_by_label(branches: Sequence[Branch]) -> dict[int, SpecialPoint]:
    """Return the special points by their number under LAB in the table."""
    found: dict[int, SpecialPoint] = {}
    label = 1
    for branch in branches:
        if len(branch):  # both ends of a branch have labels, too
            found |= dict(enumerate(branch.special, label + 1))
            label += len(branch.special) + 2
    return found


def _rows(branch: Branch, noise: float) -> list[_Row]:
    if not len(branch):
        return []
    special = [_special_row(branch, point) for point in branch.special]
    first = _end_row(branch, 0, branch.begun, noise)
    return [first, *special, _end_row(branch, len(branch) - 1, branch.stopped, noise)]


def _end_row(branch: Branch, index: int, end: End, noise: float) -> _Row:
    kind = "MX" if end.kind == "failed" else "EP"
    note = end.kind if end.kind in ("limit", "closed", "interrupted", "points") else ""
    stable = _stability(branch, branch.multipliers[index])
    # A branch that leaves another is born with a multiplier on the unit circle, within rounding.
    if index == 0 and branch.begun.kind in ("born", "closed"):
        stable = ""
    value = certain(float(branch.parameter[index]), noise)
    return _Row(branch, index + 1, kind, value, _extrema(branch, index), stable, note)


def _stability(branch: Branch, multipliers: NDArray[np.complex128]) -> str:
    """Say whether an orbit is stable; without damping it is neither that nor unstable."""
    cycle = branch.kind == "periodic" and not branch.model.forced
    return WORDS[stability_word(multipliers, cycle=cycle)]


def _extrema(branch: Branch, index: int) -> Extrema:
    """Return the extrema of one orbit, without computing those of all."""
    known = vars(branch).get("extrema")
    if known is None or np.isnan(known.maximum[index]).all():  # never asked for, or interrupted
        return branch.orbit(index).extrema
    return Extrema(known.names, known.minimum[index, None], known.maximum[index, None])


def _special_row(branch: Branch, point: SpecialPoint) -> _Row:
    index = int(np.searchsorted(branch.arclength, point.arclength, side="right"))
    stable = "" if point.type in BIFURCATIONS else _stability(branch, point.multipliers)
    value = certain(point.value, point.uncertainty)
    return _Row(branch, index, point.type, value, point.orbit.extrema, stable, point.outcome)


def _stuck(branch: Branch) -> str:
    """Say for how much of the period contacts stick at most, if they do."""
    most = 0.0 if branch.stuck_fraction is None else float(np.nanmax(branch.stuck_fraction))
    return f"contacts stick for up to {most:.4g} of the period" if most > 0 else ""


def _shown(value: float, size: float) -> str:
    """Write a number, zero if it is no more than rounding beside the size of its column."""
    return f"{certain(value, ROUNDING * size):.6g}"
