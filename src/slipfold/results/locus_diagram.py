"""A bifurcation set: loci in a plane of two parameters, with the regions between them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from operator import itemgetter
from typing import Annotated, Any, NamedTuple

from slipfold.bifurcations.branches.settings import Settings
from slipfold.bifurcations.loci.locus import Locus, LocusPoint
from slipfold.bifurcations.loci.region_map import Region, RegionCheck, RegionMap, RegionMotion
from slipfold.bifurcations.loci.window import Window
from slipfold.flow.modes import contacts_of
from slipfold.models.model import Model
from slipfold.results.checks.checked import Checked
from slipfold.results.curves import CurveDiagram, CurveList
from slipfold.results.fields import TEXT, TRUTH, WHOLE, Column, Entry, Items, Nested, axes_of, names
from slipfold.results.records import Provenance, SavedTable
from slipfold.results.tables import Frame, Variable
from slipfold.text import PrintedTable, capitalized

CHECKS = Items(
    "check",
    (
        Column("values", meaning="values of the parameters", dimensions=("parameter",),
               name="check_value", record=True),
        Column("start", TEXT, "rest, or period of the orbit near which it started", record=True),
        Column("settled", WHOLE, "period it settled to, in forcing periods, 0: none", "",
               record=True),
        Column("agrees", TRUTH, "whether that fits the label of the region", record=True),
        Column("note", TEXT, "what happened", record=True),
    ),
    "check_",
    RegionCheck,
    owner=("region", "region it lies in"),
)  # fmt: skip

MOTIONS = Items(
    "motion",
    (
        Column("values", meaning="values of the parameters", dimensions=("parameter",),
               name="motion_value", record=True),
        Column("kind", TEXT, "what the trajectory does", record=True),
        Column("period", WHOLE, "period in forcing periods, 0 for none", "", record=True),
        Column("exponent", meaning="largest Lyapunov exponent, where it was needed",
               unit="1/forcing period", optional=True, record=True),
    ),
    "motion_",
    RegionMotion,
    owner=("region", "region it lies in"),
)  # fmt: skip

REGIONS = Items(
    "region",
    (
        Column("id", WHOLE, "number of the region", name="region", label=True, record=True),
        Column("stable", WHOLE, "periods of the stable responses, 0: no more", "", ("stable",),
               record=True),
        Column("sticking", WHOLE, "periods of those that stick, 0: no more", "", ("sticking",),
               record=True),
        Column("stuck", meaning="smallest and largest fraction of the time in which those stick",
               unit="", dimensions=("bound",), record=True),
        Column("name", TEXT, record=True),
        Column("known", TRUTH, record=True),
        Column("fraction", meaning="fraction of the area of the window", unit="", record=True),
        Column("place", meaning="values of the parameters well inside", dimensions=("parameter",),
               record=True),
        Column("consistent", TRUTH, "whether all responses across it agree on its label",
               record=True),
        Column("checks", get=lambda region: [CHECKS.record_of(check) for check in region.checks],
               record=True),
        Column("regimes", record=True),
        Column("motions", record=True,
               get=lambda region: [MOTIONS.record_of(motion) for motion in region.motions]),
    ),
    "region_",
    Region,
    owned={"checks": CHECKS, "motions": MOTIONS},
)  # fmt: skip


class Regions(Nested):
    """The regions of a plane as an attribute, which may be None."""

    def record(self, result: Any, key: str) -> list[dict[str, Any]] | None:
        """Return a record of each region; None if they were not requested."""
        regions: RegionMap | None = getattr(result, key)
        return None if regions is None else [REGIONS.record_of(item) for item in regions.regions]

    def read(self, saved: SavedTable, result: Any, key: str) -> RegionMap | None:
        """Return the regions."""
        regions: RegionMap | None = super().read(saved, result, key)
        if regions is not None and regions.labels.size:
            low, high = regions.labels.min(), regions.labels.max()
            if not 0 <= low <= high <= len(regions.regions):
                raise ValueError("region_of_cell names a region that there is not")
        return regions


REGION_MAP = Regions(RegionMap, {
    "first": Entry("first", "{vary[0]}", "{vary[0]}", label=True),
    "second": Entry("second", "{vary[1]}", "{vary[1]}", label=True),
    "labels": Entry("second first", "region that the cell belongs to, 0: not known",
                    name="region_of_cell", head="labels"),
    "regions": REGIONS,
}, doc="Which stable responses exist where; None if that was not requested.")  # fmt: skip


FROM_A_CYCLE = (
    "Equilibria were looked for at places a tenth of it apart and followed across it, and so were "
    "the cycles that emanate from them there; "
    "for loci of another cycle save a response that has it (--settled) and give that file."
)
"""Advice for an autonomous model without loci."""

IF_GIVEN = (
    "Changes of contacts on responses that stick already are followed only if their types are "
    "given, as by --type STICK."
)
"""Advice for a model with contacts without loci."""


def _regions_table(diagram: LocusDiagram) -> PrintedTable:
    assert diagram.regions is not None
    heads, lines = ["region", "stable", "fraction", *diagram.vary, "responses", "checks"], []
    with_motions = any(region.motions for region in diagram.regions.regions)
    for region in diagram.regions.regions:
        agreeing = sum(check.agrees for check in region.checks)
        checks = f"{agreeing} of {len(region.checks)} agree" if region.checks else "none"
        place = [f"{value:.6g}" for value in region.place]
        responses = "agree" if region.consistent else "disagree"
        line = [str(region.id), region.name, f"{region.fraction:.2%}", *place, responses, checks]
        lines.append([*line, region.regimes_text] if with_motions else line)
    words = ("stable", "responses", "checks", "motions")
    return PrintedTable([*heads, "motions"] if with_motions else heads, lines, words)


class LabeledLocus(NamedTuple):
    """A special point with the locus that it lies on."""

    locus: Locus
    point: LocusPoint

    def __repr__(self) -> str:
        return f"<{self.point._line()}; on locus {self.locus.id}>"

    def _repr_html_(self) -> str:
        return self.point._repr_html_()


FORMS = Items(
    "normal_form",
    (
        Column("name", TEXT, "name of the coefficient", get=itemgetter(1)),
        Column("value", meaning="the coefficient", get=itemgetter(2)),
    ),
    "normal_form_",
    owner=("special", "row of the special point, from 0"),
)
"""Coefficients of normal forms of all special points."""


class Loci(CurveList):
    """Loci as an attribute of a diagram."""

    doc = "The loci, in the order in which they were followed."

    def variables(self, result: Any, key: str) -> dict[str, Variable]:
        """Return the arrays of loci."""
        model, vary = result.model, result.vary
        points = [point for locus in result.loci for point in locus.special]
        # All coefficients of the first point, then those of the next.
        forms = [(row, *item) for row, p in enumerate(points) for item in p.coefficients.items()]
        return {
            **names("parameter", [model.parameter(name) for name in vary]),
            **super().variables(result, key),
            **FORMS.arrays(forms, axes_of(result), [row for row, _, _ in forms]),
        }

    def read(self, saved: SavedTable, result: Any, key: str) -> tuple[Locus, ...]:
        """Return the loci."""
        forms, found, row = FORMS.rows_by_owner(saved), [], 0
        for locus in super().read(saved, result, key):
            points = []
            for point in locus.special:
                pairs = [FORMS.fields(saved, {}, each) for each in forms[row]]
                named = {pair["name"]: pair["value"] for pair in pairs}
                points.append(replace(point, coefficients=named))
                row += 1
            found.append(replace(locus, special=tuple(points)))
        return tuple(found)

    def made(self, result: Any, fields: dict[str, Any], outputs: tuple[str, ...]) -> Locus:
        """Return a locus from its fields."""
        base = dict(zip(result.vary, fields.pop("base"), strict=True))
        durations = fields.get("durations")
        if durations is not None:
            base["duration"] = float(durations[0])
            fields["durations"] = durations if fields["kind"] == "periodic" else None
        return Locus(model=result.model.replace(**base), vary=result.vary, **fields)

    def made_point(
        self, result: Any, fields: dict[str, Any], outputs: tuple[str, ...]
    ) -> LocusPoint:
        """Return a special point from its fields, without its coefficients."""
        model = self.model_of(result, fields, fields["values"])
        return LocusPoint(model=model, vary=result.vary, coefficients={}, **fields)


@dataclass(frozen=True, eq=False)
class LocusDiagram(CurveDiagram):
    """Bifurcations of a model in a plane of two parameters; frozen.

    Made by `slipfold.locus`, `slipfold.bifurcation_set` and `slipfold.load`.

    Notes
    -----
    ``locus_of_point`` is the number of the locus, and likewise for special points, their
    coefficients along ``normal_form``, regions, checks and motions. `plot` draws the loci and,
    without ``regions=False``, the regions between them.
    """

    schema = "slipfold.locus/1"
    row = "a point or special point of a locus"
    thing = "locus"
    noted = ("limit", "closed", "codimension-2", "family", "unresolved", "interrupted", "points")
    title = "bifurcations of {0.model.name} over {0.vary[0]} and {0.vary[1]}"

    model: Model
    vary: Annotated[tuple[str, str], "Names of the two parameters."]
    window: Annotated[Window, "Lowest and highest value of each."]
    loci: Annotated[tuple[Locus, ...], Loci()]
    regions: Annotated[RegionMap | None, REGION_MAP]
    settings: Settings
    provenance: Provenance
    interrupted: bool = False
    checked: Checked | None = None
    missing: Annotated[
        tuple[str, ...],
        "Sentences on what was found in the window and could not be followed, and on why there are "
        "no regions.",
    ] = ()

    @property
    def special(self) -> tuple[LabeledLocus, ...]:
        """All special points, each with its locus, locus after locus."""
        return tuple(LabeledLocus(locus, point) for locus in self.loci for point in locus.special)

    @property
    def _curves(self) -> tuple[Locus, ...]:
        return self.loci

    @property
    def _spans(self) -> dict[str, tuple[float, float]]:
        return dict(zip(self.vary, self.window, strict=True))

    def __repr__(self) -> str:
        """One line: the plane, how many loci, and what was found on them."""
        return f"<{self._found('loci')}>"

    def _head(self) -> str:
        return f"{self.model.name}: bifurcations for {self._span_text()}"

    def _sections(self) -> list[PrintedTable | list[str]]:
        regions = self.regions
        result: list[PrintedTable | list[str]] = [self._rows(), self._notes()]
        if regions is not None:
            result += [_regions_table(self), self._disagreements(regions)]
        return result

    def _rows(self) -> PrintedTable:
        """Return the ends and special points of all loci, numbered throughout."""
        quantities = {locus.quantity for locus in self.loci} - {""}
        height = ["measured" if len(quantities) > 1 else one for one in sorted(quantities)[:1]]
        only = self.loci and all(locus.quantity for locus in self.loci)
        forms = [] if only else ["criticality", "coefficients"]
        lines = []
        for label, (locus, index, kind, values, note, point) in enumerate(self._marks(), 1):
            begin = [locus.id, locus.type, locus.period, index + 1, kind, label]
            line = [*map(str, begin), *(f"{value:.10g}" for value in values)]
            if height:
                along = math.nan if locus.measured is None else locus.measured[index]
                measured = along if point is None else point.measured
                line.append("" if math.isnan(measured) else f"{measured:.6g}")
            if forms:
                named = {} if point is None else point.coefficients
                word = locus.criticality[index] if point is None else point.criticality
                shown = (f"{name} = {value:.6g}" for name, value in named.items())
                line += [word or "", ", ".join(shown)]
            lines.append([*line, note])
        heads = ["LO", "type", "period", "PT", "TY", "LAB", *self.vary, *height, *forms, ""]
        return PrintedTable(heads, lines, ("type", "TY", *forms, ""))

    def _notes(self) -> list[str]:
        notes = [sentence for locus in self.loci for sentence in self._endings(locus)]
        if not self.loci:
            notes.append("No locus was found in this window.")
            notes += [] if self.model.forced else [FROM_A_CYCLE]
            notes += [IF_GIVEN] if contacts_of(self.model) else []
        if self.interrupted:
            notes.append("Interrupted: some of the set is missing.")
        notes += self._uncertain()
        missing = [capitalized(item, self.model.parameters) for item in self.missing]
        return [*notes, *missing, *super()._notes()]

    def _endings(self, locus: Locus) -> list[str]:
        size = f"{locus.heading}, {len(locus)} points"
        size += f", from locus {locus.parent}" if locus.parent is not None else ""
        if locus.closed:
            return [f"Locus {locus.id} ({size}): {locus.stopped.reason}"]
        begins = f"begins at {self._at(locus.started.values)}: {locus.started.reason}"
        ends = f"ends at {self._at(locus.stopped.values)}: {locus.stopped.reason}"
        return [f"Locus {locus.id} ({size}) {begins}", f"Locus {locus.id} {ends}"]

    def _disagreements(self, regions: RegionMap) -> list[str]:
        """Why labels of regions are uncertain: simulations or responses contradict them."""
        sentences = []
        for region in regions.regions:
            title = f"Region {region.id} ({region.claim})"
            sentences += [
                f"{title} at {self._at(check.values)}, started {check.begins}: {check.note}"
                for check in region.checks
                if not check.agrees
            ]
            if not region.consistent:
                what = "bifurcations of sticking orbits" if region.sticking else "branch points"
                sentences.append(
                    f"{title}: responses across it contradict the label; {what} whose loci are "
                    "not known may divide it"
                )
        return sentences

    def _record(self) -> dict[str, Any]:
        return {
            "plane": self.vary,
            "window": self.window,
            "interrupted": self.interrupted,
            **({"missing": self.missing} if self.missing else {}),
            "loci": Loci().record(self, "loci"),
            "regions": REGION_MAP.record(self, "regions"),
        }

    def _frame(self) -> Frame:
        first = ("locus", "type", "period", "special", "criticality", *self.vary)
        return self._rows_along(self.loci, ("type", "period"), first)
