"""Responses of one model for many cases: a diagram each, or why there is none."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple, overload

import numpy as np
from numpy.typing import NDArray

from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.models.model import Model
from slipfold.results.diagram import Diagram
from slipfold.results.fields import REAL, TEXT, WHOLE, Column, Entry, Items, Labels, ResultPart
from slipfold.results.records import Provenance, SavedTable, open_table
from slipfold.results.result import Result
from slipfold.results.study import CaseNumber
from slipfold.results.tables import Frame, LabeledTable, frame_of
from slipfold.text import PrintedTable, listed

INTERRUPTED = "interrupted before this case was reached"


class CasePoint(NamedTuple):
    """A special point with its branch and the number of its case, from 0."""

    case: int
    branch: Branch
    point: SpecialPoint


@dataclass(frozen=True)
class Diagrams(ResultPart):
    """Diagrams of many cases, each in a group of the file."""

    doc = "One a case; None where there is none."

    def read(self, saved: SavedTable, result: Any, key: str) -> tuple[Diagram | None, ...]:
        """Return the diagrams."""
        groups = saved.table.groups
        kind = type(result.model)
        return tuple(
            None if reason else Diagram._read(open_table(groups[f"case_{case}"], kind))
            for case, reason in enumerate(saved.columns["reason"].tolist())
        )


@dataclass(frozen=True, eq=False, repr=False)
class Responses(Result, Sequence["Diagram | None"]):
    """The periodic responses of a model for many cases; frozen, a sequence of diagrams.

    Made by `slipfold.responses` and `slipfold.load`. Each diagram is what `slipfold.response`
    gives for its case alone.

    Notes
    -----
    ``case_of_special`` is the case of a special point. A file has the diagram of each case as a
    group.
    """

    schema = "slipfold.responses/1"
    row = "a special point, with the values of its case"
    title = "periodic responses of {0.model.name} over {0.vary}, many cases"
    arrays = MappingProxyType({
        "branches": Entry("case", "number of branches", "", WHOLE),
        "special": Items("special", (
            Column("case", WHOLE, "case it belongs to, from 0", "", name="case_of_special",
                   label=True),
            Column("point.type", TEXT, "type of special point", name="special_type", head="type"),
            Column("point.period", WHOLE, "in forcing periods", "", name="special_period",
                   head="period"),
            Column("point.value", REAL, "{vary}", "{vary}", name="special_value", label=True,
                   head="value"),
            Column("point.uncertainty", REAL, "computed uncertainty of special_value", "{vary}",
                   name="special_uncertainty", head="uncertainty"),
            Column("point.criticality", TEXT, "empty: none", optional=True,
                   name="special_criticality", head="criticality"),
            Column("point.coefficient", REAL, "of the normal form", optional=True,
                   name="special_coefficient", head="coefficient"),
        )),
    })  # fmt: skip

    model: Model
    vary: str
    span: tuple[float, float]
    over: Annotated[Mapping[str, NDArray[np.float64]], Labels("case")]
    diagrams: Annotated[tuple[Diagram | None, ...], Diagrams()]
    reasons: Annotated[tuple[str, ...], Entry("case", "why there is no diagram", name="reason")]
    provenance: Provenance

    def __len__(self) -> int:
        return len(self.diagrams)

    @overload
    def __getitem__(self, index: int) -> Diagram | None: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Diagram | None, ...]: ...

    def __getitem__(self, index: int | slice) -> Diagram | tuple[Diagram | None, ...] | None:
        return self.diagrams[index]

    def __iter__(self) -> Iterator[Diagram | None]:
        return iter(self.diagrams)

    @property
    def branches(self) -> list[int]:
        """How many branches each case has, 0 where there is no diagram."""
        return [0 if each is None else len(each.branches) for each in self.diagrams]

    @property
    def special(self) -> tuple[CasePoint, ...]:
        """All special points, each with its case and branch, case after case."""
        return tuple(
            CasePoint(case, branch, point)
            for case, diagram in enumerate(self.diagrams)
            if diagram is not None
            for branch, point in diagram.special
        )

    @property
    def failures(self) -> dict[int, str]:
        """Why there is no diagram, by the number of the case, from 0."""
        return {case: reason for case, reason in enumerate(self.reasons) if reason}

    @property
    def interrupted(self) -> bool:
        """Whether the computation was interrupted, so that cases were not reached."""
        return INTERRUPTED in self.reasons

    def case(self, index: CaseNumber) -> dict[str, float]:
        """Return the values of a case by name."""
        return {name: float(values[index]) for name, values in self.over.items()}

    def _table(self) -> LabeledTable:
        """Return cases and special points; each diagram is a group of its own."""
        known = enumerate(self.diagrams)
        return replace(
            super()._table(),
            groups={f"case_{case}": each._table() for case, each in known if each is not None},
        )

    def _record(self) -> dict[str, Any]:
        cases = [
            {"given": self.case(case), "reason": self.reasons[case] or None}
            | {"branches": None if each is None else each._record()["branches"]}
            for case, each in enumerate(self.diagrams)
        ]
        return {"vary": self.vary, "span": self.span, "cases": cases}

    def _frame(self) -> Frame:
        result = frame_of(self._variables(), ["special"])
        cases = np.array(result.columns["case"], int)
        given = {name: values[cases] for name, values in self.over.items()}
        units = {name: self.model.parameter(name).unit for name in (*self.over, self.vary)}
        units |= dict.fromkeys(("value", "uncertainty"), units[self.vary])
        return Frame({"case": cases, **given} | {**result.columns}, units)

    def _line(self) -> str:
        found = sum(diagram is not None for diagram in self.diagrams)
        return (
            f"Responses of {self.model.name}: {self.vary} = {self.span[0]:g} to {self.span[1]:g} "
            f"over {listed(self.over)}, {found} of {len(self)} cases"
        )

    def _rows(self) -> PrintedTable:
        """Special points by type and period: in how many cases, and over what range."""
        values: dict[tuple[str, int], list[float]] = {}
        cases: dict[tuple[str, int], set[int]] = {}
        for case, branch, point in self.special:
            kind = point.type, branch.period
            values.setdefault(kind, []).append(point.value)
            cases.setdefault(kind, set()).add(case)
        head = (
            "type",
            "period",
            "cases",
            "points",
            f"smallest {self.vary}",
            f"largest {self.vary}",
        )
        rows = [
            (kind, str(period), str(len(cases[kind, period])), str(len(found)),
             f"{min(found):.9g}", f"{max(found):.9g}")
            for (kind, period), found in values.items()
        ]  # fmt: skip
        return PrintedTable(head, rows, ("type",))

    def _notes(self) -> list[str]:
        counts = Counter(reason for reason in self.reasons if reason)
        return [f"{count} without a diagram: {reason}" for reason, count in counts.most_common()]
