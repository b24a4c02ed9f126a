"""What a study found: one labelled dataset of all its cases."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.drawing import draw
from slipfold.models.model import Model
from slipfold.results.column import REAL, TEXT, WHOLE, Column, Kind
from slipfold.results.labelled_table import Variable
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.results.saved_table import SavedTable
from slipfold.results.table import meaning_of
from slipfold.studies.cases import Cases, Grid, Rows, total
from slipfold.studies.plan import Plan
from slipfold.studies.task import Record
from slipfold.studies.work.kinds import WORK
from slipfold.studies.work.work import Quantity, Work
from slipfold.text.one_line import headed, listed
from slipfold.text.printed_table import PrintedTable, html_list

__all__ = ["StudyResult", "study_result"]

KINDS: dict[str, Kind] = {"real": REAL, "whole": WHOLE, "text": TEXT}

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

    def __post_init__(self) -> None:
        """Lock the arrays."""
        for array in (*self.values.values(), *self.listed.values(), self.reasons):
            array.setflags(write=False)

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

    def summary(self) -> str:
        """Return the range of every number, how often words occur, and why cases failed."""
        return "\n".join([repr(self)[1:-1], *self._rows().text(), *self._missing()])

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
        for item in self.quantities:
            values = self.values[item.name][self.reasons == ""]
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
        return [f"{count} failed: {reason}" for reason, count in counts.most_common(9)]

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

    def _variables(self) -> dict[str, Variable]:
        labels = {name: self._column(name) for name in self.cases.names}
        grid = isinstance(self.cases, Grid)
        along = tuple(labels.values()) if grid else ("case",)
        variables: dict[str, Variable] = {}
        for place, (name, label) in enumerate(labels.items()):
            item = self.model.parameter(name)
            column = Column(name, REAL, meaning_of(item), item.unit, label=True)
            if isinstance(self.cases, Grid):
                variables |= column.variables(label, (label,), self.cases.axes[name])
            else:
                assert isinstance(self.cases, Rows)
                rows = np.ascontiguousarray(self.cases.rows[:, place])
                variables |= column.variables(label, along, rows)
        for quantity in self.quantities:
            values = self.values[quantity.name].reshape(self.cases.shape)
            variables |= _column(quantity).variables(quantity.name, along, values)
        reasons = Column("failed", TEXT, "why there is nothing of this case")
        variables |= reasons.variables("failed", along, self.reasons.reshape(self.cases.shape))
        return variables | self._listed_variables()

    def _listed_variables(self) -> dict[str, Variable]:
        if not self.listed:
            return {}
        each = self.work.listed
        owner = Column("case", WHOLE, "number of its case, from 0, the last parameter of a grid "
                       "changing first", label=True)  # fmt: skip
        variables = owner.variables(f"case_of_{each}", (each,), self.listed["case"])
        for item in self.work.lists(self.model):
            name = f"{each}_{item.name}"
            variables |= _column(item).variables(name, (each,), self.listed[item.name])
        return variables

    def _record(self) -> dict[str, Any]:
        failures = [
            {"case": number, "given": self.case(number), "reason": reason}
            for number, reason in self.failures.items()
        ]
        return {
            "compute": self.work.record(),
            "cases": [self._case_record(number) for number in range(len(self))],
            "interrupted": self.interrupted,
            "failures": failures,
        }

    def _case_record(self, number: int) -> dict[str, Any]:
        found = {item.name: self.values[item.name][number] for item in self.quantities}
        record = {"given": self.case(number), **found}
        if self.listed:
            first, last = np.searchsorted(self.listed["case"], [number, number + 1])
            record[self.work.listed] = [
                {name: values[row] for name, values in self.listed.items() if name != "case"}
                for row in range(first, last)
            ]
        return record

    def _csv(self) -> str:
        parameters = [headed(self.model.parameter(name)) for name in self.cases.names]
        heads = [headed(item) for item in self.quantities]
        text = io.StringIO()
        sheet = csv.writer(text, lineterminator="\n")
        sheet.writerow(["case", *parameters, *heads, "failed"])
        for number in range(len(self)):
            found = [self.values[item.name][number] for item in self.quantities]
            given = self.case(number).values()
            sheet.writerow([number, *map(_cell, (*given, *found)), self.reasons[number]])
        return text.getvalue()

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
        # Files that are older than a quantity do not have it.
        values = {
            item.name: columns[item.name].ravel().astype(_type(item))
            if item.name in columns
            else _empty(item, total(cases))
            for item in work.quantities(model)
        }
        listed = {}
        if f"case_of_{work.listed}" in columns:
            listed["case"] = columns[f"case_of_{work.listed}"]
            for item in work.lists(model):
                listed[item.name] = columns[f"{work.listed}_{item.name}"].astype(_type(item))
        reasons = columns["failed"].ravel().astype(object)
        stopped = bool(saved.given.get("stopped", False))
        return cls(model, work, cases, values, listed, reasons, saved.provenance, stopped)


def study_result(
    plan: Plan, records: Iterable[Record], origin: Provenance, stopped: bool = False
) -> StudyResult:
    """Put the finished cases together, in the order of their numbers."""
    count = total(plan.cases)
    quantities = plan.work.quantities(plan.model)
    described = plan.work.lists(plan.model)
    values = {item.name: _empty(item, count) for item in quantities}
    listed: dict[str, list[Any]] = {item.name: [] for item in described}
    owners: list[int] = []
    reasons = np.full(count, NOT_REACHED, object)
    for record in records:
        number = record["case"]
        reasons[number] = record.get("failed", "")
        for name, value in record.get("found", {}).items():
            if value is not None:
                values[name][number] = value
        for each in record.get("listed", ()):
            owners.append(number)
            for item in described:
                value = each[item.name]
                listed[item.name].append(KINDS[item.kind].missing if value is None else value)
    table: dict[str, NDArray[Any]] = {}
    if described:
        table = {"case": np.array(owners, np.int64)}
        table |= {item.name: np.array(listed[item.name], _type(item)) for item in described}
    return StudyResult(plan.model, plan.work, plan.cases, values, table, reasons, origin, stopped)


def _cases_of(record: Mapping[str, Any]) -> Cases:
    """Return cases as a record describes them; the rows of a sample stand elsewhere."""
    if "grid" in record:
        return Grid({name: np.array(values) for name, values in record["grid"].items()})
    if "list" in record:
        names = tuple(record["list"])
        return Rows(names, np.array([record["list"][name] for name in names]).T)
    return Rows(tuple(record["scatter"]), np.empty((0, 0)), record)


def _type(item: Quantity) -> Any:
    """Return the type of an array; words are objects, which share what is said often."""
    return object if item.kind == "text" else KINDS[item.kind].type


def _empty(item: Quantity, count: int) -> NDArray[Any]:
    return np.full(count, KINDS[item.kind].missing, _type(item))


def _column(item: Quantity) -> Column:
    unit = None if item.kind == "text" else item.unit
    return Column(item.name, KINDS[item.kind], item.meaning, unit)


def _cell(value: Any) -> Any:
    """Return what a cell of a spreadsheet holds: every digit of a number, nothing for NaN."""
    if isinstance(value, float):
        return "" if value != value else repr(float(value))
    return value
