"""A bifurcation set: loci in a plane of two parameters, with the regions between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from operator import itemgetter
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.settings import Settings
from slipfold.loci.locus import (
    CODIMENSION_TWO,
    COEFFICIENT,
    Locus,
    LocusPoint,
    hopf_duration,
    locus_title,
)
from slipfold.loci.region_map import RegionMap
from slipfold.loci.window import Window
from slipfold.models.model import Model
from slipfold.orbits.normal_forms.normal_form import criticality_of
from slipfold.results.checks.checked import Checked
from slipfold.results.curves import (
    LASTING,
    CurveDiagram,
    Curves,
    sticking,
)
from slipfold.results.fields import (
    COMPLEX,
    REAL,
    TEXT,
    WHOLE,
    Column,
    Part,
    Table,
    axes_of,
    meaning_of,
    names,
)
from slipfold.results.records import Provenance, SavedTable
from slipfold.results.regions import Regions
from slipfold.results.tables import Frame, Variable
from slipfold.text.one_line import capitalized
from slipfold.text.printed_table import PrintedTable


def criticalities(locus: Locus) -> list[str | None]:
    """Return whether the bifurcation is super- or subcritical at each point of a locus."""
    return [_in_words(locus, float(value)) for value in locus.coefficient]


def point_criticality(locus: Locus, point: LocusPoint) -> str | None:
    """Return whether the bifurcation is super- or subcritical at an extremum of a locus."""
    name = COEFFICIENT.get(locus.type, "")
    if point.type in CODIMENSION_TWO or name not in point.coefficients:
        return None
    return _in_words(locus, point.coefficients[name])


def _in_words(locus: Locus, coefficient: float) -> str | None:
    """Judge a coefficient relative to the others, whatever the units of the states."""
    size = float(np.nan_to_num(np.abs(locus.coefficient)).max(initial=0.0))
    return criticality_of(locus.type, coefficient / (size or 1.0))


FROM_A_CYCLE = (
    "The equilibria found were followed across it, and cycles born on them there; for loci of "
    "another cycle save a response that has it (--settled) and give that file."
)
"""Advice for an autonomous model without loci."""


def _regions_table(diagram: LocusDiagram) -> PrintedTable:
    assert diagram.regions is not None
    heads, lines = ["region", "stable", "share", *diagram.vary, "responses", "checks"], []
    with_motions = any(region.motions for region in diagram.regions.regions)
    for region in diagram.regions.regions:
        agreeing = sum(check.agrees for check in region.checks)
        checks = f"{agreeing} of {len(region.checks)} agree" if region.checks else "none"
        place = [f"{value:.6g}" for value in region.place]
        responses = "agree" if region.consistent else "disagree"
        line = [str(region.id), region.name, f"{region.share:.2%}", *place, responses, checks]
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


@dataclass(frozen=True)
class Loci(Part):
    """Loci as an attribute of a diagram."""

    doc = "The loci, in the order in which they were followed."

    def variables(self, result: Any, key: str) -> dict[str, Variable]:
        """Return the arrays of loci."""
        model, vary, loci = result.model, result.vary, result.loci
        sticks = any(locus.stuck_fraction is not None for locus in loci)
        points = [point for locus in loci for point in locus.special]
        words = {
            id(point): point_criticality(locus, point) or ""
            for locus in loci
            for point in locus.special
        }
        # As many as a point has, one after the other.
        forms = [(row, *item) for row, p in enumerate(points) for item in p.coefficients.items()]
        return {
            **names("parameter", [model.parameter(name) for name in vary]),
            **_curves(model, vary, sticks, words).variables(loci, model, vary),
            **FORMS.variables(forms, axes_of(model, vary), [row for row, _, _ in forms]),
        }

    def read(self, saved: SavedTable, result: Any, key: str) -> tuple[Locus, ...]:
        """Return the loci."""
        vary = result.vary
        forms, loci, axes = FORMS.rows(saved), [], axes_of(saved.model, vary)
        curves = _curves(saved.model, vary, "stuck_fraction" in saved.columns)
        for fields in curves.read(saved, axes):
            for row, own in fields["special"].items():
                pairs = [FORMS.read(saved, axes, each) for each in forms[row]]
                own["coefficients"] = {pair["name"]: pair["value"] for pair in pairs}
            points = fields["special"].values()
            fields["special"] = tuple(_point(saved.model, vary, own) for own in points)
            loci.append(_locus(saved.model, vary, fields))
        return tuple(loci)

    def record(self, result: Any, key: str) -> list[dict[str, Any]]:
        """Return a record of each locus."""
        table = _curves(result.model, result.vary, result._sticks).curves
        return [table.record(locus) for locus in result.loci]


@dataclass(frozen=True, eq=False)
class LocusDiagram(CurveDiagram):
    """Bifurcations of a model in a plane of two parameters; frozen.

    Made by `slipfold.locus`, `slipfold.bifurcation_set` and `slipfold.load`.

    Notes
    -----
    In the dataset of `to_xarray`, along ``point``: the points of all loci, one after the other;
    ``locus_of_point`` says whose. Along ``special``: the special points; along ``normal_form``:
    their coefficients. Along ``parameter``: the two parameters. The regions are in
    ``region_of_cell`` over ``first`` and ``second``, and along ``region``, ``check`` and
    ``motion``. In the spreadsheet of `to_csv`, one row a point, special points among them in their
    order. In `to_json`, schema slipfold.locus/1, loci, special points and regions. `plot` draws
    the loci and, without ``regions=False``, the regions between them.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.05), f=12.5)
    >>> found = sf.locus(diagram.special[0], ("f", "Nd"), ((12.4, 12.6), (0, 0.1)), switch=False)
    >>> found.loci[0].type, found.loci[0].stopped.kind
    ('PD', 'window')
    """

    schema = "slipfold.locus/1"
    noted = ("limit", "closed", "codimension-2", "unresolved", "interrupted", "points")
    title = "bifurcations of {0.model.name} over {0.vary[0]} and {0.vary[1]}"

    model: Model
    vary: Annotated[tuple[str, str], "Names of the two parameters."]
    window: Annotated[Window, "Lowest and highest value of each."]
    loci: Annotated[tuple[Locus, ...], Loci()]
    regions: Annotated[RegionMap | None, Regions()]
    settings: Settings
    provenance: Provenance
    interrupted: bool = False
    checked: Checked | None = None
    missing: Annotated[
        tuple[str, ...], "Sentences on what was found in the window and could not be followed."
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

    @property
    def _sticks(self) -> bool:
        """Whether any of the loci goes through stick."""
        return any(locus.stuck_fraction is not None for locus in self.loci)

    def __repr__(self) -> str:
        """One line: the plane, how many loci, and what was found on them."""
        return f"<{self._found('loci')}>"

    def _head(self) -> str:
        return f"{self.model.name}: bifurcations for {self._span_text()}"

    def _sections(self) -> list[PrintedTable | list[str]]:
        regions = self.regions
        found: list[PrintedTable | list[str]] = [self._rows(), self._notes()]
        if regions is not None:
            found += [_regions_table(self), self._disagreements(regions)]
        return found

    def _rows(self) -> PrintedTable:
        """Return the ends and special points of all loci, numbered throughout."""
        heads = ["LO", "type", "period", "PT", "TY", "LAB", *self.vary, "criticality"]
        lines = []
        for label, (locus, index, kind, values, note, point) in enumerate(self._marks(), 1):
            named = {} if point is None else point.coefficients
            word = criticalities(locus)[index] if point is None else point_criticality(locus, point)
            begin = [locus.id, locus.type, locus.period, index + 1, kind, label]
            coefficients = ", ".join(f"{name} = {value:.6g}" for name, value in named.items())
            shown = (f"{value:.10g}" for value in values)
            lines.append([*map(str, begin), *shown, word or "", coefficients, note])
        words = ("type", "TY", "criticality", "coefficients", "")
        return PrintedTable([*heads, "coefficients", ""], lines, words)

    def _notes(self) -> list[str]:
        notes = [sentence for locus in self.loci for sentence in self._endings(locus)]
        if not self.loci:
            notes.append("No locus was found in this window.")
            notes += [] if self.model.forced else [FROM_A_CYCLE]
        if self.interrupted:
            notes.append("Interrupted: some of the set is missing.")
        notes += self._uncertain("locus")
        missing = [capitalized(item, self.model.parameters) for item in self.missing]
        return [*notes, *missing, *super()._notes()]

    def _endings(self, locus: Locus) -> list[str]:
        size = f"{locus_title(locus.type, locus.period, locus.kind)}, {len(locus)} points"
        size += f", from locus {locus.parent}" if locus.parent is not None else ""
        if locus.closed:
            return [f"Locus {locus.id} ({size}): {locus.stopped.reason}"]
        begins = f"begins at {self._at(locus.begun.values)}: {locus.begun.reason}"
        ends = f"ends at {self._at(locus.stopped.values)}: {locus.stopped.reason}"
        return [f"Locus {locus.id} ({size}) {begins}", f"Locus {locus.id} {ends}"]

    def _disagreements(self, regions: RegionMap) -> list[str]:
        """Why regions are not known: simulations or responses do not fit what others say."""
        sentences = []
        for region in regions.regions:
            title = f"Region {region.id} ({region.claim})"
            sentences += [
                f"{title} at {self._at(check.values)}, started {check.begins}: {check.note}"
                for check in region.checks
                if not check.agrees
            ]
            if not region.consistent:
                what = "bifurcations of what sticks" if region.sticking else "branch points"
                sentences.append(
                    f"{title}: not true all over it, as responses across it show; {what}, "
                    "whose loci are not known, may divide it"
                )
        return sentences

    def _record(self) -> dict[str, Any]:
        return {
            "plane": self.vary,
            "window": self.window,
            "interrupted": self.interrupted,
            **({"missing": self.missing} if self.missing else {}),
            "loci": Loci().record(self, "loci"),
            "regions": Regions().record(self, "regions"),
        }

    def _frame(self) -> Frame:
        curves = _curves(self.model, self.vary, self._sticks)
        first = ("locus", "type", "period", "special", "criticality", *self.vary)
        return curves.frame(self._variables(), self.loci, ("type", "period"), first)


FORMS = Table(
    ("normal_form",),
    (
        Column("name", TEXT, "name of the coefficient", get=itemgetter(1)),
        Column("value", meaning="the coefficient", get=itemgetter(2)),
    ),
    "normal_form_",
    ("special", "row of the special point, from 0"),
)
"""Coefficients of normal forms of all special points."""


def _curves(
    model: Model,
    vary: tuple[str, str],
    sticks: bool,
    words: Mapping[int, str] = MappingProxyType({}),
) -> Curves:
    """Return what is said of loci; `words` are those of criticality, by the `id` of points."""
    meaning = "; ".join(meaning_of(model.parameter(name)) for name in vary)
    pair = ("parameter",)
    eigenvalues = Column(
        "eigenvalues", COMPLEX, "of equilibria; NaN: a cycle", "1/s", ("multiplier",),
        get=_eigenvalues, derived=True, head=None,
    )  # fmt: skip
    return Curves.of(
        "locus",
        model.forced,
        kinds=(
            Column("type", TEXT, "type of bifurcation", record=True),
            Column("kind", TEXT, "what it consists of", record=True),
        ),
        own=(
            Column("base", REAL, "values of the parameters in the model that the locus was "
                   "followed with", None, pair,
                   get=lambda locus: [locus.model.values[name] for name in vary]),
            Column("values", record=True),
            Column("criticality", record=True,
                   get=lambda locus: None if locus.type == "LP" else criticalities(locus)),
            Column("coefficient", record=True),
            Column("durations", get=_cycle_durations, record=True),
            Column("eigenvalues", record=True),
        ),
        ends=("values", "where", None, pair),
        points=(Column("values", REAL, meaning, None, pair, name="value", head=""),),
        along=(
            Column("coefficient", REAL, "of the normal form of the bifurcation, NaN: not defined"),
            Column("criticality", TEXT, "empty: no meaning, or not known", derived=True,
                   get=lambda locus: [word or "" for word in criticalities(locus)]),
            *(() if model.forced else (eigenvalues,)),
            *sticking(sticks, lambda locus: locus.stuck_fraction, point=False),
        ),
        special=(
            Column("name", TEXT, "what the type means", record=True, head=None),
            Column("kind", TEXT, "what it is a point of", head=None),
            Column("values", REAL, meaning, None, pair, name="special_value", record=True,
                   head=""),
            Column("uncertainty", REAL, "computed uncertainty of special_value", None, pair,
                   record=True, head=None),
            Column("criticality", TEXT, "empty: no meaning, or not known", derived=True,
                   get=lambda point: words[id(point)]),
        ),
        at=(
            Column("eigenvalues", record=True),
            Column("duration", record=True),
            Column("coefficients", record=True),
            Column("named", TEXT, "coefficients by name", get=_named_coefficients, derived=True,
                   name="special_coefficients", head="coefficients"),
            Column("coefficient", record=True,
                   get=lambda point: next(iter(point.coefficients.values()), None)),
            Column("leads_to", WHOLE, "loci begun here, 0: no more", None, ("start",), record=True,
                   head=None),
            *sticking(sticks, lambda point: point.stuck_fraction, point=True),
        ),
        lasting=LASTING,
        head="special",
    )  # fmt: skip


def _named_coefficients(point: LocusPoint) -> str:
    return "; ".join(f"{name} = {value!r}" for name, value in point.coefficients.items())


def _cycle_durations(locus: Locus) -> Any:
    """Periods of the orbits in seconds; of Hopf points, those of the cycles born there."""
    if locus.model.forced:
        return None
    if locus.durations is not None:
        return locus.period * locus.durations
    return [
        hopf_duration(each) for each in ([] if locus.eigenvalues is None else locus.eigenvalues)
    ]


def _eigenvalues(locus: Locus) -> NDArray[np.complex128]:
    found = locus.eigenvalues
    return np.full(locus.multipliers.shape, np.nan + 0j) if found is None else found


def _locus(model: Model, vary: tuple[str, str], fields: dict[str, Any]) -> Locus:
    base = dict(zip(vary, fields.pop("base"), strict=True))
    durations = fields.pop("durations", None)
    if np.isnan(fields.get("stuck_fraction", np.nan)).all():
        fields["stuck_fraction"] = None
    if durations is not None:
        base["duration"] = float(durations[0])
        fields["durations"] = durations if fields["kind"] == "periodic" else None
    return Locus(model=model.replace(**base), vary=vary, **fields)


def _point(model: Model, vary: tuple[str, str], fields: dict[str, Any]) -> LocusPoint:
    changes = dict(zip(vary, fields["values"], strict=True))
    if not model.forced:
        changes["duration"] = fields.pop("model_duration")
    return LocusPoint(model=model.replace(**changes), vary=vary, **fields)
