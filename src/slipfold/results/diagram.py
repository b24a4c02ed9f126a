"""A response diagram: all branches of one computation."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple

import numpy as np

from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.gaps import BranchSearch, gaps_between
from slipfold.bifurcations.branches.settings import Event, Settings
from slipfold.bifurcations.branches.special_point import SpecialPoint, sensitive_to
from slipfold.bifurcations.tori.torus_branch import TorusBranch
from slipfold.errors import unknown
from slipfold.models.model import Model, evaluation_of
from slipfold.models.nonlinear_mode import NonlinearMode
from slipfold.orbits.bifurcation_types import BIFURCATION_TYPES, FOLLOWED_TYPES
from slipfold.orbits.eigenvalues import MODE_UNITS, modes_of
from slipfold.orbits.extrema import Extrema, find_extrema
from slipfold.orbits.periodic_orbit import PeriodicOrbit, StickSlipOrbit
from slipfold.orbits.test_functions import are_neutral
from slipfold.results.checks.checked import Checked
from slipfold.results.curves import ROUNDING, CurveDiagram, CurveList, TableLine
from slipfold.results.records import Provenance
from slipfold.results.tables import Frame
from slipfold.results.tori import ToriList, torus_sentence
from slipfold.text import PrintedTable, certain, headed, revolutions_text, stability_word, with_unit

WORDS = {"stable": "yes", "unstable": "no", "neutral": "neutral"}
"""Entries of the column on stability."""

COMPLETE = {"span", "closed", "bifurcation"}
"""Kinds of ends that say nothing about what lies beyond them."""

GAP = 1e-3
"""Fraction of the span below which a part without branches is not reported."""

NEIGHBORS = 8
"""Orbits next to one that cannot be integrated that are tried."""

LOCATED = 1e-9
"""Accuracy of special points, over the largest value of the span."""


def points_by_label(diagram: Diagram) -> dict[int, SpecialPoint]:
    """Return the special points by their number under LAB in the table of the summary."""
    marks = enumerate(diagram._marks(), 1)
    return {label: mark.point for label, mark in marks if mark.point is not None}


def _stability(mark: TableLine) -> str:
    """Say whether an orbit is stable; without damping it is neither that nor unstable."""
    branch: Branch = mark.curve
    if mark.type in BIFURCATION_TYPES:
        return ""
    # A branch that leaves another has a multiplier on the unit circle there, within rounding.
    if mark.point is None and mark.row == 0 and branch.started.kind in ("bifurcation", "closed"):
        return ""
    cycle = branch.kind == "periodic" and not branch.model.forced
    multipliers = branch.multipliers[mark.row] if mark.point is None else mark.point.multipliers
    return WORDS[stability_word(multipliers, cycle=cycle)]


def _neutral(branches: Sequence[Branch]) -> list[str]:
    """Say on which branches multipliers stay on the unit circle from one point to the next."""
    each = ((branch.id, are_neutral(branch.multipliers).sum(axis=1)) for branch in branches)
    on = [str(number) for number, count in each if (count[:-1] * count[1:]).any()]
    if not on:
        return []
    where = f"branch{'es' * (len(on) > 1)} {', '.join(on)}"
    return [
        f"Multipliers stay on the unit circle on {where}, as those of a mode that nothing damps: "
        "of these only collisions of two pairs are seen, and what crosses beside them"
    ]


def _stuck(branch: Branch) -> str:
    """Say for how much of the period contacts stick at most, if they do."""
    most = 0.0 if branch.stuck_fraction is None else float(np.nanmax(branch.stuck_fraction))
    return f"contacts stick for up to {100 * most:.4g} % of the period" if most > 0 else ""


class Labeled(NamedTuple):
    """A special point with the branch that it lies on."""

    branch: Branch
    point: SpecialPoint

    def __repr__(self) -> str:
        return f"<{self.point._line()}; on branch {self.branch.id}>"

    def _repr_html_(self) -> str:
        return self.point._repr_html_()


class Branches(CurveList):
    """Branches as an attribute of a diagram."""

    doc = "The branches; the first is the response of period 1."

    def made(self, result: Any, fields: dict[str, Any], outputs: tuple[str, ...]) -> Branch:
        """Return a branch from its fields."""
        extrema, uncertainty = fields.pop("extrema"), fields.pop("multiplier_uncertainty")
        model, durations = result.model, fields.get("durations")
        if durations is not None and len(durations):
            model = model.replace(duration=float(durations[0]))
        else:
            fields["durations"] = None
        branch = Branch(model=model, vary=result.vary, **fields)
        # What the branch would compute when asked is in the file already.
        vars(branch)["extrema"] = Extrema(outputs, **extrema)
        vars(branch)["multiplier_uncertainty"] = uncertainty
        return branch

    def made_point(
        self, result: Any, fields: dict[str, Any], outputs: tuple[str, ...]
    ) -> SpecialPoint:
        """Return a special point from its fields."""
        model, vary, extrema = result.model, result.vary, fields.pop("extrema")
        if "gradients" in fields:
            found = {
                name: float(fields["gradients"][model.parameter_index(name)])
                for name in sensitive_to(model, vary)
            }
            fields["gradients"] = found if fields["type"] in FOLLOWED_TYPES else None
        point = SpecialPoint(
            model=self.model_of(result, fields, [fields["value"]]), vary=vary, **fields
        )
        reached = {which: values[None] for which, values in extrema.items()}
        vars(point.orbit)["extrema"] = Extrema(outputs, **reached)
        return point


@dataclass(frozen=True, eq=False)
class Diagram(CurveDiagram):
    """The periodic responses of a model over one parameter; frozen.

    Made by `slipfold.response` and `slipfold.load`.

    Notes
    -----
    ``branch_of_point`` is the number of the branch, and likewise for special points, tori, folds
    and resonances. Limits of the model are no special points; a branch that meets one says so where
    it stopped. In `to_csv` equilibria have growth rates, frequencies and damping ratios of their
    modes in place of multipliers, the one that grows fastest first.

    `plot` draws the diagram, e.g. with ``measure="peak_to_peak"``, ``measured=`` a
    `slipfold.Measurement`, or ``under=`` a `slipfold.Sweep` whose trajectories are dots under the
    branches. Lines of families of cycles of every amplitude, as around a center, go beyond axes
    that fit all other branches. With ``kind="spectrum"`` it draws the lines of the torus nearest to
    the value ``at=``, with ``kind="eigenvalues"`` frequencies in Hz and damping ratios in per cent
    of the equilibria, up to the frequency ``highest=``; with ``kind="backbone"`` those of a
    nonlinear mode over its amplitude.
    """

    schema = "slipfold.response/1"
    row = "a point or special point of a branch, or a torus"
    title = "periodic responses of {0.model.name} over {0.vary}"
    thing = "branch"
    noted = ("limit", "closed", "interrupted", "points")

    model: Model
    vary: str
    span: tuple[float, float]
    branches: Annotated[tuple[Branch, ...], Branches()]
    settings: Settings
    events: Annotated[tuple[Event, ...], "Values that were requested to be located."]
    provenance: Provenance
    checked: Checked | None = None
    searched: Annotated[
        BranchSearch | None, "Where branches were searched that nothing leads to; None if nowhere."
    ] = None
    tori: Annotated[tuple[TorusBranch, ...], ToriList()] = ()
    unfollowed: Annotated[
        tuple[str, ...], "Why nothing was followed from some further starts."
    ] = ()

    @property
    def special(self) -> tuple[Labeled, ...]:
        """All special points, each with its branch, branch after branch."""
        return tuple(Labeled(branch, point) for branch in self.branches for point in branch.special)

    @cached_property
    def _end_orbits(self) -> Mapping[tuple[int, int], PeriodicOrbit]:
        """First and last orbit of each branch, by its number and the index."""
        result = {}
        for branch in self.branches:
            for index in (0, len(branch) - 1) if len(branch) else ():
                orbit = result[branch.id, index] = branch.orbit(index)
                known = vars(branch).get("extrema")
                if known is not None and not np.isnan(known.maximum[index]).all():
                    low, high = known.minimum[index, None], known.maximum[index, None]
                    vars(orbit)["extrema"] = Extrema(known.names, low, high)
        return MappingProxyType(result)

    @property
    def interrupted(self) -> bool:
        """Whether the computation was interrupted: branches, normal forms or checks are missing."""
        parts = (self.checked, self.searched, *self.tori)
        stopped = any(part is not None and part.interrupted for part in parts)
        return stopped or any(branch.interrupted for branch in self.branches)

    @property
    def failed(self) -> bool:
        """Whether the continuation of a branch failed."""
        return super().failed or any(each.stopped.early for each in self.tori)

    @property
    def _curves(self) -> tuple[Branch, ...]:
        return self.branches

    @property
    def default_kind(self) -> str:
        """Kind of figure that is drawn without one asked for."""
        return "backbone" if isinstance(self.model, NonlinearMode) else "response"

    @property
    def _spans(self) -> dict[str, tuple[float, float]]:
        return {self.vary: self.span}

    def summary(self, outputs: Sequence[str] | None = None) -> str:
        """Return a table of ends and special points, as AUTO prints it, and why branches stop.

        Parameters
        ----------
        outputs
            States or outputs of which to show maximum and minimum over the continuous orbit; the
            model's `tabulated` if None. What is constant in all orbits has one column.
        """
        return self._text(self._sections(outputs))

    def __repr__(self) -> str:
        """One line: what was followed, how far, and what was found."""
        tori = f", {len(self.tori)} branches of tori" * bool(self.tori)
        return f"<{self._found('branches')}{tori}>"

    def _head(self) -> str:
        return f"{self.model.name}: {self._span_text()}"

    def _sections(self, outputs: Sequence[str] | None = None) -> list[PrintedTable | list[str]]:
        return [self._cells(outputs), self._notes(), *self._gradients()]

    def _cells(self, outputs: Sequence[str] | None) -> PrintedTable:
        states = [state.name for state in self.model.states]
        names = list(self.model.tabulated if outputs is None else outputs)
        known = [*states, *(output.name for output in self.model.outputs())]
        for name in names:
            if name not in known:
                raise unknown(f"{self.model.name} has no output", name, known)
        finalized(self)
        marks, ends = self._marks(), self._end_orbits
        extrema = [
            (ends[mark.curve.id, mark.row] if mark.point is None else mark.point.orbit).extrema
            for mark in marks
        ]
        scales = dict(zip(states, self.model.state_scales().tolist(), strict=True))
        lines, rounding, vary = [], {}, {*names}
        moving = [
            each for mark, each in zip(marks, extrema, strict=True) if mark.curve.kind == "periodic"
        ]
        for name in names:
            if moving and all(np.array_equal(*each.of(name)) for each in moving):
                vary.discard(name)
            sizes = (abs(end[0]) for each in extrema for end in each.of(name))
            rounding[name] = ROUNDING * np.nanmax([scales.get(name, 0.0), *sizes])
        for label, (mark, each) in enumerate(zip(marks, extrema, strict=True), 1):
            branch, (value,) = mark.curve, mark.values
            reached = [
                f"{certain(end[0], rounding[name]):.6g}"
                for name in names
                for end in each.of(name)[:: -1 if name in vary else -2]
            ]
            begin = [branch.id, branch.period, mark.row + 1, mark.type, label, f"{value:.10g}"]
            lines.append([*map(str, begin), *reached, _stability(mark), mark.note])
        heads = ["BR", "period", "PT", "TY", "LAB", self.vary]
        heads += [
            f"{which}{name}"
            for name in names
            for which in (("max ", "min ") if name in vary else ("",))
        ]
        return PrintedTable([*heads, "stable", ""], lines, words=("TY", "stable", ""))

    def _gradients(self) -> list[PrintedTable | list[str]]:
        """Return how special points move with each parameter, if that was requested."""
        points = points_by_label(self).items()
        known = {label: point for label, point in points if point.gradients}
        if not known:
            return []
        lines = [
            [headed(self.model.parameter(name))]
            + [f"{(point.gradients or {})[name]:.8g}" for point in known.values()]
            for name in sensitive_to(self.model, self.vary)
        ]
        heads = [f"{point.type} ({label})" for label, point in known.items()]
        title = (
            f"Derivatives of {self.vary} at special points (LAB), by each parameter in SI units:"
        )
        return [[title], PrintedTable(["by", *heads], lines, words=("by",))]

    @property
    def _noise(self) -> list[float]:
        wide = max(map(abs, self.span))
        zeros = [
            point.uncertainty
            for _, point in self.special
            if abs(point.value) <= point.uncertainty <= LOCATED * wide
        ]
        return [max([ROUNDING * wide, *zeros])]

    def _endings(self) -> list[str]:
        sentences, (noise,) = [], self._noise
        for branch in self.branches:
            started, stopped = branch.ends
            begins, ends = (self._at([certain(end.value, noise)]) for end in branch.ends)
            size = f"{branch._content}, {len(branch)} points"
            size = ", ".join(
                filter(None, [size, revolutions_text(branch.revolutions), _stuck(branch)])
            )
            closed = started.reason == stopped.reason  # it ends where it begins
            if branch.parent is None and not closed and started.value != self.span[0]:
                sentences.append(f"Branch {branch.id}: {started.reason}")
            if branch.parent is not None and started.kind != "bifurcation":
                sentences.append(f"Branch {branch.id} begins at {begins}: {started.reason}")
            sentences.append(f"Branch {branch.id} ({size}) stopped at {ends}: {stopped.reason}")
        return sentences

    def _notes(self) -> list[str]:
        uncertain = self._uncertain()
        tori = map(torus_sentence, self.tori)
        search = self._gap_note() if self.searched is None else self._search_note()
        also = [f"Nothing was followed from a further start: {why}" for why in self.unfollowed]
        also += _neutral(self.branches)
        return [*self._endings(), *also, *uncertain, *tori, *search, *super()._notes()]

    def _gap_note(self) -> list[str]:
        """Say where in the span there is no branch, where no end of a branch says it already."""
        ends = {end.kind for branch in self.branches for end in branch.ends}
        if not self.branches or not ends <= COMPLETE:
            return []
        wide = gaps_between(self.branches, self.span, GAP)
        if not wide:
            return []
        unit = self.model.parameter(self.vary).unit
        where = " and ".join(
            with_unit(f"{self.vary} from {first:.6g} to {last:.6g}", unit) for first, last in wide
        )
        return [
            f"No branch was found for {where}; search=True (--search) looks for branches to which "
            "no bifurcation leads"
        ]

    def _search_note(self) -> list[str]:
        searched = self.searched
        if searched is None:
            return []
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
        total, left = searched.starts * len(searched.values), searched.undecided
        open_ = f"; {left} of {total} starts had not settled after {searched.periods} periods"
        open_ = f"{open_}: ask attractors on what they settle, with more periods" * bool(left)
        return [f"Searched from {where}: {found}; in {box}{open_}"]

    def _record(self) -> dict[str, Any]:
        branches = [*Branches().record(self, "branches"), *ToriList().record(self, "tori")]
        searched = {} if self.searched is None else {"searched": asdict(self.searched)}
        return {"vary": self.vary, "branches": branches, **searched}

    def _frame(self) -> Frame:
        frame = self._rows_along(
            [*self.branches, *self.tori],
            ("period",),
            ("branch", "period", "type", "criticality", self.vary),
            "torus" if self.tori else "",
        )
        rest = {branch.id for branch in self.branches if branch.kind == "equilibrium"}
        rows = [row for row, owner in enumerate(frame.columns["branch"]) if owner in rest]
        return self._with_modes(frame, rows) if rows else frame

    def _with_modes(self, frame: Frame, rows: Sequence[int]) -> Frame:
        """Give equilibria in some rows modes in place of multipliers over a unit of time."""
        heads = [self.vary, *(item.name for item in self.model.states)]
        places = np.array([frame.columns[head] for head in heads], dtype=float).T[rows].tolist()
        jacobian, changed = evaluation_of(self.model).jacobian, self.model.replace
        modes = [
            modes_of(jacobian(changed(**{self.vary: value}), np.array(state)))
            for value, *state in places
        ]
        columns, units = dict(frame.columns), dict(frame.units)
        for head in [head for head in columns if head.startswith("multiplier ")]:
            columns[head] = kept = np.array(columns[head], dtype=float)
            kept[rows] = np.nan
            if np.isnan(kept).all():
                del columns[head]
        for number in range(max(map(len, modes))):
            for place, (name, unit) in enumerate(MODE_UNITS.items()):
                head = f"{name} {number + 1}"
                column = columns[head] = np.full(len(frame), np.nan)
                units[head] = unit
                for row, found in zip(rows, modes, strict=True):
                    column[row] = found[number, place] if number < len(found) else np.nan
        return Frame(columns, units)


def finalized(diagram: Diagram) -> Diagram:
    """Compute what the summary shows, so that it is data: extrema at ends and special points.

    Orbits that have as many nodes are integrated together.
    """
    groups: dict[Any, list[PeriodicOrbit]] = defaultdict(list)
    for orbit in (*diagram._end_orbits.values(), *(point.orbit for _, point in diagram.special)):
        if isinstance(orbit, StickSlipOrbit):
            vars(orbit).setdefault("extrema", orbit.extrema)
        elif "extrema" not in vars(orbit):
            groups[orbit.period, orbit.nodes.shape].append(orbit)
    for (period, _), orbits in groups.items():
        vectors = np.array([orbit.model.vector for orbit in orbits])
        nodes = np.array([orbit.nodes for orbit in orbits])
        result = find_extrema(orbits[0].model, vectors, nodes, period)
        for row, orbit in enumerate(orbits):
            one = slice(row, row + 1)
            own = Extrema(result.names, result.minimum[one], result.maximum[one])
            vars(orbit)["extrema"] = own
    for branch, point in diagram.special:
        if np.isnan(point.orbit.extrema.maximum[0, 0]):
            vars(point.orbit)["extrema"] = _limit(branch, point)
    return diagram


def _limit(branch: Branch, point: SpecialPoint) -> Extrema:
    """Extrapolate extrema to an orbit that cannot be integrated from two orbits on one side of it.

    At a planar GRAZE slip has no direction.
    """
    ahead = branch.arclength - point.arclength
    known = list[tuple[float, Extrema]]()
    for row in np.argsort(np.abs(ahead))[:NEIGHBORS]:
        extrema = branch.orbit(int(row)).extrema
        beside = not known or ahead[row] * known[0][0] > 0
        if beside and ahead[row] and np.isfinite(extrema.maximum[0, 0]):
            known.append((float(ahead[row]), extrema))
        if len(known) == 2:
            (near, first), (far, second) = known
            weight = near / (far - near)
            low, high = (
                one + weight * (one - other)
                for one, other in ((first.minimum, second.minimum), (first.maximum, second.maximum))
            )
            return Extrema(first.names, low, high)
    return point.orbit.extrema
