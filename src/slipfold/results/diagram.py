"""A response diagram: all branches of one computation, with what was asked for and by whom."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.branch import Branch
from slipfold.branches.event import Event
from slipfold.branches.settings import Settings
from slipfold.branches.special_point import LOCUS_TYPES, SpecialPoint, sensitive_to
from slipfold.checks.checked import Checked
from slipfold.drawing import draw
from slipfold.long_term.branch_search import BranchSearch
from slipfold.models.model import Model
from slipfold.orbits.extrema import Extrema
from slipfold.results.curves import Curves, sticking
from slipfold.results.diagram_summary import DiagramSummary
from slipfold.results.fields import REAL, TEXT, WHOLE, Column, axes_of, meaning_of
from slipfold.results.frame import Frame
from slipfold.results.labelled_table import Variable
from slipfold.results.motions.torus_table import Tori, torus_sentence
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.results.saved_table import SavedTable
from slipfold.text.one_line import listed
from slipfold.text.stability import outside
from slipfold.tori.torus_branch import TorusBranch


class Labelled(NamedTuple):
    """A special point with the branch that it lies on."""

    branch: Branch
    point: SpecialPoint

    def __repr__(self) -> str:
        return f"<{self.point._line()}; on branch {self.branch.id}>"

    def _repr_html_(self) -> str:
        return self.point._repr_html_()


@dataclass(frozen=True)
class Branches:
    """Branches as an attribute of a diagram."""

    def names(self, key: str) -> set[str]:
        """Return nothing: no array is named for a parameter."""
        return set()

    def curves(self, result: Any) -> Curves:
        """Return what is said of branches and of their points."""
        branches: tuple[Branch, ...] = result.branches
        points = [point for branch in branches for point in branch.special]
        return _curves(
            result.model,
            result.vary,
            sticks=any(branch.stuck_fraction is not None for branch in branches),
            differentiated=any(point.gradients is not None for point in points),
        )

    def variables(self, result: Any, key: str) -> dict[str, Variable]:
        """Return the arrays of branches."""
        return self.curves(result).variables(result.branches, result.model, [result.vary])

    def record(self, result: Any, key: str) -> list[dict[str, Any]]:
        """Return a record of each branch."""
        table = self.curves(result).curves
        return [table.record(each) for each in result.branches]

    def read(self, saved: SavedTable, result: Any, key: str) -> tuple[Branch, ...]:
        """Return the branches."""
        model, vary = saved.model, result.vary
        outputs = tuple(saved.columns["output"].tolist())
        curves = _curves(
            model,
            vary,
            sticks=bool({"stuck_fraction", "special_stuck_fraction"} & set(saved.columns)),
            differentiated=bool({"special_gradients", "by_parameter"} & set(saved.columns)),
        )
        branches = []
        for fields, found in curves.read(saved, axes_of(model)):
            special = tuple(_special(model, vary, outputs, own) for _, own in found)
            branches.append(_branch(model, vary, outputs, fields | {"special": special}))
        return tuple(branches)


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
    searched
        Where branches were looked for that nothing leads to; None if nowhere.
    tori
        Branches of quasi-periodic tori from its Neimark-Sacker points, if they were asked for.

    Notes
    -----
    In the dataset of `to_xarray`, along ``point``: the points of all branches, one after the other;
    ``branch_of_point`` says whose. Along ``special``: the special points. In the spreadsheet of
    `to_csv`, one row a point, special points among them in their order. In `to_json`,
    schema slipfold.response/1, special points and ends; limits of the model are not among the
    special points, a branch that meets one says so where it stopped. Tori, if there are any, are
    along ``torus``, ``torus_point``, ``fold`` and ``resonance``, are rows below those of branches,
    and branches of ``"kind": "torus"`` with their ``rotation`` and ``values``.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.98), f=12.5)
    >>> [(branch.period, point.type) for branch, point in diagram.special]
    [(1, 'PD'), (2, 'NS'), (2, 'NS')]
    """

    schema = "slipfold.response/1"
    title = "periodic responses of {0.model.name} over {0.vary}"

    model: Model
    vary: str
    span: tuple[float, float]
    branches: Annotated[tuple[Branch, ...], Branches()]
    settings: Settings
    events: tuple[Event, ...]
    provenance: Provenance
    checked: Checked | None = None
    searched: BranchSearch | None = None
    tori: Annotated[tuple[TorusBranch, ...], Tori()] = ()

    @property
    def special(self) -> tuple[Labelled, ...]:
        """All special points, each with its branch, branch after branch."""
        return tuple(
            Labelled(branch, point) for branch in self.branches for point in branch.special
        )

    @property
    def interrupted(self) -> bool:
        """Whether the computation was interrupted: branches, normal forms or checks are missing."""
        parts = (self.checked, self.searched, *self.tori)
        stopped = any(part is not None and part.interrupted for part in parts)
        return stopped or any(branch.interrupted for branch in self.branches)

    @property
    def failed(self) -> bool:
        """Whether a branch was given up before it came to an end of its own."""
        tori = any(each.stopped.early for each in self.tori)
        return tori or any(branch.failed for branch in self.branches)

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
            Options of the drawing, e.g. ``measure="peak_to_peak"``, ``under=`` a `slipfold.Sweep`
            whose motions are dots under the branches, and ``ax=`` the axes to draw in.
            ``kind="spectrum"`` draws the lines of the torus nearest to the value ``at=`` instead.

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
        found += f", {len(self.tori)} branches of tori" * bool(self.tori)
        return (
            f"<Diagram of {self.model.name}: {self.vary} = {self.span[0]:g} to {self.span[1]:g}, "
            f"{len(self.branches)} branches, {found}>"
        )

    def _repr_html_(self) -> str:
        return self._summary().html()

    def _remarks(self) -> list[str]:
        searched = self.searched
        if searched is None:
            return super()._remarks()
        number = len(searched.found)
        found = f"{number or 'no'} more branch{'' if number == 1 else 'es'}"
        if number:
            found += f" ({', '.join(map(str, searched.found))})"
        places = ", ".join(f"{value:.6g}" for value in searched.values)
        box = ", ".join(
            f"{state.name} {low:.4g} to {high:.4g}"
            for state, low, high in zip(self.model.states, searched.low, searched.high, strict=True)
        )
        where = f"{searched.starts} starts each at {self.vary} = {places}"
        return [f"Searched from {where}: {found}; in {box}", *super()._remarks()]

    def _summary(self) -> DiagramSummary:
        remarks = [*map(torus_sentence, self.tori), *self._remarks()]
        return DiagramSummary(self.model, self.vary, self.span, self.branches, remarks)

    def _record(self) -> dict[str, Any]:
        branches = [*Branches().record(self, "branches"), *Tori().record(self, "tori")]
        searched = {} if self.searched is None else {"searched": asdict(self.searched)}
        return {"vary": self.vary, "branches": branches, **searched}

    def _frame(self) -> Frame:
        return (
            Branches()
            .curves(self)
            .frame(
                self._variables(),
                [*self.branches, *self.tori],
                ("period",),
                ("branch", "period", "type", "criticality", self.vary),
                "torus" if self.tori else "",
            )
        )


