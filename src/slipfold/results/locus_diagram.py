"""A bifurcation set: loci in a plane of two parameters, with the regions between them."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.settings import Settings
from slipfold.checks.checked import Checked
from slipfold.drawing import draw
from slipfold.loci.locus import Locus, LocusEnd, LocusPoint, hopf_duration
from slipfold.loci.region_map import RegionMap
from slipfold.loci.window import Window
from slipfold.models.model import Model
from slipfold.results.column import COMPLEX, REAL, TEXT, WHOLE, Column
from slipfold.results.criticality import criticalities, point_criticality
from slipfold.results.labelled_table import Variable
from slipfold.results.locus_summary import LocusSummary
from slipfold.results.provenance import Provenance
from slipfold.results.regions import read_regions, region_records, region_variables
from slipfold.results.result import Result
from slipfold.results.saved_table import SavedTable
from slipfold.results.sheet import Sheet
from slipfold.results.table import Table, axes_of, ends, meaning_of, names
from slipfold.text.one_line import listed

__all__ = ["LabelledLocus", "LocusDiagram"]


class LabelledLocus(NamedTuple):
    """A special point with the locus that it lies on."""

    locus: Locus
    point: LocusPoint

    def __repr__(self) -> str:
        return f"<{self.point._line()}; on locus {self.locus.id}>"

    def _repr_html_(self) -> str:
        return self.point._repr_html_()


@dataclass(frozen=True, eq=False)
class LocusDiagram(Result):
    """Bifurcations of a model in a plane of two parameters; frozen.

    Made by `slipfold.locus`, `slipfold.bifurcation_set` and `slipfold.load`.

    Parameters
    ----------
    model
        The model; the values of `vary` are those of a corner of the window.
    vary
        Names of the two parameters.
    window
        Least and largest value of each.
    loci
        The loci, in the order in which they were followed.
    regions
        Which stable responses exist where; None if that was not asked for.
    settings
        Options of continuation.
    provenance
        Versions and time.
    interrupted
        Whether the computation was interrupted, so that some of the set is missing.
    checked
        Ends and special points of loci that were computed again by other means; None if nothing
        was.

    Notes
    -----
    In the dataset of `to_xarray`, along ``point``: the points of all loci, one after the other;
    ``locus_of_point`` says whose. Along ``special``: the special points; along ``normal_form``:
    their coefficients. Along ``parameter``: the two parameters. The regions are in
    ``region_of_cell`` over ``first`` and ``second``, and along ``region`` and ``check``. In the
    spreadsheet of `to_csv`, one row a point, special points among them in their order. In
    `to_json`, schema slipfold.locus/1, loci, special points and regions.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.05), f=12.5)
    >>> found = sf.locus(diagram.special[0], ("f", "Nd"), ((12.4, 12.6), (0, 0.1)), switch=False)
    >>> found.loci[0].type, found.loci[0].stopped.kind
    ('PD', 'window')
    """

    schema = "slipfold.locus/1"

    model: Model
    vary: tuple[str, str]
    window: Window
    loci: tuple[Locus, ...]
    regions: RegionMap | None
    settings: Settings
    provenance: Provenance
    interrupted: bool = False
    checked: Checked | None = None

    @property
    def special(self) -> tuple[LabelledLocus, ...]:
        """All special points, each with its locus, locus after locus."""
        return tuple(LabelledLocus(locus, point) for locus in self.loci for point in locus.special)

    @property
    def failed(self) -> bool:
        """Whether a locus was given up, at either end, before it came to an end of its own."""
        return any(locus.begun.early or locus.stopped.early for locus in self.loci)

    def summary(self) -> str:
        """Return tables of ends, special points and regions, and why loci begin and end."""
        return self._summary().text()

    def plot(self, **options: Any) -> Any:
        """Draw the loci in their plane, and the regions between them.

        Parameters
        ----------
        **options
            Options of the drawing, e.g. ``regions=False`` and ``ax=`` the axes to draw in.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.
        """
        return draw(self, **options)

    def __repr__(self) -> str:
        """One line: the plane, how many loci, and what was found on them."""
        spans = ", ".join(
            f"{name} = {low:g} to {high:g}"
            for name, (low, high) in zip(self.vary, self.window, strict=True)
        )
        found = listed((point.type for _, point in self.special), "no special points")
        return f"<LocusDiagram of {self.model.name}: {spans}, {len(self.loci)} loci, {found}>"

    def _repr_html_(self) -> str:
        return self._summary().html()

    def _summary(self) -> LocusSummary:
        what = (self.model, self.vary, self.window, self.loci, self.regions, self.interrupted)
        return LocusSummary(*what, self._remarks())

    def _title(self) -> str:
        return f"bifurcations of {self.model.name} over {' and '.join(self.vary)}"

    def _given(self) -> dict[str, Any]:
        return {
            "vary": list(self.vary),
            "window": [list(span) for span in self.window],
            "settings": asdict(self.settings),
            "regions": self.regions is not None,
            "interrupted": self.interrupted,
        }

    def _attributes(self) -> dict[str, Any]:
        window = np.array(self.window, dtype=float).ravel()
        return {"vary": " ".join(self.vary), "window": window}

    def _variables(self) -> dict[str, Variable]:
        model, loci = self.model, self.loci
        tables = _Tables.of(model, self.vary)
        points = [point for _, point in self.special]
        sizes = [locus.nodes.shape[1] for locus in loci] + [len(p.nodes) for p in points]
        axes = axes_of(model, self.vary, max(sizes, default=0))
        described = [model.parameter(name) for name in self.vary]
        variables = names("state", model.states) | names("parameter", described)
        variables |= tables.loci.variables(loci, axes)
        variables |= tables.points.variables(loci, axes, [locus.id for locus in loci])
        owners = [locus.id for locus, _ in self.special]
        variables |= tables.special.variables(points, axes, owners)
        # As many as a point has, one after the other.
        forms = [(row, *item) for row, p in enumerate(points) for item in p.coefficients.items()]
        variables |= FORMS.variables(forms, axes, [row for row, _, _ in forms])
        if self.regions is not None:
            variables |= region_variables(self.regions, model, self.vary, axes)
        return variables

    def _record(self) -> dict[str, Any]:
        table = _Tables.of(self.model, self.vary).loci
        return {
            "plane": self.vary,
            "window": self.window,
            "interrupted": self.interrupted,
            "loci": [table.record(locus) for locus in self.loci],
            "regions": region_records(self.regions),
        }

    def _csv(self) -> str:
        tables = _Tables.of(self.model, self.vary)
        heads = {
            "id": "locus",
            "type": "type",
            "period": "period",
            "special": "special",
            "criticality": "criticality",
            "values": "",
            "state": "",
            "multipliers": "multiplier",
            "coefficient": "coefficient",
            "named": "coefficients",
            "residual": "residual",
            "arclength": "arclength",
        }
        axes = axes_of(self.model, self.vary)
        sheet = Sheet(heads, (tables.points, tables.special), axes)
        rows = []
        for locus in self.loci:
            known = {"id": locus.id, "type": locus.type, "period": locus.period}
            points = sheet.rows(tables.points, [locus], known)
            words = [point_criticality(locus, point) or "" for point in locus.special]
            special = sheet.rows(tables.special, locus.special, known | {"criticality": words})
            rows += sorted([*points, *special], key=lambda row: row[-1])
        return sheet.text(rows)

    @classmethod
    def _read(cls, saved: SavedTable) -> LocusDiagram:
        given = saved.given
        first, second = (saved.model.parameter(name).name for name in given["vary"])
        (a, b), (c, d) = given["window"]
        vary = (first, second)
        axes = axes_of(saved.model, vary)
        return cls(
            saved.model,
            vary,
            ((float(a), float(b)), (float(c), float(d))),
            _loci(saved, vary),
            read_regions(saved, vary, axes) if given["regions"] else None,
            saved.settings,
            saved.provenance,
            bool(given["interrupted"]),
            saved.checked,
        )


class _Tables(NamedTuple):
    """What is said of loci, of their points and of their special points."""

    loci: Table
    points: Table
    special: Table

    @classmethod
    def of(cls, model: Model, vary: tuple[str, str]) -> _Tables:
        meaning = "; ".join(meaning_of(model.parameter(name)) for name in vary)
        special = _special_table(meaning, model.forced)
        return cls(_locus_table(vary, special), _point_table(meaning, model.forced), special)


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

LASTING = "of one round; of an equilibrium, what multipliers are over"


def _locus_table(vary: tuple[str, str], special: Table) -> Table:
    columns = (
        Column("id", WHOLE, "number of the locus", name="locus", label=True, record=True),
        Column("type", TEXT, "type of bifurcation", record=True),
        Column("kind", TEXT, "what it consists of", record=True),
        Column("period", WHOLE, "in forcing periods", "", record=True),
        Column("parent", WHOLE, "locus left, 0: none", optional=True, record=True),
        Column("node_count", WHOLE, "nodes of an orbit", "",
               get=lambda locus: locus.nodes.shape[1], name="node_count"),
        Column("base", REAL, "values of the parameters in the model that the locus was followed "
               "with", None, ("parameter",),
               get=lambda locus: [locus.model.values[name] for name in vary]),
        Column("points", WHOLE, get=len, record=True),
        Column("values", record=True),
        Column("criticality", record=True,
               get=lambda locus: None if locus.type == "LP" else criticalities(locus)),
        Column("coefficient", record=True),
        Column("durations", get=_cycle_durations, record=True),
        Column("eigenvalues", record=True),
        Column("special", get=lambda locus: [special.record(p) for p in locus.special],
               record=True),
        *ends("locus", "values", "where", None, "parameter"),
    )  # fmt: skip
    return Table(("locus",), columns, "locus_")


def _point_table(meaning: str, forced: bool) -> Table:
    timed = (
        Column("durations", REAL, LASTING, "s", get=_durations, name="duration"),
        Column("eigenvalues", COMPLEX, "of equilibria; NaN: a cycle", "1/s", ("multiplier",),
               get=_eigenvalues, derived=True),
    )  # fmt: skip
    columns = (
        Column("values", REAL, meaning, None, ("parameter",), name="value"),
        Column("states", REAL, "state at phase zero", None, ("state",), derived=True, slot="state"),
        Column("nodes", REAL,
               "states at equal phases over the period, the first node_count of the locus",
               None, ("node", "state")),
        Column("multipliers", COMPLEX, "Floquet multipliers", "", ("multiplier",)),
        Column("coefficient", REAL, "of the normal form of the bifurcation, NaN: not defined",
               optional=True),
        Column("criticality", TEXT, "empty: no meaning, or not known", derived=True,
               get=lambda locus: [word or "" for word in criticalities(locus)]),
        *(() if forced else timed),
        Column("residual", REAL, "how far the orbit fails to close, in scaled states", ""),
        Column("arclength", REAL, "in scaled variables", ""),
    )  # fmt: skip
    return Table(("point",), columns, owner=("locus", "locus the point lies on"), joined=True)


def _special_table(meaning: str, forced: bool) -> Table:
    own_duration = Column(
        "own_duration", REAL, LASTING, "s",
        get=lambda point: point.model.values["duration"], name="special_duration",
    )  # fmt: skip
    columns = (
        Column("type", TEXT, "type of special point", record=True, slot="special"),
        Column("name", TEXT, "what the type means", record=True),
        Column("kind", TEXT, "what it is a point of"),
        Column("values", REAL, meaning, None, ("parameter",), name="special_value", record=True),
        Column("uncertainty", REAL, "computed uncertainty of special_value", None, ("parameter",),
               record=True),
        Column("period", WHOLE, "in forcing periods", "", slot=""),
        *(() if forced else (own_duration,)),
        Column("node_count", WHOLE, "nodes of the orbit", "", get=lambda point: len(point.nodes)),
        Column("nodes", REAL,
               "states at equal phases over the period, the first special_node_count",
               None, ("node", "state")),
        Column("state", dimensions=("state",), record=True),
        Column("multipliers", COMPLEX, "Floquet multipliers", "", ("multiplier",), record=True),
        Column("eigenvalues", record=True),
        Column("duration", record=True),
        Column("coefficients", record=True),
        Column("named", TEXT, get=lambda point: "; ".join(
            f"{name} = {value!r}" for name, value in point.coefficients.items())),
        Column("coefficient", get=lambda point: next(iter(point.coefficients.values()), None),
               record=True, slot=""),
        Column("residual", REAL, "how far the orbit fails to close, in scaled states", ""),
        Column("arclength", REAL, "position on the locus", ""),
        Column("leads_to", WHOLE, "loci begun here, 0: no more", None, ("start",), record=True),
    )  # fmt: skip
    return Table(("special",), columns, "special_", ("locus", "locus it lies on"))


def _durations(locus: Locus) -> NDArray[np.float64]:
    if locus.durations is not None:
        return locus.durations
    return np.full(len(locus), locus.model.values["duration"])


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


def _loci(saved: SavedTable, vary: tuple[str, str]) -> tuple[Locus, ...]:
    axes, tables = axes_of(saved.model, vary), _Tables.of(saved.model, vary)
    points, special = tables.points.rows(saved), tables.special.rows(saved)
    forms = FORMS.rows(saved)
    loci = []
    for row, identity in enumerate(saved.columns["locus"].tolist()):
        fields = tables.loci.read(saved, axes, row)
        fields |= tables.points.read(saved, axes, points[identity])
        found = []
        for each in special[identity]:
            pairs = [FORMS.read(saved, axes, form) for form in forms[int(each)]]
            own = tables.special.read(saved, axes, each)
            own["coefficients"] = {pair["name"]: pair["value"] for pair in pairs}
            found.append(_point(saved.model, vary, own))
        loci.append(_locus(saved.model, vary, fields, tuple(found)))
    return tuple(loci)


def _locus(
    model: Model, vary: tuple[str, str], fields: dict[str, Any], special: tuple[LocusPoint, ...]
) -> Locus:
    base = dict(zip(vary, fields.pop("base"), strict=True))
    durations = fields.pop("durations", None)
    if durations is not None:
        base["duration"] = float(durations[0])
        fields["durations"] = durations if fields["kind"] == "periodic" else None
    fields["nodes"] = fields["nodes"][:, : fields.pop("node_count")]
    fields |= {which: LocusEnd(*fields[which].values()) for which in ("begun", "stopped")}
    return Locus(model=model.replace(**base), vary=vary, special=special, **fields)


def _point(model: Model, vary: tuple[str, str], fields: dict[str, Any]) -> LocusPoint:
    changes = dict(zip(vary, fields["values"], strict=True))
    if not model.forced:
        changes["duration"] = fields.pop("own_duration")
    fields["nodes"] = fields["nodes"][: fields.pop("node_count")]
    return LocusPoint(model=model.replace(**changes), vary=vary, **fields)
