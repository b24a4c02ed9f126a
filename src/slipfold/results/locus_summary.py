"""A diagram of loci as tables of ends, special points and regions, in text and in HTML."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from slipfold.loci.locus import Locus, LocusEnd, LocusPoint, locus_title
from slipfold.loci.region_map import Region
from slipfold.results.checked_parts import checked_lines
from slipfold.results.criticality import criticalities, point_criticality
from slipfold.results.title import without_defaults
from slipfold.results.uncertain_points import uncertain_on_loci
from slipfold.text.one_line import certain
from slipfold.text.printed_table import PrintedTable, html_list, with_unit

if TYPE_CHECKING:
    from slipfold.results.locus_diagram import LocusDiagram

__all__ = ["locus_html", "locus_summary"]

NOTED = ("limit", "closed", "codimension-2", "unresolved", "interrupted", "points")
"""Kinds of ends that stand in the table; that it ends at the window is the usual case."""

ROUNDING = 1e-14
"""What is smaller than this share of the window is rounding, and shown as zero."""


def locus_summary(diagram: LocusDiagram) -> str:
    """Return the tables as lines of text, with a title above and why loci begin and end below."""
    sentences = [*_endings(diagram), *_remarks(diagram)]
    parts = [[_title(diagram)], _loci_table(diagram).text(), sentences]
    if diagram.regions is not None:
        parts += [_regions_table(diagram).text(), _disagreements(diagram)]
    return "\n\n".join("\n".join(lines) for lines in parts if lines)


def locus_html(diagram: LocusDiagram) -> str:
    """Return the tables as HTML, for notebooks."""
    page = _loci_table(diagram).html(_title(diagram)) + html_list(
        [*_endings(diagram), *_remarks(diagram)]
    )
    if diagram.regions is not None:
        page += _regions_table(diagram).html("Regions") + html_list(_disagreements(diagram))
    return page


def _title(diagram: LocusDiagram) -> str:
    spans = [
        with_unit(f"{name} from {low:g} to {high:g}", diagram.model.parameter(name).unit)
        for name, (low, high) in zip(diagram.vary, diagram.window, strict=True)
    ]
    changed = without_defaults(diagram.model, diagram.vary)
    return f"{diagram.model.name}: bifurcations for {' and '.join(spans)}{changed}"


# -- loci ------------------------------------------------------------------------------------


def _loci_table(diagram: LocusDiagram) -> PrintedTable:
    """Both ends and all special points of each locus, numbered throughout."""
    heads = ["LO", "type", "period", "PT", "TY", "LAB", *diagram.vary, "criticality"]
    noise = [ROUNDING * max(map(abs, span)) for span in diagram.window]
    rows = [row for locus in diagram.loci for row in _rows_of(locus, noise)]
    lines = [[*row[:5], str(label), *row[5:]] for label, row in enumerate(rows, 1)]
    words = ("type", "TY", "criticality", "coefficients", "")
    return PrintedTable([*heads, "coefficients", ""], lines, words)


def _rows_of(locus: Locus, noise: Sequence[float]) -> list[list[str]]:
    if not len(locus):
        return []
    found = [_special_row(locus, point) for point in locus.special]
    ends = [(0, locus.begun), (-1, locus.stopped)]
    first, last = (_end_row(locus, index, end, noise) for index, end in ends)
    return [first, *found, last]


def _end_row(locus: Locus, index: int, end: LocusEnd, noise: Sequence[float]) -> list[str]:
    kind = "MX" if end.kind == "failed" else "EP"
    word = criticalities(locus)[index] or ""
    note = end.kind if end.kind in NOTED else ""
    number = 1 if index == 0 else len(locus)
    values = [*map(certain, locus.values[index], noise)]
    return [*_begin(locus, number, kind), *_shown(values), word, "", note]


def _special_row(locus: Locus, point: LocusPoint) -> list[str]:
    index = int(np.searchsorted(locus.arclength, point.arclength, side="right"))
    coefficients = ", ".join(f"{name} = {value:.6g}" for name, value in point.coefficients.items())
    word = point_criticality(locus, point) or ""
    return [
        *_begin(locus, index, point.type),
        *_shown(point.certain_values),
        word,
        coefficients,
        point.outcome,
    ]


def _begin(locus: Locus, number: int, kind: str) -> list[str]:
    return [str(locus.id), locus.type, str(locus.period), str(number), kind]


def _shown(values: Sequence[float] | np.ndarray) -> list[str]:
    return [f"{value:.10g}" for value in values]


def _loci_named(numbers: Sequence[int]) -> str:
    return f"{'locus' if len(numbers) == 1 else 'loci'} {', '.join(map(str, numbers))}"


def _endings(diagram: LocusDiagram) -> list[str]:
    sentences = []
    for locus in diagram.loci:
        size = f"{locus_title(locus.type, locus.period, locus.kind)}, {len(locus)} points"
        size += f", from locus {locus.parent}" if locus.parent is not None else ""
        if locus.closed:
            sentences.append(f"Locus {locus.id} ({size}): {locus.stopped.reason}")
            continue
        begins = f"begins at {_place(diagram, locus.begun.values)}: {locus.begun.reason}"
        ends = f"ends at {_place(diagram, locus.stopped.values)}: {locus.stopped.reason}"
        sentences += [f"Locus {locus.id} ({size}) {begins}", f"Locus {locus.id} {ends}"]
    if not diagram.loci:
        sentences.append("No locus was found in this window.")
    if diagram.interrupted:
        sentences.append("Interrupted: some of the set is missing.")
    return sentences


def _remarks(diagram: LocusDiagram) -> list[str]:
    return [*uncertain_on_loci(diagram), *checked_lines(diagram.checked)]


def _place(diagram: LocusDiagram, values: Sequence[float]) -> str:
    return ", ".join(
        with_unit(f"{name} = {value:.8g}", diagram.model.parameter(name).unit)
        for name, value in zip(diagram.vary, values, strict=True)
    )


# -- regions ---------------------------------------------------------------------------------


def _regions_table(diagram: LocusDiagram) -> PrintedTable:
    heads = ["region", "stable", "share", *diagram.vary, "responses", "checks"]
    lines = [_region_row(region) for region in _regions(diagram)]
    return PrintedTable(heads, lines, words=("stable", "responses", "checks"))


def _regions(diagram: LocusDiagram) -> tuple[Region, ...]:
    return () if diagram.regions is None else diagram.regions.regions


def _region_row(region: Region) -> list[str]:
    agreeing = sum(check.agrees for check in region.checks)
    checks = f"{agreeing} of {len(region.checks)} agree" if region.checks else "none"
    responses = "agree" if region.consistent else "disagree"
    place = [f"{value:.6g}" for value in region.place]
    return [str(region.id), region.name, f"{region.share:.2%}", *place, responses, checks]


def _disagreements(diagram: LocusDiagram) -> list[str]:
    """Why regions are not known: simulations or responses do not fit what others say of them."""
    sentences = []
    for region in _regions(diagram):
        title = f"Region {region.id} ({region.claim})"
        differing = [check for check in region.checks if not check.agrees]
        sentences += [
            f"{title} at {_place(diagram, check.values)}, started {check.begins}: {check.note}"
            for check in differing
        ]
        if not (region.known or differing):
            sentences.append(
                f"{title}: not true all over it, as responses across it show; branch points, "
                "whose loci are not followed, may divide it"
            )
    return sentences
