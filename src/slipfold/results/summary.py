"""A diagram as a table of its ends and special points, in text and in HTML."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from slipfold.branches.branch import Branch
from slipfold.branches.special_point import BIFURCATIONS, SpecialPoint
from slipfold.errors import InputError
from slipfold.models.suggestion import suggest
from slipfold.orbits.extrema import Extrema

if TYPE_CHECKING:
    from slipfold.results.diagram import Diagram

__all__ = ["Row", "summary_html", "summary_rows", "summary_text"]

SHOWN = 2
"""States shown where nobody says which."""


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
    """Return both ends and all special points of each branch.

    Parameters
    ----------
    diagram
        The diagram.
    """
    return tuple(row for branch in diagram.branches for row in _rows_of(branch))


def _rows_of(branch: Branch) -> list[Row]:
    if not len(branch):
        return []
    rows = [_end_row(branch, 0, "EP", "")]
    rows += [_special_row(branch, point) for point in branch.special]
    kind = branch.stopped.kind
    note = kind if kind in ("limit", "closed", "interrupted", "points") else ""
    rows.append(_end_row(branch, len(branch) - 1, "MX" if kind == "failed" else "EP", note))
    return rows


def _end_row(branch: Branch, index: int, kind: str, note: str) -> Row:
    stable = "yes" if branch.stable[index] else "no"
    # A doubled branch is born with a multiplier on the unit circle, to within rounding.
    if index == 0 and branch.begun.kind == "born":
        stable = ""
    value = float(branch.parameter[index])
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
    named = point.name if point.type == "EVENT" else ""
    started = f"to branch {point.leads_to}" if point.leads_to is not None else ""
    note = ", ".join(part for part in (named, point.criticality, started) if part)
    stable = "" if point.type in BIFURCATIONS else "yes" if point.orbit.stable else "no"
    return Row(
        branch.id, branch.period, index, point.type, point.value, point.orbit.extrema, stable, note
    )


def _cells(diagram: Diagram, outputs: Sequence[str] | None) -> tuple[list[str], list[list[str]]]:
    """Return the heads of the columns and the lines, as text."""
    known = [state.name for state in diagram.model.states]
    names = known[:SHOWN] if outputs is None else list(outputs)
    known += [output.name for output in diagram.model.outputs()]
    for name in names:
        if name not in known:
            raise InputError(f"no output {name!r}; {suggest(name, known)}it has {', '.join(known)}")
    heads = ["BR", "period", "PT", "TY", "LAB", diagram.model.parameter(diagram.vary).name]
    heads += [f"{which} {name}" for name in names for which in ("max", "min")]
    lines = []
    for label, row in enumerate(summary_rows(diagram), 1):
        line = [str(row.branch), str(row.period), str(row.point), row.type, str(label)]
        line.append(f"{row.value:.10g}")
        for name in names:
            low, high = row.extrema.of(name)
            line += [f"{high[0]:.6g}", f"{low[0]:.6g}"]
        lines.append([*line, row.stable, row.note])
    return [*heads, "stable", ""], lines


def _title(diagram: Diagram) -> str:
    set_values = ", ".join(
        f"{item.name} = {diagram.model.values[item.name]:.6g} {item.unit}".rstrip()
        for item in diagram.model.parameters
        if item.name != diagram.vary and diagram.model.values[item.name] != item.default
    )
    first, last = diagram.span
    title = f"{diagram.model.name}: {diagram.vary} from {first:g} to {last:g}"
    unit = diagram.model.parameter(diagram.vary).unit
    return f"{title} {unit}".rstrip() + (f"; {set_values}" if set_values else "")


def _endings(diagram: Diagram) -> list[str]:
    unit = diagram.model.parameter(diagram.vary).unit
    sentences = []
    for branch in diagram.branches:
        size = f"period {branch.period}, {len(branch)} points"
        value = f"{diagram.vary} = {branch.stopped.value:.8g} {unit}".rstrip()
        if branch.begun.kind == "span" and branch.begun.value != diagram.span[0]:
            sentences.append(f"Branch {branch.id}: {branch.begun.reason}")
        sentences.append(f"Branch {branch.id} ({size}) stopped at {value}: {branch.stopped.reason}")
    return sentences


def summary_text(diagram: Diagram, outputs: Sequence[str] | None = None) -> str:
    """Return the table as lines of text, with a title above and why branches stop below.

    Parameters
    ----------
    diagram
        The diagram.
    outputs
        States or outputs to show; the first two states if None.

    Raises
    ------
    InputError
        For an unknown output.
    """
    heads, lines = _cells(diagram, outputs)
    widths = [max(len(cell) for cell in column) for column in zip(heads, *lines, strict=True)]
    table = [
        "  ".join(
            # Words to the left, numbers to the right.
            cell.ljust(width) if head in ("TY", "stable", "") else cell.rjust(width)
            for head, cell, width in zip(heads, line, widths, strict=True)
        ).rstrip()
        for line in [heads, *lines]
    ]
    return "\n".join([_title(diagram), "", *table, "", *_endings(diagram)])


def summary_html(diagram: Diagram) -> str:
    """Return the table as HTML, for notebooks.

    Parameters
    ----------
    diagram
        The diagram.
    """
    heads, lines = _cells(diagram, None)

    def line(cells: Sequence[str], tag: str) -> str:
        inside = "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells)
        return f"<tr>{inside}</tr>"

    body = "".join(line(cells, "td") for cells in lines)
    endings = "".join(f"<li>{html.escape(text)}</li>" for text in _endings(diagram))
    return (
        f"<table><caption>{html.escape(_title(diagram))}</caption>"
        f"<thead>{line(heads, 'th')}</thead><tbody>{body}</tbody></table><ul>{endings}</ul>"
    )
