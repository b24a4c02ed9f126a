"""A diagram of loci as tables of ends, special points and regions, in text and in HTML."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slipfold.loci.locus import Locus, LocusEnd, LocusPoint, locus_title
from slipfold.loci.region_map import Region, RegionMap
from slipfold.loci.window import Window
from slipfold.models.model import Model
from slipfold.results.criticality import criticalities, point_criticality
from slipfold.results.sentences import uncertain_point, without_defaults
from slipfold.text.one_line import certain
from slipfold.text.printed_table import PrintedTable, html_list, with_unit

NOTED = ("limit", "closed", "codimension-2", "unresolved", "interrupted", "points")
"""Kinds of ends that stand in the table; that it ends at the window is the usual case."""

ROUNDING = 1e-14
"""What is smaller than this share of the window is rounding, and shown as zero."""

FROM_A_CYCLE = (
    "The equilibria found were followed across it, and cycles born on them there; for loci of "
    "another cycle save a response that has it (--settled) and give that file."
)
"""What else can be done for an autonomous model."""


@dataclass(frozen=True, eq=False)
class LocusSummary:
    """Both ends and all special points of each locus, the regions, and sentences below."""

    model: Model
    vary: tuple[str, str]
    window: Window
    loci: Sequence[Locus]
    regions: RegionMap | None
    interrupted: bool
    remarks: Sequence[str]

    def text(self) -> str:
        """Return the tables as lines of text, with a title above and why loci end below."""
        parts = [[self._title()], self._loci_table().text(), self._sentences()]
        if self.regions is not None:
            parts += [self._regions_table(self.regions).text(), self._disagreements(self.regions)]
        return "\n\n".join("\n".join(lines) for lines in parts if lines)

    def html(self) -> str:
        """Return the tables as HTML, for notebooks."""
        page = self._loci_table().html(self._title()) + html_list(self._sentences())
        if self.regions is not None:
            page += self._regions_table(self.regions).html("Regions")
            page += html_list(self._disagreements(self.regions))
        return page

    def _title(self) -> str:
        spans = [
            with_unit(f"{name} from {low:g} to {high:g}", self.model.parameter(name).unit)
            for name, (low, high) in zip(self.vary, self.window, strict=True)
        ]
        changed = without_defaults(self.model, self.vary)
        return f"{self.model.name}: bifurcations for {' and '.join(spans)}{changed}"

    def _loci_table(self) -> PrintedTable:
        """The rows of all loci, numbered throughout."""
        heads = ["LO", "type", "period", "PT", "TY", "LAB", *self.vary, "criticality"]
        noise = [ROUNDING * max(map(abs, span)) for span in self.window]
        rows = [row for locus in self.loci for row in _rows_of(locus, noise)]
        lines = [[*row[:5], str(label), *row[5:]] for label, row in enumerate(rows, 1)]
        words = ("type", "TY", "criticality", "coefficients", "")
        return PrintedTable([*heads, "coefficients", ""], lines, words)

    def _sentences(self) -> list[str]:
        sentences = [sentence for locus in self.loci for sentence in self._endings(locus)]
        if not self.loci:
            sentences.append("No locus was found in this window.")
            if not self.model.forced:
                sentences.append(FROM_A_CYCLE)
        if self.interrupted:
            sentences.append("Interrupted: some of the set is missing.")
        return [*sentences, *self._uncertain(), *self.remarks]

    def _endings(self, locus: Locus) -> list[str]:
        size = f"{locus_title(locus.type, locus.period, locus.kind)}, {len(locus)} points"
        size += f", from locus {locus.parent}" if locus.parent is not None else ""
        if locus.closed:
            return [f"Locus {locus.id} ({size}): {locus.stopped.reason}"]
        begins = f"begins at {self._place(locus.begun.values)}: {locus.begun.reason}"
        ends = f"ends at {self._place(locus.stopped.values)}: {locus.stopped.reason}"
        return [f"Locus {locus.id} ({size}) {begins}", f"Locus {locus.id} {ends}"]

    def _uncertain(self) -> list[str]:
        parameters = [self.model.parameter(name) for name in self.vary]
        return [
            sentence
            for locus in self.loci
            for point in locus.special
            for sentence in uncertain_point(
                f"{point.type} of locus {locus.id}",
                parameters, point.values, point.uncertainty, self.window,
            )
        ]  # fmt: skip

    def _place(self, values: Sequence[float]) -> str:
        return ", ".join(
            with_unit(f"{name} = {value:.8g}", self.model.parameter(name).unit)
            for name, value in zip(self.vary, values, strict=True)
        )

    def _regions_table(self, regions: RegionMap) -> PrintedTable:
        heads = ["region", "stable", "share", *self.vary, "responses", "checks"]
        lines = [_region_row(region) for region in regions.regions]
        if any(region.motions for region in regions.regions):
            heads.append("motions")
            pairs = zip(lines, regions.regions, strict=True)
            lines = [[*line, region.regimes_text] for line, region in pairs]
        return PrintedTable(heads, lines, words=("stable", "responses", "checks", "motions"))

    def _disagreements(self, regions: RegionMap) -> list[str]:
        """Why regions are not known: simulations or responses do not fit what others say."""
        sentences = []
        for region in regions.regions:
            title = f"Region {region.id} ({region.claim})"
            differing = [check for check in region.checks if not check.agrees]
            sentences += [
                f"{title} at {self._place(check.values)}, started {check.begins}: {check.note}"
                for check in differing
            ]
            if not region.consistent:
                what = "bifurcations of what sticks" if region.sticking else "branch points"
                sentences.append(
                    f"{title}: not true all over it, as responses across it show; {what}, "
                    "whose loci are not known, may divide it"
                )
        return sentences


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


def _region_row(region: Region) -> list[str]:
    agreeing = sum(check.agrees for check in region.checks)
    checks = f"{agreeing} of {len(region.checks)} agree" if region.checks else "none"
    responses = "agree" if region.consistent else "disagree"
    place = [f"{value:.6g}" for value in region.place]
    return [str(region.id), region.name, f"{region.share:.2%}", *place, responses, checks]
