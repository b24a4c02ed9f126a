"""Responses of one model for many cases: a diagram each, or why there is none."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple, overload

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.branch import Branch
from slipfold.branches.special_point import SpecialPoint
from slipfold.models.model import Model
from slipfold.read_only import ReadOnly
from slipfold.results.column import REAL, TEXT, WHOLE, Column
from slipfold.results.diagram import Diagram
from slipfold.results.labelled_table import LabelledTable
from slipfold.results.provenance import Provenance
from slipfold.results.result import described
from slipfold.results.table import Table, meaning_of
from slipfold.text.one_line import listed
from slipfold.text.printed_table import PrintedTable, html_list

if TYPE_CHECKING:
    import xarray

__all__ = ["INTERRUPTED", "Responses"]

INTERRUPTED = "interrupted before this case was reached"

TAKEN = {"branches", "reason", "case_of_special"}
"""Names that a parameter of the same name must not take from a column."""


class Found(NamedTuple):
    """A special point with its branch and the number of its case, from 0."""

    case: int
    branch: Branch
    point: SpecialPoint


@dataclass(frozen=True, eq=False, repr=False)
class Responses(ReadOnly, Sequence["Diagram | None"]):
    """The periodic responses of a model for many cases; frozen, a sequence of diagrams.

    Made by `slipfold.responses`. Each diagram is what `slipfold.response` gives for its case alone.

    Parameters
    ----------
    model
        The model; its values of `vary` and of what differs from case to case play no part.
    vary
        Name of the parameter followed.
    span
        First and last value asked for.
    over
        Values that differ from case to case, by name, each of shape (n_cases,).
    diagrams
        One a case; None where there is none.
    reasons
        Why there is none, one sentence a case; empty where there is one.
    provenance
        Versions and time.

    Notes
    -----
    In the dataset of `to_xarray`, along ``case``: the values given, how many branches were found
    and why there are none; along ``special``: the special points of all cases, one after the
    other, with ``case_of_special``.

    Examples
    --------
    >>> import slipfold as sf
    >>> cases = {"Vd": [0.5, 0.6], "mu": [0.5, 0.45]}
    >>> found = sf.responses(sf.SlidingOscillator(f=12.5), "Nd", (0, 0.1), over=cases)
    >>> [round(diagram.branches[0].special[0].value, 6) for diagram in found]
    [0.048761, 0.044159]
    """

    model: Model
    vary: str
    span: tuple[float, float]
    over: Mapping[str, NDArray[np.float64]]
    diagrams: tuple[Diagram | None, ...]
    reasons: tuple[str, ...]
    provenance: Provenance

    def __post_init__(self) -> None:
        """Lock the arrays, and the mapping of parameters."""
        object.__setattr__(self, "over", MappingProxyType(dict(self.over)))
        super().__post_init__()

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
    def special(self) -> tuple[Found, ...]:
        """All special points, each with its case and branch, case after case."""
        return tuple(
            Found(case, branch, point)
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

    def case(self, index: int) -> dict[str, float]:
        """Return the values of a case by name.

        Parameters
        ----------
        index
            Its number, from 0.
        """
        return {name: float(values[index]) for name, values in self.over.items()}

    def summary(self) -> str:
        """Return how many cases have which special points, and why others have no diagram."""
        return "\n".join([repr(self)[1:-1], *self._rows().text(), *self._missing()])

    def to_xarray(self) -> xarray.Dataset:
        """Return cases and special points as one labelled dataset; the notes say along what.

        Returns
        -------
        xarray.Dataset
            Units and meanings are in the attributes, as is the full input.
        """
        cases, special = _case_table(self), _special_table(self.model, self.vary)
        points = [point for _, _, point in self.special]
        variables = cases.variables(range(len(self)), {})
        variables |= special.variables(points, {}, [case for case, _, _ in self.special])
        given = {
            "vary": self.vary,
            "span": list(self.span),
            "over": {name: values.tolist() for name, values in self.over.items()},
        }
        title = f"periodic responses of {self.model.name} over {self.vary}, {len(self)} cases"
        attributes = described("slipfold.responses/1", title, self.model, given, self.provenance)
        return LabelledTable(variables, attributes).to_xarray()

    def __repr__(self) -> str:
        """One line: what was followed for how many cases, over what, and how many failed."""
        found = sum(diagram is not None for diagram in self.diagrams)
        return (
            f"<Responses of {self.model.name}: {self.vary} = {self.span[0]:g} to {self.span[1]:g} "
            f"over {listed(self.over)}, {found} of {len(self)} cases>"
        )

    def _repr_html_(self) -> str:
        return self._rows().html(repr(self)[1:-1]) + html_list(self._missing())

    def _rows(self) -> PrintedTable:
        """Special points by type and period: in how many cases, and over what range."""
        values: dict[tuple[str, int], list[float]] = {}
        cases: dict[tuple[str, int], set[int]] = {}
        for case, branch, point in self.special:
            kind = point.type, branch.period
            values.setdefault(kind, []).append(point.value)
            cases.setdefault(kind, set()).add(case)
        head = ("type", "period", "cases", "points", f"least {self.vary}", f"largest {self.vary}")
        rows = [
            (kind, str(period), str(len(cases[kind, period])), str(len(found)),
             f"{min(found):.9g}", f"{max(found):.9g}")
            for (kind, period), found in values.items()
        ]  # fmt: skip
        return PrintedTable(head, rows, ("type",))

    def _missing(self) -> list[str]:
        counts = Counter(reason for reason in self.reasons if reason)
        return [f"{count} without a diagram: {reason}" for reason, count in counts.most_common()]


def _column_name(parameter: str) -> str:
    """Return the name of the column of a parameter, no other column's or dimension's."""
    taken = parameter in TAKEN or parameter.partition("_")[0] in ("case", "special")
    return f"given_{parameter}" if taken else parameter


def _case_table(found: Responses) -> Table:
    columns = [
        Column(name, REAL, meaning_of(item), item.unit, get=values.__getitem__,
               name=_column_name(name), label=True)
        for name, values in found.over.items()
        for item in (found.model.parameter(name),)
    ]  # fmt: skip
    branches = [0 if item is None else len(item.branches) for item in found.diagrams]
    columns += [
        Column("branches", WHOLE, "number of branches", "", get=branches.__getitem__),
        Column("reason", TEXT, "why there is no diagram", get=found.reasons.__getitem__),
    ]
    return Table(("case",), tuple(columns))


def _special_table(model: Model, vary: str) -> Table:
    parameter = model.parameter(vary)
    columns = (
        Column("type", TEXT, "type of special point"),
        Column("period", WHOLE, "in forcing periods", ""),
        Column("value", REAL, meaning_of(parameter), parameter.unit, label=True),
        Column("uncertainty", REAL, "computed uncertainty of special_value", parameter.unit),
        Column("criticality", TEXT, "empty: none", optional=True),
        Column("coefficient", REAL, "of the normal form", optional=True),
    )
    return Table(("special",), columns, "special_", ("case", "case it belongs to, from 0"))
