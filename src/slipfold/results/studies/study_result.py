"""What a study found: one labelled dataset of all its cases."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipfold.design_space.sobol_indices import SobolIndices
from slipfold.drawing import draw
from slipfold.models.model import Model
from slipfold.results.fields import REAL, TEXT, WHOLE, Column, meaning_of
from slipfold.results.frame import Frame
from slipfold.results.labelled_table import Variable
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.results.saved_table import SavedTable
from slipfold.results.studies.deferred import Deferred
from slipfold.results.studies.gathered import KINDS, Gathered, type_of
from slipfold.results.studies.study_indices import (
    are_told,
    index_lines,
    index_records,
    indices_in,
)
from slipfold.studies.cases import Cases, Grid, Rows, total
from slipfold.studies.plan import Plan
from slipfold.studies.task import Record
from slipfold.studies.work.kinds import WORK
from slipfold.studies.work.work import Quantity, Work
from slipfold.text.one_line import headed, listed
from slipfold.text.printed_table import PrintedTable, html_list

OWNER = Quantity(
    "case", "whole", "number of its case, from 0, the last parameter of a grid changing first"
)

NOT_REACHED = "not computed yet"


@dataclass(frozen=True, eq=False, repr=False)
class StudyResult(Result):
    """What was found of every case of a study; frozen.

    Made by `slipfold.study` and `slipfold.load`.

    Parameters
    ----------
    model
        The base case; its values of what differs from case to case play no part.
    work
        What was computed of every case.
    cases
        The cases.
    values
        What was found, by the name of the quantity, each of shape (n_cases,), in the order of the
        cases. Where a number is missing it is NaN, or 0 if it counts something.
    listed
        What is said of all special points, or attractors, by name, each of shape (n_listed,), case
        after case; ``"case"`` is the number of the case, from 0. Empty if cases have neither.
    reasons
        Why there is nothing of a case, one sentence a case; empty where there is something.
    provenance
        Versions; a study may be interrupted and resumed, so there is no time.
    stopped
        Whether it was stopped before all that was asked for was computed, cases that failed and
        were to be tried again among it.
    damaged
        How many damaged lines the store had, of cases that were computed again; not saved.

    Notes
    -----
    The dataset of `to_xarray` lies along the parameters of a grid, which label it, so that
    ``dataset.threshold.sel(Vd=0.6)`` is a threshold; along ``case`` if the cases were listed or
    drawn. Special points of all cases lie along ``special``, with ``case_of_special``, and
    attractors along ``attractor``. In the spreadsheet of `to_csv` a case is a row. In `to_json`,
    schema slipfold.study/1, cases and failures.

    Examples
    --------
    >>> import slipfold as sf
    >>> found = sf.study({
    ...     "model": "sliding",
    ...     "parameters": {"f": 12.5},
    ...     "compute": {"what": "threshold", "vary": "Nd", "span": [0, 0.9]},
    ...     "cases": {"grid": {"Vd": [0.5, 0.6]}},
    ... })
    >>> found.to_xarray().threshold.values.round(6).tolist()
    [0.048761, 0.043579]
    """

    schema = "slipfold.study/1"

    model: Model
    work: Work
    cases: Cases
    values: Mapping[str, NDArray[Any]]
    listed: Mapping[str, NDArray[Any]]
    reasons: NDArray[np.object_]
    provenance: Provenance
    stopped: bool = False
    damaged: int = 0

    def __len__(self) -> int:
        """Number of cases."""
        return len(self.reasons)

    @property
    def failures(self) -> dict[int, str]:
        """Why cases failed, by their numbers, from 0."""
        places = np.flatnonzero((self.reasons != "") & (self.reasons != NOT_REACHED))
        return {int(place): str(self.reasons[place]) for place in places}

    @property
    def done(self) -> int:
        """How many cases are finished; the others were not reached."""
        return int((self.reasons != NOT_REACHED).sum())

    @property
    def interrupted(self) -> bool:
        """Whether cases were not reached, or not tried again."""
        return self.stopped or self.done < len(self)

    def case(self, number: int) -> dict[str, float]:
        """Return the values of the parameters of a case by name.

        Parameters
        ----------
        number
            Its number, from 0.
        """
        (row,) = self.cases.values(np.array([number])).tolist()
        return dict(zip(self.cases.names, row, strict=True))

    def model_at(self, number: int) -> Model:
        """Return the model of a case.

        Parameters
        ----------
        number
            Its number, from 0.
        """
        return self.model.replace(**self.case(number))

    @cached_property
    def quantities(self) -> tuple[Quantity, ...]:
        """What was found of every case: name, kind, meaning and unit."""
        return self.work.quantities(self.model)

    def indices(self, quantity: str | ArrayLike) -> SobolIndices:
        """Return which shares of the variance of a quantity the parameters account for.

        Parameters
        ----------
        quantity
            The name of a number that was found, or a number for each case, shape (n_cases,).

        Returns
        -------
        SobolIndices
            First and total indices with their errors.

        Raises
        ------
        InputError
            If cases were not drawn by ``sample = "saltelli"``, a case has no such number (a period
            of 0 is none), or what is given is not a number for each case.

        Examples
        --------
        >>> import slipfold as sf
        >>> scatter = {"mu": "normal 2%", "Vd": "normal 2%"}
        >>> found = sf.study({
        ...     "model": "sliding",
        ...     "parameters": {"f": 12.5, "Nd": 0.02},
        ...     "compute": {"what": "simulation"},
        ...     "cases": {"sample": "saltelli", "count": 4, "scatter": scatter},
        ... })
        >>> len(found), found.indices("max_x").names
        (16, ('mu', 'Vd'))
        """
        return indices_in(self, quantity)

    def summary(self) -> str:
        """Return the range of every number, how often words occur, and why cases failed.

        Indices as well, where cases were drawn for them.
        """
        return "\n".join(
            [repr(self)[1:-1], *self._rows().text(), *index_lines(self), *self._missing()]
        )

    def plot(self, quantity: str | None = None, **options: Any) -> Any:
        """Draw a quantity over what differs from case to case: a line, a map, or many maps.

        Parameters
        ----------
        quantity
            Its name; the first number that was found if None.
        **options
            Options of the drawing, e.g. ``ax=`` the axes to draw in.

        Returns
        -------
        matplotlib.axes.Axes or ndarray of them
            The axes.
        """
        return draw(self, quantity=quantity, **options)

    def __repr__(self) -> str:
        """One line: what was computed over what, for how many cases, and how many failed."""
        missing = len(self.failures)
        failed = f", {missing} failed" if missing else ""
        size = f"{self.done} of {len(self)}" if self.interrupted else f"{len(self)}"
        return f"<{self._title()}, {size} cases{failed}>"

    def _repr_html_(self) -> str:
        return self._rows().html(repr(self)[1:-1]) + html_list(self._missing())

    def _rows(self) -> PrintedTable:
        rows = []
        whole = self.reasons == ""
        for item in self.quantities:
            values = self.values[item.name][whole]
            if item.kind == "text":
                counts = Counter(str(value) for value in values if value)
                said = listed(f"{count} {word}" for word, count in counts.most_common())
                rows.append([item.name, "", "", said])
                continue
            known = values[np.isfinite(values)] if item.kind == "real" else values
            ends = [f"{end:.9g}" for end in (known.min(), known.max())] if len(known) else ["", ""]
            rows.append([headed(item), *ends, f"{len(known)} cases"])
        return PrintedTable(["", "least", "largest", "found"], rows, ("", "found"))

    def _missing(self) -> list[str]:
        counts = Counter(self.failures.values())
        lines = [f"{count} failed: {reason}" for reason, count in counts.most_common(9)]
        if self.damaged:
            plural = "s" if self.damaged > 1 else ""
            lines.append(f"{self.damaged} damaged line{plural} of the store left out")
        return lines

    def _title(self) -> str:
        return f"Study of {self.model.name}: {self.work.what} over {listed(self.cases.names)}"

    def _given(self) -> dict[str, Any]:
        given = {"compute": self.work.record(), "cases": self.cases.record()}
        return given | {"stopped": True} if self.stopped else given

    def _attributes(self) -> dict[str, Any]:
        return {"compute": self.work.what}

    def _column(self, parameter: str) -> str:
        """Return the name of the variable of a parameter, no other's."""
        each = self.work.listed
        taken = {"case", each, "failed", *(item.name for item in self.quantities)}
        taken |= {f"{each}_{item.name}" for item in self.work.lists(self.model)}
        return f"{parameter}_value" if parameter in taken else parameter

    def _variables(self) -> Mapping[str, Variable]:
        labels = {name: self._column(name) for name in self.cases.names}
        along = tuple(labels.values()) if isinstance(self.cases, Grid) else ("case",)
        found = Deferred()
        for place, (name, label) in enumerate(labels.items()):
            item = self.model.parameter(name)
            column = Column(name, REAL, meaning_of(item), item.unit, label=True)
            own = (label,) if isinstance(self.cases, Grid) else along
            found.add(label, column, own, partial(self._given_values, name, place))
        for quantity in self.quantities:
            found.add(quantity.name, _column(quantity), along, partial(self._shaped, quantity.name))
        reasons = Column("failed", TEXT, "why there is nothing of this case")
        found.add("failed", reasons, along, lambda: self.reasons.reshape(self.cases.shape))
        if self.listed:
            each = self.work.listed
            owner = Column("case", WHOLE, OWNER.meaning, label=True)
            found.add(f"case_of_{each}", owner, (each,), partial(self.listed.__getitem__, "case"))
            for described in self.work.lists(self.model):
                values = partial(self.listed.__getitem__, described.name)
                found.add(f"{each}_{described.name}", _column(described), (each,), values)
        return found

    def _given_values(self, name: str, place: int) -> NDArray[np.float64]:
        """Return the values that label an axis of a grid, or cases one by one."""
        if isinstance(self.cases, Grid):
            return self.cases.axes[name]
        assert isinstance(self.cases, Rows)
        return np.ascontiguousarray(self.cases.rows[:, place])

    def _shaped(self, name: str) -> NDArray[Any]:
        return self.values[name].reshape(self.cases.shape)

    def _record(self) -> dict[str, Any]:
        failures = [
            {"case": number, "given": self.case(number), "reason": reason}
            for number, reason in self.failures.items()
        ]
        return {
            "compute": self.work.record(),
            "cases": self._case_records(),
            "interrupted": self.interrupted,
            "failures": failures,
            **({"indices": index_records(self)} if are_told(self) else {}),
        }

    def _case_records(self) -> list[dict[str, Any]]:
        values, each = dict(self.values), dict(self.listed)
        owners = each.pop("case", None)
        records = []
        for number in range(len(self)):
            found = {item.name: values[item.name][number] for item in self.quantities}
            record = {"given": self.case(number), **found}
            if owners is not None:
                first, last = np.searchsorted(owners, [number, number + 1])
                record[self.work.listed] = [
                    {name: column[row] for name, column in each.items()}
                    for row in range(first, last)
                ]
            records.append(record)
        return records

    def _frame(self) -> Frame:
        items = [self.model.parameter(name) for name in self.cases.names]
        given = self.cases.values(np.arange(len(self))).T
        columns: dict[str, Any] = {"case": np.arange(len(self))}
        columns |= {self._column(item.name): row for item, row in zip(items, given, strict=True)}
        columns |= {item.name: self.values[item.name] for item in self.quantities}
        units = {self._column(item.name): item.unit for item in items}
        units |= {item.name: item.unit for item in self.quantities}
        return Frame({**columns, "failed": self.reasons}, units)

    @classmethod
    def _read(cls, saved: SavedTable) -> StudyResult:
        model = saved.model
        work = WORK.validate_python(saved.given["compute"])
        cases = _cases_of(saved.given["cases"])
        columns = saved.columns
        if not isinstance(cases, Grid):
            names = [name for name, item in saved.table.variables.items() if item.label]
            named = [name for name in names if name != f"case_of_{work.listed}"]
            rows = np.stack([columns[name] for name in named], axis=1)
            cases = Rows(cases.names, rows, cases.record() if "sample" in cases.record() else None)
        values = {
            item.name: columns[item.name].ravel().astype(type_of(item))
            for item in work.quantities(model)
        }
        listed = {}
        if work.lists(model):
            listed["case"] = columns[f"case_of_{work.listed}"]
            for item in work.lists(model):
                listed[item.name] = columns[f"{work.listed}_{item.name}"].astype(type_of(item))
        reasons = columns["failed"].ravel().astype(object)
        stopped = bool(saved.given.get("stopped", False))
        return cls(model, work, cases, values, listed, reasons, saved.provenance, stopped)


