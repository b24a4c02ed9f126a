"""A diagram as a table of its ends and special points, in text and in HTML."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from slipfold.branches.branch import Branch, End
from slipfold.branches.special_point import BIFURCATIONS, SpecialPoint
from slipfold.errors import InputError
from slipfold.models.suggestion import suggest
from slipfold.orbits.extrema import Extrema
from slipfold.results.checked_parts import checked_lines
from slipfold.results.title import without_defaults
from slipfold.results.uncertain_points import uncertain_on_branches
from slipfold.text.one_line import certain
from slipfold.text.printed_table import PrintedTable, html_list, with_unit

if TYPE_CHECKING:
    from slipfold.results.diagram import Diagram

__all__ = ["Row", "points_by_label", "summary_html", "summary_rows", "summary_text"]

SHOWN = 2
"""States shown where nobody says which."""

ROUNDING = 1e-14
"""What is smaller than this share of the size of its column is rounding, and shown as zero."""

LOCATED = 1e-9
"""What special points are located to, over the largest value of the span."""


@dataclass(frozen=True, eq=False)
class Row:
    """One line of the table.

    Parameters
    ----------
    branch
        Number of the branch.
    period
        Its period in forcing periods.
    point
        Points of the branch up to here, as AUTO counts them.
    type
        ``"EP"`` for an end, ``"MX"`` where the branch could not be followed, else the type of
        the special point.
    value
        Value of the parameter.
    extrema
        Over the continuous orbit.
    stable
        ``"yes"``, ``"no"``, or nothing where a multiplier is on the unit circle.
    note
        What else there is to say.
    """

    branch: int
    period: int
    point: int
    type: str
    value: float
    extrema: Extrema
    stable: str
    note: str


def summary_rows(diagram: Diagram) -> tuple[Row, ...]:
    """Return both ends and all special points of each branch."""
    noise = _noise(diagram)
    return tuple(row for branch in diagram.branches for row in _rows_of(branch, noise))


def _noise(diagram: Diagram) -> float:
    """Return what an end of a branch may differ from zero by and be there: it begins at points."""
    wide = max(map(abs, diagram.span))
    specials = [point for branch in diagram.branches for point in branch.special]
    zeros = [
        point.uncertainty
        for point in specials
        if abs(point.value) <= point.uncertainty <= LOCATED * wide
    ]
    return max([ROUNDING * wide, *zeros])


def points_by_label(diagram: Diagram) -> dict[int, SpecialPoint]:
    """Return the special points by their number under LAB in the table."""
    found: dict[int, SpecialPoint] = {}
    label = 1
    for branch in diagram.branches:
        if len(branch):  # both ends of a branch have labels, too
            found |= dict(enumerate(branch.special, label + 1))
            label += len(branch.special) + 2
    return found


def _rows_of(branch: Branch, noise: float) -> list[Row]:
    if not len(branch):
        return []
    special = [_special_row(branch, point) for point in branch.special]
    first = _end_row(branch, 0, branch.begun, noise)
    return [first, *special, _end_row(branch, len(branch) - 1, branch.stopped, noise)]


def _end_row(branch: Branch, index: int, end: End, noise: float) -> Row:
    kind = "MX" if end.kind == "failed" else "EP"
    note = end.kind if end.kind in ("limit", "closed", "interrupted", "points") else ""
    stable = "yes" if branch.stable[index] else "no"
    # A branch that leaves another is born with a multiplier on the unit circle, within rounding.
    if index == 0 and branch.begun.kind in ("born", "closed"):
        stable = ""
    value = certain(float(branch.parameter[index]), noise)
    return Row(
        branch.id, branch.period, index + 1, kind, value, _extrema(branch, index), stable, note
    )


def _extrema(branch: Branch, index: int) -> Extrema:
    """Return the extrema of one orbit, without computing those of all."""
    known = vars(branch).get("extrema")
    if known is None:
        return branch.orbit(index).extrema
    return Extrema(known.names, known.minimum[index, None], known.maximum[index, None])


def _special_row(branch: Branch, point: SpecialPoint) -> Row:
    index = int(np.searchsorted(branch.arclength, point.arclength, side="right"))
    note = point.outcome
    stable = "" if point.type in BIFURCATIONS else "yes" if point.orbit.stable else "no"
    value = certain(point.value, point.uncertainty)
    return Row(
        branch.id, branch.period, index, point.type, value, point.orbit.extrema, stable, note
    )


def _cells(diagram: Diagram, outputs: Sequence[str] | None) -> PrintedTable:
    known = [state.name for state in diagram.model.states]
    names = known[:SHOWN] if outputs is None else list(outputs)
    known += [output.name for output in diagram.model.outputs()]
    for name in names:
        if name not in known:
            raise InputError(f"no output {name!r}; {suggest(name, known)}it has {', '.join(known)}")
    heads = ["BR", "period", "PT", "TY", "LAB", diagram.model.parameter(diagram.vary).name]
    heads += [f"{which} {name}" for name in names for which in ("max", "min")]
    lines = []
    rows = summary_rows(diagram)
    sizes = {name: _size(diagram, rows, name) for name in names}
    for label, row in enumerate(rows, 1):
        line = [str(row.branch), str(row.period), str(row.point), row.type, str(label)]
        line.append(f"{row.value:.10g}")
        for name in names:
            low, high = row.extrema.of(name)
            line += [_shown(value, sizes[name]) for value in (high[0], low[0])]
        lines.append([*line, row.stable, row.note])
    return PrintedTable([*heads, "stable", ""], lines, words=("TY", "stable", ""))


def _shown(value: float, size: float) -> str:
    """Write a number, zero if it is no more than rounding beside the size of its column."""
    return f"{certain(value, ROUNDING * size):.6g}"


def _size(diagram: Diagram, rows: Sequence[Row], name: str) -> float:
    """Return how large a state or output is, by its scale or at the rows of the table."""
    scales = {
        state.name: float(scale)
        for state, scale in zip(diagram.model.states, diagram.model.state_scales(), strict=True)
    }
    ends = [end[0] for row in rows for end in row.extrema.of(name)]
    return float(np.nanmax([scales.get(name, 0.0), *np.abs(ends)]))


def _title(diagram: Diagram) -> str:
    first, last = diagram.span
    unit = diagram.model.parameter(diagram.vary).unit
    span = with_unit(f"{diagram.vary} from {first:g} to {last:g}", unit)
    return f"{diagram.model.name}: {span}{without_defaults(diagram.model, [diagram.vary])}"


def _endings(diagram: Diagram) -> list[str]:
    unit = diagram.model.parameter(diagram.vary).unit
    sentences, noise = [], _noise(diagram)
    for branch in diagram.branches:
        size = f"period {branch.period}, {len(branch)} points"
        value = with_unit(f"{diagram.vary} = {certain(branch.stopped.value, noise):.8g}", unit)
        if branch.parent is None and branch.begun.value != diagram.span[0]:
            sentences.append(f"Branch {branch.id}: {branch.begun.reason}")
        if branch.parent is not None and branch.begun.kind != "born":
            begun = certain(branch.begun.value, noise)
            begins = with_unit(f"{diagram.vary} = {begun:.8g}", unit)
            sentences.append(f"Branch {branch.id} begins at {begins}: {branch.begun.reason}")
        sentences.append(f"Branch {branch.id} ({size}) stopped at {value}: {branch.stopped.reason}")
    return sentences


def _remarks(diagram: Diagram) -> list[str]:
    return [*uncertain_on_branches(diagram), *checked_lines(diagram.checked)]


def summary_text(diagram: Diagram, outputs: Sequence[str] | None = None) -> str:
    """Return the table as lines of text, with a title above and why branches stop below."""
    return "\n".join(
        [
            *(_title(diagram), "", *_cells(diagram, outputs).text(), "", *_endings(diagram)),
            *_remarks(diagram),
        ]
    )


def summary_html(diagram: Diagram) -> str:
    """Return the table as HTML, for notebooks."""
    return _cells(diagram, None).html(_title(diagram)) + html_list(
        [*_endings(diagram), *_remarks(diagram)]
    )