def _curves(model: Model, vary: str, *, sticks: bool, differentiated: bool) -> Curves:
    parameter = model.parameter(vary)
    meaning, unit = meaning_of(parameter), parameter.unit
    uncertain = "computed uncertainty of the multipliers"
    reached = {which: f"{which} over the continuous orbit" for which in ("minimum", "maximum")}
    return Curves.of(
        "branch",
        model.forced,
        kinds=(Column("kind", TEXT, "kind of the branch", record=True),),
        own=_turning(model),
        ends=("value", f"{vary} where", unit),
        points=(Column("parameter", REAL, meaning, unit, label=True, head=vary),),
        along=(
            Column("multiplier_uncertainty", REAL, uncertain, "", ("multiplier",), head=None),
            Column("unstable", WHOLE, "number of multipliers outside the unit circle", "",
                   derived=True, head="unstable multipliers"),
            *(
                Column(f"extrema.{which}", REAL, about, None, ("output",), name=which,
                       head=which[:3])
                for which, about in reached.items()
            ),
            *sticking(sticks, lambda branch: branch.stuck_fraction, point=False),
        ),
        special=(
            Column("name", TEXT, "what the type means here", record=True, head=None),
            Column("value", REAL, meaning, unit, label=True, record=True, head=vary),
            Column("uncertainty", REAL, "computed uncertainty of special_value", unit, record=True,
                   head=None),
            Column("duration", record=True),
        ),
        at=(
            Column("multiplier_uncertainty", REAL, uncertain, "", ("multiplier",), record=True,
                   head=None),
            Column("unstable", WHOLE, "number of multipliers outside the unit circle", "",
                   get=lambda point: outside(point.multipliers).sum(), derived=True,
                   head="unstable multipliers"),
            Column("criticality", TEXT, "empty: none", optional=True, record=True),
            Column("undecided", record=True),
            Column("coefficient", REAL, "of the normal form", optional=True, record=True,
                   head=None),
            Column("leads_to", WHOLE, "branch begun, 0: none", optional=True, record=True,
                   head=None),
            *(
                Column(f"extrema.{which}", REAL, about, None, ("output",), head=which[:3],
                       get=partial(_reached, which), name=f"special_{which}")
                for which, about in reached.items()
            ),
            *sticking(sticks, lambda point: point.stuck_fraction, point=True),
            *(_gradients(model, vary) if differentiated else ()),
        ),
        lasting="of one round",
        head="type",
        amended=_without_duration,
    )  # fmt: skip