def study_result(
    plan: Plan,
    records: Iterable[Record],
    origin: Provenance,
    stopped: bool = False,
    damaged: int = 0,
) -> StudyResult:
    """Put the finished cases together, in the order of their numbers."""
    described = plan.work.lists(plan.model)
    values = Gathered(plan.work.quantities(plan.model))
    listed = Gathered([OWNER, *described])
    reasons = np.full(total(plan.cases), NOT_REACHED, object)
    number = -1
    for record in records:
        for _ in range(number + 1, record["case"]):
            values.add({})
        number = record["case"]
        reasons[number] = record.get("failed", "")
        values.add(record.get("found", {}))
        for each in record.get("listed", ()):
            listed.add({"case": number, **each})
    for _ in range(number + 1, len(reasons)):
        values.add({})
    table = listed.columns() if described else {}
    return StudyResult(
        plan.model,
        plan.work,
        plan.cases,
        values.columns(),
        table,
        reasons,
        origin,
        stopped,
        damaged,
    )


def _cases_of(record: Mapping[str, Any]) -> Cases:
    """Return cases as a record describes them; the rows of a sample stand elsewhere."""
    if "grid" in record:
        return Grid({name: np.array(values) for name, values in record["grid"].items()})
    if "list" in record:
        names = tuple(record["list"])
        return Rows(names, np.array([record["list"][name] for name in names]).T)
    return Rows(tuple(record["scatter"]), np.empty((0, 0)), record)


def _column(item: Quantity) -> Column:
    unit = None if item.kind == "text" else item.unit
    return Column(item.name, KINDS[item.kind], item.meaning, unit)
