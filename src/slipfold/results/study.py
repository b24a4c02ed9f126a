"""The result of a study: one labeled dataset of all its cases."""

from __future__ import annotations

import sys
from array import array
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipfold.arrays import Array
from slipfold.errors import InputError, unknown
from slipfold.models.model import Model
from slipfold.models.quantities import Parameter, State
from slipfold.parameter_space.sampling import SALTELLI, SobolIndices, indices_of
from slipfold.results.fields import REAL, TEXT, WHOLE, Column, Labels
from slipfold.results.records import Provenance, SavedTable
from slipfold.results.result import Result
from slipfold.results.tables import Frame, Variable
from slipfold.studies.plan import Grid, Plan, Rows, StudyCases, total
from slipfold.studies.store import Record
from slipfold.studies.works import WORK, CaseField, Work
from slipfold.text import PrintedTable, headed, listed

KINDS = {"real": REAL, "whole": WHOLE, "text": TEXT}
"""Types of values by the kinds of fields of cases."""

CONSTANT = 1e-12
"""Deviation over size of what is the same in all cases but for rounding."""

OWNER = CaseField(
    "case", "whole", "number of its case, from 0, the last parameter of a grid changing first"
)

NOT_REACHED = "not computed yet"

CaseNumber = Annotated[int, "Number of the case, from 0."]


