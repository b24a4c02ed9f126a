"""Diagrams that hold curves: what those of branches and of loci share."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.bifurcations.branches.solution_curve import names_of
from slipfold.continuation.end import End
from slipfold.models.model import Model
from slipfold.models.quantities import DURATION, Parameter
from slipfold.results.fields import COMPLEX, REAL, TEXT, WHOLE, Column, Items, ResultPart, axes_of
from slipfold.results.records import SavedTable
from slipfold.results.result import Result
from slipfold.results.tables import Frame, Variable, frame_of, joined
from slipfold.text import certain, listed, outside, parameter_text, with_unit

if TYPE_CHECKING:
    from slipfold.bifurcations.branches.branch import Branch
    from slipfold.bifurcations.branches.special_point import SpecialPoint
    from slipfold.bifurcations.loci.locus import Locus, LocusPoint

UNCERTAIN = 1e-6
"""Fraction of the span above which the uncertainty of a point is reported: points are located to
1e-12, and no figure shows less."""

ROUNDING = 1e-14
"""Values below this fraction of the size of their column are rounding, and shown as zero."""


def _durations(curve: Any) -> Array:
    own: Array | None = curve.durations
    return np.full(len(curve), curve.model.values[DURATION.name]) if own is None else own


def _eigenvalues(curve: Branch | Locus) -> Complex:
    result = curve.eigenvalues
    return np.full(curve.multipliers.shape, complex(np.nan, np.nan)) if result is None else result


def _or_unknown(name: str, curve: Any) -> Array:
    own: Array | None = getattr(curve, name)
    return np.full(len(curve), np.nan) if own is None else own


def _revolutions(branch: Branch) -> list[int]:
    return [branch.revolutions.get(item.name, 0) for item in branch.model.states]


def _gradients(point: SpecialPoint) -> list[float]:
    return [(point.gradients or {}).get(item.name, np.nan) for item in point.model.parameters]


def _named_coefficients(point: LocusPoint) -> str:
    return "; ".join(f"{name} = {value!r}" for name, value in point.coefficients.items())


PLANE = "{vary[0]}; {vary[1]}"
NODES = "states at equal phases over the period, the first"
MULTIPLIERS = Column(
    "multipliers", COMPLEX, "Floquet multipliers", "", ("multiplier",), record=True,
    head="multiplier",
)  # fmt: skip
UNCERTAIN_MULTIPLIERS = Column(
    "multiplier_uncertainty", REAL, "computed uncertainty of the multipliers", "", ("multiplier",),
    record=True, head=None, when="branch",
)  # fmt: skip
UNSTABLE = Column(
    "unstable", WHOLE, "number of multipliers outside the unit circle", "", derived=True,
    head="unstable multipliers", when="branch",
)  # fmt: skip
RESIDUAL = Column("residual", REAL, "how far the orbit fails to close, in scaled states", "")
STUCK = Column(
    "stuck_fraction", REAL,
    "fraction of the period in which a contact sticks; NaN: none was watched for stick", "",
    record=True, head="stuck fraction", when="sticks",
)  # fmt: skip
EIGENVALUES = Column("eigenvalues", record=True, when="locus")

CURVE = (
    Column("id", WHOLE, "number of the {thing}", name="{thing}", label=True, record=True),
    Column("type", TEXT, "type of bifurcation", record=True, when="locus"),
    Column("quantity", TEXT, "what is measured on a locus of extrema; empty: none", record=True,
           when="measured"),
    Column("kind", TEXT, "periodic or equilibrium", record=True),
    Column("period", WHOLE, "in forcing periods", "", record=True),
    Column("parent", WHOLE, "{thing} left, 0: none", optional=True, record=True),
    Column("node_count", WHOLE, "nodes of an orbit", "", name="node_count",
           get=lambda curve: curve.nodes.shape[1]),
    Column("points", get=len, record=True),
    Column("revolutions", WHOLE, "revolutions of each angle in a period, 0 for what is no angle",
           "", ("state",), derived=True, get=_revolutions, when="revolutions"),
    Column("revolutions", record=True, when="revolutions"),
    Column("base", REAL, "values of the parameters in the model that the locus was followed with",
           None, ("parameter",), when="locus",
           get=lambda locus: [locus.model.values[name] for name in locus.vary]),
    Column("values", record=True, when="locus"),
    Column("criticality", record=True, when="locus",
           get=lambda locus: None if locus.type == "LP" else locus.criticality),
    Column("coefficient", record=True, when="locus"),
    Column("measured", record=True, when="measured"),
    Column("durations", get=lambda locus: locus._cycle_durations(), record=True, when="locus"),
    EIGENVALUES,
    Column("special", record=True),
    *(
        column
        for which, verb in (("started", "begins"), ("stopped", "ends"))
        for column in (
            Column(f"{which}.kind", TEXT, f"why the {{thing}} {verb} there, in one word",
                   name=f"{which}_kind", record=True),
            Column(f"{which}.reason", TEXT, f"why the {{thing}} {verb} there",
                   name=f"{which}_reason", record=True),
            Column(f"{which}.value", REAL, f"{{vary.name}} where the branch {verb}", "{vary}",
                   name=f"{which}_value", record=True, when="branch"),
            Column(f"{which}.values", REAL, f"where the locus {verb}", None, ("parameter",),
                   name=f"{which}_value", record=True, when="locus"),
        )
    ),
)  # fmt: skip
"""What is said of a branch or locus."""

POINT = (
    Column("parameter", REAL, "{vary}", "{vary}", label=True, head="{vary}", when="branch"),
    Column("values", REAL, PLANE, None, ("parameter",), name="value", head="",
           when="locus"),
    Column("states", REAL, "state at phase zero", None, ("state",), derived=True, head=""),
    Column("nodes", REAL, NODES + " node_count of the {thing}", None, ("node", "state"),
           head=None),
    MULTIPLIERS,
    UNCERTAIN_MULTIPLIERS,
    UNSTABLE,
    *(
        Column(f"extrema.{which}", REAL, f"{which} over the continuous orbit", None, ("output",),
               name=which, head=which[:3], when="branch")
        for which in ("minimum", "maximum")
    ),
    Column("coefficient", REAL, "of the normal form of the bifurcation, NaN: not defined",
           when="locus"),
    Column("measured", REAL, "value of the quantity of a locus of extrema; NaN: another locus",
           get=partial(_or_unknown, "measured"), when="measured"),
    Column("criticality", TEXT, "empty: no meaning, or not known", derived=True, when="locus",
           get=lambda locus: [word or "" for word in locus.criticality]),
    Column("eigenvalues", COMPLEX, "of equilibria; NaN: a cycle", "1/s", ("multiplier",),
           get=_eigenvalues, derived=True, head=None, when="cycle"),
    replace(STUCK, get=partial(_or_unknown, "stuck_fraction")),
    Column("durations", REAL, "of one revolution; of an equilibrium, what multipliers are over",
           "s", get=_durations, name="duration", head=None, when="cycle"),
    RESIDUAL,
    Column("arclength", REAL, "in scaled variables", ""),
)  # fmt: skip
"""What is said of the points of a curve."""

SPECIAL = (
    Column("type", TEXT, "type of special point", record=True, head="type", when="branch"),
    Column("type", TEXT, "type of special point", record=True, head="special", when="locus"),
    Column("name", TEXT, "what the type means here", record=True, head=None),
    Column("kind", TEXT, "periodic or equilibrium", head=None, when="locus"),
    Column("value", REAL, "{vary}", "{vary}", label=True, record=True, head="{vary}",
           when="branch"),
    Column("values", REAL, PLANE, None, ("parameter",), name="special_value", record=True,
           head="", when="locus"),
    Column("uncertainty", REAL, "computed uncertainty of special_value", "{vary}", record=True,
           head=None, when="branch"),
    Column("uncertainty", REAL, "computed uncertainty of special_value", None, ("parameter",),
           record=True, head=None, when="locus"),
    Column("criticality", TEXT, "empty: no meaning, or not known", optional=True, when="locus"),
    Column("duration", record=True),
    Column("period", WHOLE, "in forcing periods", "", head=None),
    Column("model_duration", REAL, "of one revolution; of an equilibrium, what multipliers are "
           "over", "s", name="special_duration", head=None, when="cycle",
           get=lambda point: point.model.values[DURATION.name]),
    Column("node_count", WHOLE, "nodes of the orbit", "", get=lambda point: len(point.nodes),
           head=None),
    Column("nodes", REAL, NODES + " special_node_count", None, ("node", "state"), head=None),
    Column("state", REAL, "state at phase zero", None, ("state",), derived=True, record=True,
           head=""),
    MULTIPLIERS,
    UNCERTAIN_MULTIPLIERS,
    replace(UNSTABLE, get=lambda point: outside(point.multipliers).sum()),
    Column("criticality", TEXT, "empty: none", optional=True, record=True, when="branch"),
    Column("undecided", record=True, when="branch"),
    Column("coefficient", REAL, "of the normal form", optional=True, record=True, head=None,
           when="branch"),
    Column("leads_to", WHOLE, "branch started, 0: none", optional=True, record=True, head=None,
           when="branch"),
    Column("images", WHOLE, "branches that are not followed, as images of others", "", record=True,
           head=None, when="images"),
    Column("rare", WHOLE, "branches found from few of the directions tried", "",
           record=True, head=None, when="rare"),
    Column("angle", REAL, "of the critical multiplier where others stay on the unit circle", "rad",
           record=True, head=None, when="angle"),
    *(
        Column(f"extrema.{which}", REAL, f"{which} over the continuous orbit", None, ("output",),
               get=partial(lambda which, point: getattr(point.orbit.extrema, which)[0], which),
               name=f"special_{which}", head=which[:3], when="branch")
        for which in ("minimum", "maximum")
    ),
    EIGENVALUES,
    Column("coefficients", record=True, when="locus"),
    Column("named", TEXT, "coefficients by name", get=_named_coefficients, derived=True,
           name="special_coefficients", head="coefficients", when="locus"),
    Column("coefficient", record=True, when="locus",
           get=lambda point: next(iter(point.coefficients.values()), None)),
    Column("leads_to", WHOLE, "loci started here, 0: no more", None, ("start",), record=True,
           head=None, when="locus"),
    Column("measured", REAL, "value of the quantity of a locus of extrema; NaN: another locus",
           record=True, when="measured"),
    STUCK,
    Column("gradients", record=True, when="gradients"),
    Column("gradients", REAL, "derivative of {vary.name} at the point with respect to each "
           "parameter; NaN: none", None, ("by_parameter",), get=_gradients, head="d{vary}/d",
           when="gradients"),
    RESIDUAL,
    Column("arclength", REAL, "position on the {thing}", ""),
)  # fmt: skip
"""What is said of a special point."""

OPTIONAL = {
    "measured": {"measured"},
    "sticks": {"stuck_fraction", "special_stuck_fraction"},
    "gradients": {"special_gradients", "by_parameter"},
    "images": {"special_images"},
    "rare": {"special_rare"},
    "angle": {"special_angle"},
}
"""Variables that only some files have."""


class CurveList(ResultPart):
    """Branches or loci as an attribute of a diagram."""

    def made(self, result: Any, fields: dict[str, Any], outputs: tuple[str, ...]) -> Any:
        """Return a curve from its fields."""
        raise NotImplementedError

    def made_point(self, result: Any, fields: dict[str, Any], outputs: tuple[str, ...]) -> Any:
        """Return a special point from its fields."""
        raise NotImplementedError

    @staticmethod
    def model_of(result: Any, fields: dict[str, Any], values: Iterable[float]) -> Model:
        """Return the model of a special point; its duration is no field of it."""
        changes = dict(zip(names_of(result.vary), values, strict=True))
        if not result.model.forced:
            changes[DURATION.name] = fields.pop("model_duration")
        model: Model = result.model.replace(**changes)
        return model

    def variables(self, result: Any, key: str) -> dict[str, Variable]:
        """Return the arrays of curves, their points and special points."""
        curves = getattr(result, key)
        special = [point for curve in curves for point in curve.special]
        sizes = [each.nodes.shape[1] for each in curves] + [len(each.nodes) for each in special]
        axes = axes_of(result, max(sizes, default=0))
        return self._table(result, _parts(curves)).arrays(curves, axes)

    def record(self, result: Any, key: str) -> list[dict[str, Any]]:
        """Return a record of each curve."""
        curves, found = getattr(result, key), []
        table = self._table(result, _parts(curves))
        for curve in curves:
            points = [table.owned["special"].record_of(point) for point in curve.special]
            for point in points:
                # An equilibrium has none, but at a Hopf point that of the cycles from there.
                if (
                    result.thing == "branch"
                    and curve.kind == "equilibrium"
                    and point["type"] != "HB"
                ):
                    point["duration"] = None
            found.append(table.record_of(curve) | {"special": points})
        return found

    def read(self, saved: SavedTable, result: Any, key: str) -> tuple[Any, ...]:
        """Return the curves."""
        parts = {part for part, names in OPTIONAL.items() if names & set(saved.columns)}
        outputs = tuple(saved.columns["output"].tolist()) if result.thing == "branch" else ()
        found = []
        for fields in self._table(result, parts).all_fields(saved, axes_of(result)):
            fields["nodes"] = fields["nodes"][:, : fields.pop("node_count")]
            fields |= {which: End(*fields[which].values()) for which in ("started", "stopped")}
            if np.isnan(fields.get("stuck_fraction", np.nan)).all():
                fields["stuck_fraction"] = None
            if not fields.get("quantity"):
                fields.pop("measured", None)
            points = []
            for own in fields["special"]:
                own["nodes"] = own["nodes"][: own.pop("node_count")]
                points.append(self.made_point(result, own, outputs))
            found.append(self.made(result, fields | {"special": tuple(points)}, outputs))
        return tuple(found)

    def _table(self, result: Any, parts: set[str]) -> Items:
        """Return the table of curves with some of the optional parts."""
        parts = parts | {result.thing} | ({"cycle"} if not result.model.forced else set())
        if result.thing == "branch" and result.model.angle_periods.any():
            parts |= {"revolutions"}

        def chosen(columns: tuple[Column, ...]) -> tuple[Column, ...]:
            return tuple(item for item in columns if parts.issuperset(item.when.split()))

        point = "{thing}", "{thing} the point lies on"
        special = Items(
            "special", chosen(SPECIAL), "special_", owner=("{thing}", "{thing} it lies on")
        )
        rows = Items("point", chosen(POINT), owner=point, joined=True)
        table = Items("{thing}", chosen(CURVE), "{thing}_", rows=rows, owned={"special": special})
        return table.bound(result)


def _parts(curves: Sequence[Any]) -> set[str]:
    """Return which optional parts curves have."""
    points = [point for curve in curves for point in curve.special]
    known = {
        "measured": any(getattr(curve, "quantity", "") for curve in curves),
        "sticks": any(curve.stuck_fraction is not None for curve in curves),
        "gradients": any(getattr(point, "gradients", None) is not None for point in points),
        "images": any(getattr(point, "images", 0) for point in points),
        "rare": any(getattr(point, "rare", 0) for point in points),
        "angle": any(not np.isnan(getattr(point, "angle", np.nan)) for point in points),
    }
    return {part for part, there in known.items() if there}


class TableLine(NamedTuple):
    """A line of the table of a diagram: an end or a special point of a curve."""

    curve: Any
    row: int  # of the last point of the curve that is not beyond it
    type: str
    values: tuple[float, ...]
    note: str
    point: Any = None  # the special point


class CurveDiagram(Result):
    """Curves with their special points, over one parameter or two."""

    gap = "\n\n"
    thing: ClassVar[str]
    """Name of a curve."""
    noted: ClassVar[tuple[str, ...]]
    """Kinds of ends that the table notes; others are the usual ones."""

    @property
    def _curves(self) -> tuple[Any, ...]:
        """The curves of orbits."""
        raise NotImplementedError

    @property
    def _spans(self) -> dict[str, tuple[float, float]]:
        """Ends of the intervals of the parameters by name."""
        raise NotImplementedError

    @property
    def _noise(self) -> list[float]:
        """Distances from zero below which the parameters at an end count as zero."""
        return [ROUNDING * max(map(abs, span)) for span in self._spans.values()]

    @property
    def failed(self) -> bool:
        """Whether the continuation of a curve failed."""
        return any(curve.failed for curve in self._curves)

    def _found(self, what: str) -> str:
        """Return one line: the parameters, what was followed, and the special points."""
        spans = (f"{name} = {low:g} to {high:g}" for name, (low, high) in self._spans.items())
        types = [point.type for curve in self._curves for point in curve.special]
        found = f"{len(self._curves)} {what}, {listed(types, 'no special points')}"
        return f"{type(self).__name__} of {self.model.name}: {', '.join(spans)}, {found}"

    def _span_text(self) -> str:
        """Return the intervals of the parameters, and the parameters that were set."""
        spans = (
            with_unit(f"{name} from {low:g} to {high:g}", self.model.parameter(name).unit)
            for name, (low, high) in self._spans.items()
        )
        return f"{' and '.join(spans)}{without_defaults(self.model, self._spans)}"

    def _at(self, values: Iterable[float]) -> str:
        return ", ".join(
            with_unit(f"{name} = {value:.8g}", self.model.parameter(name).unit)
            for name, value in zip(self._spans, values, strict=True)
        )

    def _marks(self) -> list[TableLine]:
        """Return the first point, the special points and the last point of each curve."""
        noise, marks = self._noise, list[TableLine]()
        for curve in self._curves:
            ends = [
                TableLine(
                    curve,
                    row,
                    "MX" if end.kind == "failed" else "EP",
                    tuple(map(certain, curve._values[row], noise)),
                    end.kind if end.kind in self.noted else "",
                )
                for row, end in zip((0, len(curve) - 1), curve.ends, strict=True)
                if len(curve)
            ]
            marks += ends[:1]
            for point in curve.special if ends else ():
                row = int(np.searchsorted(curve.arclength, point.arclength, side="right")) - 1
                values = point.certain_values
                marks.append(TableLine(curve, row, point.type, values, point.outcome, point))
            marks += ends[1:]
        return marks

    def _rows_along(
        self, curves: Sequence[Any], repeated: Sequence[str], first: Sequence[str], below: str = ""
    ) -> Frame:
        """Return points and special points of each curve in their order, one row each.

        Each says `repeated` of its curve, and columns `first` come first. Below may stand points of
        curves of another kind.
        """
        variables, thing = self._variables(), self.thing
        known = {curve.id: (place, curve) for place, curve in enumerate(curves)}
        points = joined([frame_of(variables, ["point"]), frame_of(variables, ["special"])])
        owners, along = points.columns[thing], points.columns["arclength"]
        rows = sorted(range(len(points)), key=lambda row: (known[owners[row]][0], along[row]))
        result = points.take(rows)
        if below:
            others = frame_of(variables, [f"{below}_point"])
            named = {thing if name == below else name: own for name, own in others.columns.items()}
            result = joined([result, Frame(named, others.units)])
        owners = result.columns[thing]
        said = {name: [getattr(known[each][1], name) for each in owners] for name in repeated}
        columns = {**result.columns, **said}
        return Frame({name: columns[name] for name in (*first, *columns)}, result.units)

    def _uncertain(self) -> list[str]:
        """Return which special points are less certain than they should be."""
        points = (
            (
                f"{point.type} of {self.thing} {curve.id}",
                point._values,
                np.atleast_1d(point.uncertainty).tolist(),
            )
            for curve in self._curves
            for point in curve.special
        )
        parameters = [self.model.parameter(name) for name in self._spans]
        return uncertainty_notes(parameters, tuple(self._spans.values()), points)


def without_defaults(model: Model, varied: Collection[str]) -> str:
    """Return the parameters that were set, as the end of a title: nothing if none was.

    The duration of a cycle is found, not set.
    """
    values = ", ".join(
        with_unit(f"{item.name} = {model.values[item.name]:.6g}", item.unit)
        for item in model.variable_parameters
        if item.name not in varied and model.values[item.name] != item.default
    )
    return f"; {values}" if values else ""


def uncertainty_notes(
    parameters: Sequence[Parameter],
    spans: Sequence[tuple[float, float]],
    points: Iterable[tuple[str, Sequence[float], Sequence[float]]],
) -> list[str]:
    """Say which special points are less certain than they should be, and by how much.

    A point is its name, its values and their uncertainty.
    """
    notes, interrupted = list[str](), list[str]()
    limits = [UNCERTAIN * abs(last - first) for first, last in spans]
    for name, values, uncertainty in points:
        if all(u <= limit for u, limit in zip(uncertainty, limits, strict=True)):
            continue
        pairs = zip(parameters, values, strict=True)
        place = f"{name} at {', '.join(parameter_text(item, value) for item, value in pairs)}"
        if any(map(math.isnan, uncertainty)):
            interrupted.append(place)
        elif all(map(math.isfinite, uncertainty)):
            amounts = [
                with_unit(f"{amount:.0e}", item.unit)
                for item, amount in zip(parameters, uncertainty, strict=True)
            ]
            notes.append(f"{place} is uncertain by {' and '.join(amounts)}.")
        else:
            notes.append(f"{place}: its uncertainty could not be computed.")
    if interrupted:
        notes.append(
            "Interrupted before the uncertainty was computed of "
            f"{len(interrupted)} special points: {listed(interrupted)}"
        )
    return notes
