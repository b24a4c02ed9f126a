"""A response diagram: all branches of one computation, with what was asked for and by whom."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.branch import Branch, End
from slipfold.branches.event import Event
from slipfold.branches.settings import Settings
from slipfold.branches.special_point import SpecialPoint
from slipfold.checks.checked import Checked
from slipfold.drawing import draw
from slipfold.models.model import Model
from slipfold.orbits.extrema import Extrema
from slipfold.results.column import COMPLEX, REAL, TEXT, WHOLE, Column
from slipfold.results.diagram_summary import DiagramSummary
from slipfold.results.labelled_table import Variable
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.results.saved_table import SavedTable
from slipfold.results.sheet import Sheet
from slipfold.results.table import Table, axes_of, ends, meaning_of, names
from slipfold.text.one_line import headed, listed

__all__ = ["Diagram", "Labelled"]


class Labelled(NamedTuple):
    """A special point with the branch that it lies on."""

    branch: Branch
    point: SpecialPoint

    def __repr__(self) -> str:
        return f"<{self.point._line()}; on branch {self.branch.id}>"

    def _repr_html_(self) -> str:
        return self.point._repr_html_()


@dataclass(frozen=True, eq=False)
class Diagram(Result):
    """The periodic responses of a model over one parameter; frozen.

    Made by `slipfold.response` and `slipfold.load`.

    Parameters
    ----------
    model
        The model, with the value of `vary` at the start of the span.
    vary
        Name of the parameter followed.
    span
        First and last value asked for.
    branches
        The branches; the first is the response of period 1.
    settings
        Options of continuation.
    events
        Values asked to be located.
    provenance
        Versions and time.
    checked
        Special points and ends that were computed again by other means; None if nothing was.

    Notes
    -----
    In the dataset of `to_xarray`, along ``point``: the points of all branches, one after the other;
    ``branch_of_point`` says whose. Along ``special``: the special points. In the spreadsheet of
    `to_csv`, one row a point, special points among them in their order. In `to_json`,
    schema slipfold.response/1, special points and ends; limits of the model are not among the
    special points, a branch that meets one says so where it stopped.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.98), f=12.5)
    >>> [(branch.period, point.type) for branch, point in diagram.special]
    [(1, 'PD'), (2, 'NS'), (2, 'NS')]
    """

    schema = "slipfold.response/1"

    model: Model
    vary: str
    span: tuple[float, float]
    branches: tuple[Branch, ...]
    settings: Settings
    events: tuple[Event, ...]
    provenance: Provenance
    checked: Checked | None = None

    @property
    def special(self) -> tuple[Labelled, ...]:
        """All special points, each with its branch, branch after branch."""
        return tuple(
            Labelled(branch, point) for branch in self.branches for point in branch.special
        )

    @property
    def interrupted(self) -> bool:
        """Whether the computation was interrupted and later branches are missing."""
        return any(branch.interrupted for branch in self.branches)

    @property
    def failed(self) -> bool:
        """Whether a branch was given up before it came to an end of its own."""
        return any(branch.failed for branch in self.branches)

    def summary(self, outputs: Sequence[str] | None = None) -> str:
        """Return a table of ends and special points, as AUTO prints it, and why branches stop.

        Parameters
        ----------
        outputs
            States or outputs of which to show maximum and minimum over the continuous orbit; the
            first two states if None.

        Raises
        ------
        InputError
            For an unknown output.
        """
        return self._summary().text(outputs)

    def plot(self, output: str | None = None, **options: Any) -> Any:
        """Draw the diagram.

        Parameters
        ----------
        output
            A state or output of the model; the first state if None.
        **options
            Options of the drawing, e.g. ``measure="peak_to_peak"`` and ``ax=`` the axes to draw in.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        InputError
            For an unknown output.
        """
        return draw(self, output=output, **options)

    def __repr__(self) -> str:
        """One line: what was followed, how far, and what was found."""
        found = listed((point.type for _, point in self.special), "no special points")
        return (
            f"<Diagram of {self.model.name}: {self.vary} = {self.span[0]:g} to {self.span[1]:g}, "
            f"{len(self.branches)} branches, {found}>"
        )

    def _repr_html_(self) -> str:
        return self._summary().html()

    def _summary(self) -> DiagramSummary:
        return DiagramSummary(self.model, self.vary, self.span, self.branches, self._remarks())

    def _title(self) -> str:
        return f"periodic responses of {self.model.name} over {self.vary}"

    def _given(self) -> dict[str, Any]:
        return {
            "vary": self.vary,
            "span": list(self.span),
            "settings": asdict(self.settings),
            "events": [asdict(event) for event in self.events],
        }

    def _attributes(self) -> dict[str, Any]:
        return {"vary": self.vary, "span": np.array(self.span, dtype=float)}

    def _variables(self) -> dict[str, Variable]:
        model, branches = self.model, self.branches
        tables = _Tables.of(model, self.vary)
        points = [point for _, point in self.special]
        sizes = [branch.nodes.shape[1] for branch in branches] + [len(p.nodes) for p in points]
        axes = axes_of(model, nodes=max(sizes, default=0))
        variables = names("state", model.states)
        variables |= names("output", [*model.states, *model.outputs()])
        variables |= tables.branches.variables(branches, axes)
        variables |= tables.points.variables(branches, axes, [branch.id for branch in branches])
        owners = [branch.id for branch, _ in self.special]
        return variables | tables.special.variables(points, axes, owners)

    def _record(self) -> dict[str, Any]:
        table = _Tables.of(self.model, self.vary).branches
        return {"vary": self.vary, "branches": [table.record(each) for each in self.branches]}

    def _csv(self) -> str:
        tables = _Tables.of(self.model, self.vary)
        heads = {
            "id": "branch",
            "period": "period",
            "type": "type",
            "criticality": "criticality",
            "value": headed(self.model.parameter(self.vary)),
            "state": "",
            "maximum": "max",
            "minimum": "min",
            "multipliers": "multiplier",
            "unstable": "unstable multipliers",
            "residual": "residual",
            "arclength": "arclength",
        }
        sheet = Sheet(heads, (tables.points, tables.special), axes_of(self.model))
        rows = []
        for branch in self.branches:
            known = {"id": branch.id, "period": branch.period}
            points = sheet.rows(tables.points, [branch], known)
            special = sheet.rows(tables.special, branch.special, known)
            rows += sorted([*points, *special], key=lambda row: row[-1])
        return sheet.text(rows)

    @classmethod
    def _read(cls, saved: SavedTable) -> Diagram:
        model, given, vary = saved.model, saved.given, str(saved.given["vary"])
        tables = _Tables.of(model, vary)
        points, special = tables.points.rows(saved), tables.special.rows(saved)
        axes = axes_of(model)
        branches = []
        for row, identity in enumerate(saved.columns["branch"].tolist()):
            fields = tables.branches.read(saved, axes, row)
            fields |= tables.points.read(saved, axes, points[identity])
            found = [_special(saved, tables.special, vary, each) for each in special[identity]]
            branches.append(_branch(saved, vary, fields, tuple(found)))
        first, last = given["span"]
        return cls(
            model,
            vary,
            (float(first), float(last)),
            tuple(branches),
            saved.settings,
            tuple(Event(**event) for event in given["events"]),
            saved.provenance,
            saved.checked,
        )


class _Tables(NamedTuple):
    """What is said of branches, of their points and of their special points."""

    branches: Table
    points: Table
    special: Table

    @classmethod
    def of(cls, model: Model, vary: str) -> _Tables:
        special = _special_table(model, vary)
        return cls(_branch_table(model, vary, special), _point_table(model, vary), special)


def _branch_table(model: Model, vary: str, special: Table) -> Table:
    def records(branch: Branch) -> list[dict[str, Any]]:
        found = [(point, special.record(point)) for point in branch.special]
        # An equilibrium has no duration, but at a Hopf point that of the cycle born there.
        still = branch.kind == "equilibrium"
        none = {"duration": None}
        return [each | (none if still and p.type != "HB" else {}) for p, each in found]

    columns = (
        Column("id", WHOLE, "number of the branch", name="branch", label=True, record=True),
        Column("kind", TEXT, "kind of the branch", record=True),
        Column("period", WHOLE, "in forcing periods", "", record=True),
        Column("parent", WHOLE, "branch left, 0: none", optional=True, record=True),
        Column("node_count", WHOLE, "nodes of an orbit", "",
               get=lambda branch: branch.nodes.shape[1], name="node_count"),
        Column("points", WHOLE, get=len, record=True),
        Column("special", get=records, record=True),
        *ends("branch", "value", f"{vary} where", model.parameter(vary).unit),
    )  # fmt: skip
    return Table(("branch",), columns, "branch_")


def _point_table(model: Model, vary: str) -> Table:
    parameter = model.parameter(vary)
    duration = Column(
        "durations", REAL, "of one round; of an equilibrium, what multipliers are over", "s",
        get=_durations, name="duration",
    )  # fmt: skip
    columns = (
        Column("parameter", REAL, meaning_of(parameter), parameter.unit, label=True, slot="value"),
        Column("states", REAL, "state at phase zero", None, ("state",), derived=True, slot="state"),
        Column("nodes", REAL,
               "states at equal phases over the period, the first node_count of the branch",
               None, ("node", "state")),
        Column("multipliers", COMPLEX, "Floquet multipliers", "", ("multiplier",)),
        Column("multiplier_uncertainty", REAL, "computed uncertainty of the multipliers", "",
               ("multiplier",)),
        Column("unstable", WHOLE, "number of multipliers outside the unit circle", "",
               derived=True),
        Column("residual", REAL, "how far the orbit fails to close, in scaled states", ""),
        Column("arclength", REAL, "in scaled variables", ""),
        *(() if model.forced else (duration,)),
        *(
            Column(f"extrema.{which}", REAL, f"{which} over the continuous orbit", None,
                   ("output",), name=which, slot=which)
            for which in ("minimum", "maximum")
        ),
    )  # fmt: skip
    return Table(("point",), columns, owner=("branch", "branch the point lies on"), joined=True)


def _special_table(model: Model, vary: str) -> Table:
    parameter = model.parameter(vary)
    own_duration = Column(
        "own_duration", REAL, "of one round", "s",
        get=lambda point: point.model.values["duration"], name="special_duration",
    )  # fmt: skip
    columns = (
        Column("type", TEXT, "type of special point", record=True),
        Column("name", TEXT, "what the type means here", record=True),
        Column("value", REAL, meaning_of(parameter), parameter.unit, label=True, record=True),
        Column("uncertainty", REAL, "computed uncertainty of special_value", parameter.unit,
               record=True),
        Column("period", WHOLE, "in forcing periods", "", slot=""),
        Column("node_count", WHOLE, "nodes of the orbit", "", get=lambda point: len(point.nodes)),
        Column("nodes", REAL,
               "states at equal phases over the period, the first special_node_count",
               None, ("node", "state")),
        Column("duration", record=True),
        Column("state", dimensions=("state",), record=True),
        Column("multipliers", COMPLEX, "Floquet multipliers", "", ("multiplier",), record=True),
        Column("multiplier_uncertainty", REAL, "computed uncertainty of the multipliers", "",
               ("multiplier",), record=True),
        Column("unstable", WHOLE, get=lambda point: (np.abs(point.multipliers) > 1).sum()),
        Column("residual", REAL, "how far the orbit fails to close, in scaled states", ""),
        Column("arclength", REAL, "position on the branch", ""),
        Column("criticality", TEXT, "empty: none", optional=True, record=True),
        Column("undecided", TEXT, record=True),
        Column("coefficient", REAL, "of the normal form", optional=True, record=True),
        Column("leads_to", WHOLE, "branch begun, 0: none", optional=True, record=True),
        *(() if model.forced else (own_duration,)),
        *(
            Column(which, REAL, f"{which} over the continuous orbit", None, ("output",),
                   get=partial(_reached, which),
                   derived=True)
            for which in ("minimum", "maximum")
        ),
    )  # fmt: skip
    return Table(("special",), columns, "special_", ("branch", "branch it lies on"))


def _reached(which: str, point: SpecialPoint) -> NDArray[np.float64]:
    extremes: NDArray[np.float64] = getattr(point.orbit.extrema, which)
    return extremes[0]


def _durations(branch: Branch) -> NDArray[np.float64]:
    """Durations of one round at every point of a branch of an autonomous model."""
    if branch.durations is not None:
        return branch.durations
    return np.full(len(branch), branch.model.values["duration"])


def _branch(
    saved: SavedTable, vary: str, fields: dict[str, Any], special: tuple[SpecialPoint, ...]
) -> Branch:
    extrema, uncertainty = fields.pop("extrema"), fields.pop("multiplier_uncertainty")
    fields["nodes"] = fields["nodes"][:, : fields.pop("node_count")]
    fields |= {which: End(*fields[which].values()) for which in ("begun", "stopped")}
    model, durations = saved.model, fields.pop("durations", None)
    if durations is not None and len(durations):
        model = model.replace(duration=float(durations[0]))
        fields["durations"] = durations
    branch = Branch(model=model, vary=vary, special=special, **fields)
    # What the branch would compute when asked is in the file already.
    names = tuple(saved.columns["output"].tolist())
    vars(branch)["extrema"] = Extrema(names, **extrema)
    vars(branch)["multiplier_uncertainty"] = uncertainty
    return branch


def _special(saved: SavedTable, table: Table, vary: str, row: int) -> SpecialPoint:
    fields = table.read(saved, axes_of(saved.model), row)
    changes = {vary: fields["value"]}
    if not saved.model.forced:
        changes["duration"] = fields.pop("own_duration")
    fields["nodes"] = fields["nodes"][: fields.pop("node_count")]
    return SpecialPoint(model=saved.model.replace(**changes), vary=vary, **fields)