@dataclass(frozen=True, eq=False, repr=False)
class StudyResult(Result):
    """The results of every case of a study; frozen.

    Made by `slipfold.study` and `slipfold.load`.

    Notes
    -----
    The dataset of `to_xarray` lies along the parameters of a grid, which label it, so that
    ``dataset.threshold.sel(Vd=0.6)`` is a threshold, or along ``case``; special points of all cases
    along ``special``, attractors along ``attractor``. `plot` draws a quantity: over one parameter
    as a line, over two as a map, over up to four as many maps.
    """

    schema = "slipfold.study/1"
    row = "a case"

    model: Model
    work: Annotated[Work, "What was computed of every case."]
    cases: Annotated[StudyCases, "The cases."]
    values: Annotated[
        Mapping[str, NDArray[Any]],
        "What was found, by the name of the quantity, each of shape (n_cases,). A missing number "
        "is NaN, or 0 if it counts something.",
    ]
    listed: Annotated[
        Mapping[str, NDArray[Any]],
        "All special points, or attractors, by the name of what is said of them, case after case; "
        "``case`` is the number of the case, from 0. Empty if cases have neither.",
    ]
    reasons: Annotated[
        NDArray[np.object_], "Why there is nothing of a case; empty where there is something."
    ]
    provenance: Annotated[
        Provenance, "Versions; a study may be interrupted and resumed, so there is no time."
    ]
    stopped: Annotated[
        bool, "Whether it was stopped before all was computed or failed cases were tried again."
    ] = False
    damaged: Annotated[
        int, "How many damaged lines the store had, of cases that were computed again; not saved."
    ] = 0

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

    def case(self, number: CaseNumber) -> dict[str, float]:
        """Return the values of the parameters of a case by name."""
        (row,) = self.cases.values(np.array([number])).tolist()
        return dict(zip(self.cases.names, row, strict=True))

    def model_at(self, number: CaseNumber) -> Model:
        """Return the model of a case."""
        return self.model.replace(**self.case(number))

    @cached_property
    def quantities(self) -> tuple[CaseField, ...]:
        """What was found of every case: name, kind, meaning and unit."""
        return self.work.quantities(self.model)

    def indices(self, quantity: str | ArrayLike) -> SobolIndices:
        """Return which fractions of the variance of a quantity the parameters account for.

        Parameters
        ----------
        quantity
            The name of a number that was found, or a number for each case, shape (n_cases,).

        Raises
        ------
        InputError
            If cases were not drawn by ``sample = "saltelli"``, a case has no such number (a period
            of 0 is none), or what is given is not a number for each case.

        Examples
        --------
        >>> import slipfold as sf
        >>> distributions = {"mu": "normal 2%", "Vd": "normal 2%"}
        >>> found = sf.study({
        ...     "model": "sliding",
        ...     "parameters": {"f": 12.5, "Nd": 0.02},
        ...     "compute": {"what": "simulation"},
        ...     "cases": {"sample": "saltelli", "count": 4, "distributions": distributions},
        ... })
        >>> len(found), found.indices("max_x").names
        (16, ('mu', 'Vd'))
        """
        if self._seed is None:
            raise InputError(
                "cases of this study were not drawn for indices; give cases with "
                f'sample = "{SALTELLI}"'
            )
        if isinstance(quantity, str):
            name, values = quantity, self._number(quantity)
        else:
            name, values = "the quantity", self._own_numbers(quantity)
        return self._indices(name, values, self._seed)

    @property
    def _seed(self) -> int | None:
        """Seed of cases that were drawn for indices, None of others."""
        drawn = (isinstance(self.cases, Rows) and self.cases.drawn) or {}
        return int(drawn["seed"]) if drawn.get("sample") == SALTELLI else None

    def _number(self, name: str) -> Array:
        """Return a number that was found, NaN where there is none."""
        items = {item.name: item for item in self.quantities if item.kind != "text"}
        if name not in items:
            raise unknown("the study has no number", name, items)
        values = np.asarray(self.values[name], dtype=float)
        missing = (self.reasons != "") | (values == items[name].none)
        return np.where(missing, np.nan, values)

    def _own_numbers(self, quantity: ArrayLike) -> Array:
        """Return numbers of the caller, NaN where a case failed."""
        shape = self.reasons.shape
        try:
            values = np.asarray(quantity)
        except ValueError:  # rows of different lengths
            values = np.empty(0, object)
        numbers = values.dtype.kind in "biuf"
        if not numbers or values.shape != shape:
            what = f"shape {values.shape}" if numbers else "words or the like"
            raise InputError(
                f"the quantity is an array of {what}; give a number for each of the {shape[0]} "
                "cases, or a name"
            )
        return np.where(self.reasons != "", np.nan, values.astype(float))

    def _indices(self, name: str, values: Array, seed: int) -> SobolIndices:
        missing = np.flatnonzero(~np.isfinite(values))
        if len(missing):
            first = missing[0]
            why = str(self.reasons[first] or self.values.get("reason", {first: ""})[first])
            raise InputError(
                f"indices are fractions of a variance, and {name} is missing in {len(missing)} of "
                f"{len(values)} cases{'; first: ' if why else ''}{why}"
            )
        if not np.ptp(values) > CONSTANT * np.abs(values).max():
            raise InputError(f"{name} is the same in all cases, so nothing explains its variance")
        return indices_of(values, self.cases.names, seed)

    @cached_property
    def _all_indices(self) -> tuple[Mapping[str, SobolIndices], list[str]]:
        """Indices of all numbers but those that count, and why others have none."""
        known, why = dict[str, SobolIndices](), dict[str, list[str]]()
        for item in self.quantities if self._seed is not None else ():
            if item.kind == "real" and np.isfinite(self.values[item.name]).any():
                values = self._number(item.name)
                if np.ptp(values) <= CONSTANT * np.abs(values).max():
                    continue
                try:
                    known[item.name] = self._indices("the number", values, self._seed or 0)
                except InputError as error:
                    why.setdefault(str(error), []).append(item.name)
        return known, [f"no indices of {', '.join(names)}: {text}" for text, names in why.items()]

    def _line(self) -> str:
        missing = len(self.failures)
        failed = f", {missing} failed" if missing else ""
        size = f"{self.done} of {len(self)}" if self.interrupted else f"{len(self)}"
        return f"{self._title()}, {size} cases{failed}"

    def _sections(self) -> list[PrintedTable | list[str]]:
        known, missing = self._all_indices
        heads = ["index, first and total", *self.cases.names]
        rows = [
            [name]
            + [
                "{:.2f} +- {:.2f}, {:.2f} +- {:.2f}".format(*part)
                for part in zip(
                    item.first, item.first_error, item.total, item.total_error, strict=True
                )
            ]
            for name, item in known.items()
        ]
        indices = [PrintedTable(heads, rows, heads[:1])] if known else []
        return [self._rows(), *indices, missing, self._notes()]

    def _rows(self) -> PrintedTable:
        rows = []
        whole = self.reasons == ""
        for item in self.quantities:
            values = self.values[item.name][whole]
            if item.kind == "text":
                counts = Counter(str(value) for value in values if value)
                said = listed(f"{count} {word}" for word, count in counts.most_common())
                rows += [[item.name, "", "", said]] if counts else []
                continue
            known = values[np.isfinite(values)] if item.kind == "real" else values
            ends = [f"{end:.9g}" for end in (known.min(), known.max())] if len(known) else ["", ""]
            rows.append([headed(item), *ends, f"{len(known)} cases"])
        return PrintedTable(["", "smallest", "largest", "found"], rows, ("", "found"))

    def _notes(self) -> list[str]:
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

    def _variable_name(self, item: Parameter | State) -> str:
        each, name = self.work.listed, item.name
        taken = {"case", each, "failed", *(one.name for one in self.quantities)}
        taken |= {f"{each}_{one.name}" for one in self.work.lists(self.model)}
        while name in taken:
            name += "_value"
        return name

    @property
    def _given_values(self) -> dict[str, Array]:
        """Values of the parameters: along the axes of a grid, else of each case."""
        if isinstance(self.cases, Grid):
            return dict(self.cases.axes)
        columns = np.ascontiguousarray(self.cases.values(np.arange(len(self))).T)
        return dict(zip(self.cases.names, columns, strict=True))

    def _variables(self) -> Mapping[str, Variable]:
        grid = isinstance(self.cases, Grid)
        result = Labels(None if grid else "case").variables(self, "_given_values")
        along = tuple(result) if grid else ("case",)
        shape, each = self.cases.shape, self.work.listed
        for quantity in self.quantities:
            values = self.values[quantity.name].reshape(shape)
            result |= _column(quantity).variables(quantity.name, along, values)
        reasons = Column("failed", TEXT, "why there is nothing of this case")
        result |= reasons.variables("failed", along, self.reasons.reshape(shape))
        for described in [OWNER, *self.work.lists(self.model)] if self.listed else ():
            owner = described is OWNER
            name = f"case_of_{each}" if owner else f"{each}_{described.name}"
            column = replace(
                _column(described), label=owner, unit=None if owner else described.unit
            )
            result |= column.variables(name, (each,), self.listed[described.name])
        return result

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
            **({} if self._seed is None else {"indices": self._index_records()}),
        }

    def _index_records(self) -> dict[str, Any]:
        keys = ("first", "total", "first_error", "total_error")
        return {
            name: {
                parameter: {key: float(getattr(item, key)[index]) for key in keys}
                for index, parameter in enumerate(item.names)
            }
            for name, item in self._all_indices[0].items()
        }

    def _case_records(self) -> list[dict[str, Any]]:
        values, each = dict(self.values), dict(self.listed)
        owners = each.pop("case", None)
        records = []
        for number in range(len(self)):
            result = {item.name: values[item.name][number] for item in self.quantities}
            record = {"given": self.case(number), **result}
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
        names = [self._variable_name(item) for item in items]
        columns |= dict(zip(names, given, strict=True))
        columns |= {item.name: self.values[item.name] for item in self.quantities}
        units = {name: item.unit for name, item in zip(names, items, strict=True)}
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
            item.name: _stored(item, columns[item.name].ravel()) for item in work.quantities(model)
        }
        listed = {}
        if work.lists(model):
            listed["case"] = columns[f"case_of_{work.listed}"]
            for item in work.lists(model):
                listed[item.name] = _stored(item, columns[f"{work.listed}_{item.name}"])
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
    values = CaseColumns(plan.work.quantities(plan.model))
    listed = CaseColumns([OWNER, *described])
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
    result = values.arrays(), listed.arrays() if described else {}, reasons
    return StudyResult(plan.model, plan.work, plan.cases, *result, origin, stopped, damaged)


