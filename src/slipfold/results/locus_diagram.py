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
from slipfold.loci.locus import Locus, LocusPoint, hopf_duration
from slipfold.loci.region_map import RegionMap
from slipfold.loci.window import Window
from slipfold.models.model import Model
from slipfold.results.column import COMPLEX, REAL, TEXT, WHOLE, Axes, Column
from slipfold.results.criticality import criticalities, point_criticality
from slipfold.results.curves import LASTING, Curves, sticking
from slipfold.results.labelled_table import Variable
from slipfold.results.locus_summary import LocusSummary
from slipfold.results.provenance import Provenance
from slipfold.results.regions import read_regions, region_records, region_variables
from slipfold.results.result import Result
from slipfold.results.saved_table import SavedTable
from slipfold.results.table import Table, axes_of, meaning_of, names
from slipfold.text.one_line import capitalised, listed

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
    missing
        Sentences on what was found in the window and could not be followed.

    Notes
    -----
    In the dataset of `to_xarray`, along ``point``: the points of all loci, one after the other;
    ``locus_of_point`` says whose. Along ``special``: the special points; along ``normal_form``:
    their coefficients. Along ``parameter``: the two parameters. The regions are in
    ``region_of_cell`` over ``first`` and ``second``, and along ``region``, ``check`` and
    ``motion``. In the spreadsheet of `to_csv`, one row a point, special points among them in their
    order. In `to_json`, schema slipfold.locus/1, loci, special points and regions.

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
    missing: tuple[str, ...] = ()

    @property
    def special(self) -> tuple[LabelledLocus, ...]:
        """All special points, each with its locus, locus after locus."""
        return tuple(LabelledLocus(locus, point) for locus in self.loci for point in locus.special)

    @property
    def failed(self) -> bool:
        """Whether a locus was given up, at either end, before it came to an end of its own."""
        return any(locus.begun.early or locus.stopped.early for locus in self.loci)

    @property
    def _sticks(self) -> bool:
        """Whether any of the loci goes through stick."""
        return any(locus.stuck_fraction is not None for locus in self.loci)

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

    def _remarks(self) -> list[str]:
        return [
            *(capitalised(item, self.model.parameters) for item in self.missing),
            *super()._remarks(),
        ]

    def _title(self) -> str:
        return f"bifurcations of {self.model.name} over {' and '.join(self.vary)}"

    def _given(self) -> dict[str, Any]:
        return {
            "vary": list(self.vary),
            "window": [list(span) for span in self.window],
            "settings": asdict(self.settings),
            "regions": self.regions is not None,
            "interrupted": self.interrupted,
            "missing": list(self.missing),
        }

    def _attributes(self) -> dict[str, Any]:
        window = np.array(self.window, dtype=float).ravel()
        return {"vary": " ".join(self.vary), "window": window}

    def _variables(self) -> dict[str, Variable]:
        model, points = self.model, [point for _, point in self.special]
        axes = axes_of(model, self.vary)
        described = [model.parameter(name) for name in self.vary]
        variables = names("state", model.states) | names("parameter", described)
        variables |= _curves(model, self.vary, self._sticks).variables(self.loci, model, self.vary)
        # As many as a point has, one after the other.
        forms = [(row, *item) for row, p in enumerate(points) for item in p.coefficients.items()]
        variables |= FORMS.variables(forms, axes, [row for row, _, _ in forms])
        if self.regions is not None:
            variables |= region_variables(self.regions, model, self.vary, axes)
        return variables

    def _record(self) -> dict[str, Any]:
        table = _curves(self.model, self.vary, self._sticks).curves
        return {
            "plane": self.vary,
            "window": self.window,
            "interrupted": self.interrupted,
            **({"missing": self.missing} if self.missing else {}),
            "loci": [table.record(locus) for locus in self.loci],
            "regions": region_records(self.regions),
        }

    def _csv(self) -> str:
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
            "stuck_fraction": "stuck fraction",
            "residual": "residual",
            "arclength": "arclength",
        }
        return _curves(self.model, self.vary, self._sticks).csv(
            self.loci,
            heads,
            axes_of(self.model, self.vary),
            lambda locus: {"id": locus.id, "type": locus.type, "period": locus.period},
            lambda locus: {
                "criticality": [point_criticality(locus, point) or "" for point in locus.special]
            },
        )

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
            _loci(saved, vary, axes),
            read_regions(saved, vary, axes) if given["regions"] else None,
            saved.settings,
            saved.provenance,
            bool(given["interrupted"]),
            saved.checked,
            tuple(given.get("missing", ())),
        )


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


def _curves(model: Model, vary: tuple[str, str], sticks: bool) -> Curves:
    meaning = "; ".join(meaning_of(model.parameter(name)) for name in vary)
    pair = ("parameter",)
    eigenvalues = Column(
        "eigenvalues", COMPLEX, "of equilibria; NaN: a cycle", "1/s", ("multiplier",),
        get=_eigenvalues, derived=True,
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
        points=(Column("values", REAL, meaning, None, pair, name="value"),),
        along=(
            Column("coefficient", REAL, "of the normal form of the bifurcation, NaN: not defined",
                   optional=True),
            Column("criticality", TEXT, "empty: no meaning, or not known", derived=True,
                   get=lambda locus: [word or "" for word in criticalities(locus)]),
            *(() if model.forced else (eigenvalues,)),
            *sticking(sticks, lambda locus: locus.stuck_fraction, point=False),
        ),
        special=(
            Column("name", TEXT, "what the type means", record=True),
            Column("kind", TEXT, "what it is a point of"),
            Column("values", REAL, meaning, None, pair, name="special_value", record=True),
            Column("uncertainty", REAL, "computed uncertainty of special_value", None, pair,
                   record=True),
        ),
        at=(
            Column("eigenvalues", record=True),
            Column("duration", record=True),
            Column("coefficients", record=True),
            Column("named", TEXT, get=_named_coefficients),
            Column("coefficient", record=True, slot="",
                   get=lambda point: next(iter(point.coefficients.values()), None)),
            Column("leads_to", WHOLE, "loci begun here, 0: no more", None, ("start",), record=True),
            *sticking(sticks, lambda point: point.stuck_fraction, point=True),
        ),
        lasting=LASTING,
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


def _loci(saved: SavedTable, vary: tuple[str, str], axes: Axes) -> tuple[Locus, ...]:
    forms, loci = FORMS.rows(saved), []
    curves = _curves(saved.model, vary, "stuck_fraction" in saved.columns)
    for fields, found in curves.read(saved, axes):
        special = []
        for row, own in found:
            pairs = [FORMS.read(saved, axes, each) for each in forms[row]]
            own["coefficients"] = {pair["name"]: pair["value"] for pair in pairs}
            special.append(_point(saved.model, vary, own))
        loci.append(_locus(saved.model, vary, fields | {"special": tuple(special)}))
    return tuple(loci)


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
