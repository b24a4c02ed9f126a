"""Diagrams that hold curves: what those of branches and of loci share."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipfold.continuation.end import End
from slipfold.models.model import Model
from slipfold.models.parameter import Parameter
from slipfold.results.fields import COMPLEX, REAL, TEXT, WHOLE, Axes, Column, Owners, Table, axes_of
from slipfold.results.records import SavedTable
from slipfold.results.result import Result
from slipfold.results.tables import Frame, Variable, frame_of, joined
from slipfold.text.one_line import certain, listed, parameter_text
from slipfold.text.printed_table import with_unit

Columns = tuple[Column, ...]

UNCERTAIN = 1e-6
"""Fraction of the span above which the uncertainty of a point is reported: points are located to
1e-12, and no figure shows less."""

ROUNDING = 1e-14
"""Values below this fraction of the size of their column are rounding, and shown as zero."""

LASTING = "of one round; of an equilibrium, what multipliers are over"
NODES = "states at equal phases over the period, the first"
MULTIPLIERS = Column(
    "multipliers",
    COMPLEX,
    "Floquet multipliers",
    "",
    ("multiplier",),
    record=True,
    head="multiplier",
)
RESIDUAL = Column("residual", REAL, "how far the orbit fails to close, in scaled states", "")


@dataclass(frozen=True)
class Curves:
    """Tables of curves, of their points and of their special points."""

    curves: Table
    points: Table
    special: Table

    @classmethod
    def of(
        cls,
        thing: str,
        forced: bool,
        *,
        kinds: Columns,
        own: Columns,
        ends: tuple[Any, ...],
        points: Columns,
        along: Columns,
        special: Columns,
        at: Columns,
        lasting: str,
        head: str,
        amended: Callable[[Any, Any], dict[str, Any]] = lambda curve, point: {},
    ) -> Curves:
        """Return what is said of branches or loci, from what only the one or the other has.

        A curve has `kinds`, then what all have, then its `own` and its `ends`; points begin with
        `points` and special points with `special`, and have their orbits, then `along` and `at`.
        What a record says of a special point may be `amended`. Tables call its type `head`.
        """

        def records(curve: Any) -> list[dict[str, Any]]:
            return [on_curve.record(point) | amended(curve, point) for point in curve.special]

        durations = Column(
            "durations", REAL, LASTING, "s", get=_durations, name="duration", head=None
        )
        duration = Column(
            "model_duration", REAL, lasting, "s", name="special_duration",
            get=lambda point: point.model.values["duration"], head=None,
        )  # fmt: skip
        curve = (
            Column("id", WHOLE, f"number of the {thing}", name=thing, label=True, record=True),
            *kinds,
            Column("period", WHOLE, "in forcing periods", "", record=True),
            Column("parent", WHOLE, f"{thing} left, 0: none", optional=True, record=True),
            Column("node_count", WHOLE, "nodes of an orbit", "", name="node_count",
                   get=lambda curve: curve.nodes.shape[1]),
            Column("points", get=len, record=True),
            *own,
            Column("special", get=records, record=True),
            *_ends(thing, *ends),
        )  # fmt: skip
        point = (
            *points,
            Column("states", REAL, "state at phase zero", None, ("state",), derived=True,
                   head=""),
            Column("nodes", REAL, f"{NODES} node_count of the {thing}", None, ("node", "state"),
                   head=None),
            MULTIPLIERS,
            *along,
            *(() if forced else (durations,)),
            RESIDUAL,
            Column("arclength", REAL, "in scaled variables", ""),
        )  # fmt: skip
        mark = (
            Column("type", TEXT, "type of special point", record=True, head=head),
            *special,
            Column("period", WHOLE, "in forcing periods", "", head=None),
            *(() if forced else (duration,)),
            Column("node_count", WHOLE, "nodes of the orbit", "",
                   get=lambda point: len(point.nodes), head=None),
            Column("nodes", REAL, f"{NODES} special_node_count", None, ("node", "state"),
                   head=None),
            Column("state", REAL, "state at phase zero", None, ("state",), derived=True,
                   record=True, head=""),
            MULTIPLIERS,
            *at,
            RESIDUAL,
            Column("arclength", REAL, f"position on the {thing}", ""),
        )  # fmt: skip
        on_curve = Table(("special",), mark, "special_", (thing, f"{thing} it lies on"))
        owner = (thing, f"{thing} the point lies on")
        return cls(
            Table((thing,), curve, f"{thing}_"),
            Table(("point",), point, owner=owner, joined=True),
            on_curve,
        )

    def variables(
        self, curves: Sequence[Any], model: Model, vary: Sequence[str]
    ) -> dict[str, Variable]:
        """Return the arrays of curves, their points and special points."""
        special = [point for curve in curves for point in curve.special]
        sizes = [each.nodes.shape[1] for each in curves] + [len(each.nodes) for each in special]
        return self._owners.variables(curves, axes_of(model, vary, max(sizes, default=0)))

    @property
    def _owners(self) -> Owners:
        return Owners(self.curves, self.points, {"special": self.special})

    def frame(
        self,
        variables: Mapping[str, Variable],
        curves: Sequence[Any],
        repeated: Sequence[str],
        first: Sequence[str],
        below: str = "",
    ) -> Frame:
        """Return points and special points of each curve in their order, one row each.

        Each says `repeated` of its curve, and columns `first` come first. Below may stand points of
        curves of another kind.
        """
        thing = self.curves.dimensions[0]
        known = {curve.id: (place, curve) for place, curve in enumerate(curves)}
        points = joined([frame_of(variables, ["point"]), frame_of(variables, ["special"])])
        owners, along = points.columns[thing], points.columns["arclength"]
        rows = sorted(range(len(points)), key=lambda row: (known[owners[row]][0], along[row]))
        found = points.take(rows)
        if below:
            others = frame_of(variables, [f"{below}_point"])
            named = {thing if name == below else name: own for name, own in others.columns.items()}
            found = joined([found, Frame(named, others.units)])
        owners = found.columns[thing]
        said = {name: [getattr(known[each][1], name) for each in owners] for name in repeated}
        columns = {**found.columns, **said}
        return Frame({name: columns[name] for name in (*first, *columns)}, found.units)

    def read(self, saved: SavedTable, axes: Axes) -> Iterator[dict[str, Any]]:
        """Yield the fields of each curve, those of its special points by their rows."""
        for fields in self._owners.read(saved, axes):
            fields["nodes"] = fields["nodes"][:, : fields.pop("node_count")]
            fields |= {which: End(*fields[which].values()) for which in ("begun", "stopped")}
            for own in fields["special"].values():
                own["nodes"] = own["nodes"][: own.pop("node_count")]
            yield fields


def _ends(
    thing: str, value: str, where: str, unit: str | None, dimensions: tuple[str, ...] = ()
) -> Columns:
    """Return the columns that say where branches or loci begin and end, and why."""
    return tuple(
        column
        for which, verb in (("begun", "begins"), ("stopped", "ends"))
        for column in (
            Column(f"{which}.kind", TEXT, f"why the {thing} {verb} there, in one word",
                   name=f"{which}_kind", record=True),
            Column(f"{which}.reason", TEXT, f"why the {thing} {verb} there",
                   name=f"{which}_reason", record=True),
            Column(f"{which}.{value}", REAL, f"{where} the {thing} {verb}", unit,
                   dimensions, name=f"{which}_value", record=True),
        )
    )  # fmt: skip


def _durations(curve: Any) -> NDArray[np.float64]:
    own: NDArray[np.float64] | None = curve.durations
    return np.full(len(curve), curve.model.values["duration"]) if own is None else own


def sticking(sticks: bool, get: Callable[[Any], Any], *, point: bool) -> tuple[Column, ...]:
    """Return the column for the fraction of the period in which contacts stick, if any do."""
    if not sticks:
        return ()
    meaning = "fraction of the period in which a contact sticks; NaN: none was watched for stick"

    def known(item: Any) -> Any:
        found = get(item)
        return np.full(len(item), np.nan) if found is None else found

    return (
        Column("stuck_fraction", REAL, meaning, "", get=known, record=point, head="stuck fraction"),
    )


class Mark(NamedTuple):
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

    def _marks(self) -> list[Mark]:
        """Return the first point, the special points and the last point of each curve."""
        noise, marks = self._noise, list[Mark]()
        for curve in self._curves:
            ends = [
                Mark(
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
                marks.append(Mark(curve, row, point.type, values, point.outcome, point))
            marks += ends[1:]
        return marks

    def _uncertain(self, thing: str) -> list[str]:
        """Return which special points are less certain than they should be."""
        points = (
            (
                f"{point.type} of {thing} {curve.id}",
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