def _turning(model: Model) -> tuple[Column, ...]:
    """How often the angles of a branch turn round, where there is an angle."""
    if not model.whole_turns.any():
        return ()
    meaning = "whole turns of each angle in a period, 0 for what is no angle"
    return (
        Column("turns", WHOLE, meaning, "", ("state",), derived=True,
               get=lambda branch: [branch.turns.get(item.name, 0) for item in model.states]),
        Column("turns", record=True),
    )  # fmt: skip


def _gradients(model: Model, vary: str) -> tuple[Column, ...]:
    """How special points move with every parameter, if that was asked for."""
    names = [item.name for item in model.parameters]
    meaning = f"derivative of {vary} at the point with respect to each parameter; NaN: none"

    def array(point: SpecialPoint) -> list[float]:
        return [(point.gradients or {}).get(name, np.nan) for name in names]

    return (
        Column("gradients", record=True),
        Column("gradients", REAL, meaning, None, ("by_parameter",), get=array, head=f"d{vary}/d"),
    )


def _without_duration(branch: Branch, point: SpecialPoint) -> dict[str, Any]:
    """An equilibrium has no duration, but at a Hopf point that of the cycle born there."""
    return {"duration": None} if branch.kind == "equilibrium" and point.type != "HB" else {}


def _reached(which: str, point: SpecialPoint) -> NDArray[np.float64]:
    extremes: NDArray[np.float64] = getattr(point.orbit.extrema, which)
    return extremes[0]


def _branch(model: Model, vary: str, names: tuple[str, ...], fields: dict[str, Any]) -> Branch:
    extrema, uncertainty = fields.pop("extrema"), fields.pop("multiplier_uncertainty")
    durations = fields.pop("durations", None)
    if np.isnan(fields.get("stuck_fraction", np.nan)).all():
        fields["stuck_fraction"] = None
    if durations is not None and len(durations):
        model = model.replace(duration=float(durations[0]))
        fields["durations"] = durations
    branch = Branch(model=model, vary=vary, **fields)
    # What the branch would compute when asked is in the file already.
    vars(branch)["extrema"] = Extrema(names, **extrema)
    vars(branch)["multiplier_uncertainty"] = uncertainty
    return branch


def _special(
    model: Model, vary: str, names: tuple[str, ...], fields: dict[str, Any]
) -> SpecialPoint:
    reached = {which: values[None] for which, values in fields.pop("extrema").items()}
    if "gradients" in fields:
        found = {
            name: float(fields["gradients"][model.parameter_index(name)])
            for name in sensitive_to(model, vary)
        }
        fields["gradients"] = found if fields["type"] in LOCUS_TYPES else None
    changes = {vary: fields["value"]}
    if not model.forced:
        changes["duration"] = fields.pop("model_duration")
    point = SpecialPoint(model=model.replace(**changes), vary=vary, **fields)
    vars(point.orbit)["extrema"] = Extrema(names, **reached)
    return point