class CaseColumns:
    """Columns that grow row by row; values that a row lacks are missing.

    >>> table = CaseColumns([CaseField("x", "real", ""), CaseField("why", "text", "")])
    >>> table.add({"x": 1.5, "why": "limit"})
    >>> table.add({"why": "limit"})
    >>> {name: column.tolist() for name, column in table.arrays().items()}
    {'x': [1.5, nan], 'why': ['limit', 'limit']}
    """

    def __init__(self, items: Sequence[CaseField]) -> None:
        self._items = items
        codes = {"real": "d", "whole": "q"}
        self._values: dict[str, Any] = {
            item.name: array(codes[item.kind]) if item.kind in codes else [] for item in items
        }

    def add(self, row: Mapping[str, Any]) -> None:
        """Add a row at the end."""
        for item in self._items:
            value = row.get(item.name)
            value = KINDS[item.kind].missing if value is None else value
            self._values[item.name].append(sys.intern(value) if item.kind == "text" else value)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the columns."""
        return {item.name: _stored(item, self._values[item.name]) for item in self._items}


def _stored(item: CaseField, values: Any) -> NDArray[Any]:
    """Return a column as an array; texts are objects, which share repeated ones."""
    return np.asarray(values, object if item.kind == "text" else KINDS[item.kind].type)


def _cases_of(record: Mapping[str, Any]) -> StudyCases:
    """Return cases as a record describes them; the rows of a sample stand elsewhere."""
    if "grid" in record:
        return Grid({name: np.array(values) for name, values in record["grid"].items()})
    if "list" in record:
        names = tuple(record["list"])
        return Rows(names, np.array([record["list"][name] for name in names]).T)
    return Rows(tuple(record["distributions"]), np.empty((0, 0)), record)


def _column(item: CaseField) -> Column:
    unit = None if item.kind == "text" else item.unit
    return Column(item.name, KINDS[item.kind], item.meaning, unit)
