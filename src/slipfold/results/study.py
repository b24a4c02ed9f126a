"""The result of a study: one labelled dataset of all its cases."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Annotated, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipfold.arrays import Array
from slipfold.design_space.sobol_indices import SALTELLI, SobolIndices, indices_of
from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.results.fields import REAL, TEXT, WHOLE, Column, meaning_of
from slipfold.results.gathered import KINDS, Gathered, type_of
from slipfold.results.records import Provenance, SavedTable
from slipfold.results.result import Result
from slipfold.results.tables import Frame, Variable
from slipfold.studies.plan import Cases, Grid, Plan, Rows, total
from slipfold.studies.store import Record
from slipfold.studies.works import WORK, Quantity, Work
from slipfold.text.one_line import headed, listed
from slipfold.text.printed_table import PrintedTable


class Deferred(Mapping[str, Variable]):
    """Variables by name, each made anew whenever it is looked at."""

    def __init__(self) -> None:
        self._made: dict[str, Callable[[], Variable]] = {}

    def add(
        self,
        name: str,
        column: Column,
        dimensions: tuple[str, ...],
        values: Callable[[], NDArray[Any]],
    ) -> None:
        """Take note of a variable, and of how to come by its values."""
        self._made[name] = lambda: column.variables(name, dimensions, values())[name]

    def __getitem__(self, name: str) -> Variable:
        return self._made[name]()

    def __iter__(self) -> Iterator[str]:
        return iter(self._made)

    def __len__(self) -> int:
        return len(self._made)


SHARES = "indices are shares of a variance, and"

CONSTANT = 1e-12
"""Deviation over size of what is the same in all cases but for rounding."""


class Found(Protocol):
    """What a study found, as far as indices want to know."""

    @property
    def cases(self) -> Cases:
        """The cases."""

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """What was found of each."""

    @property
    def values(self) -> Mapping[str, NDArray[Any]]:
        """That by name, a value a case."""

    @property
    def reasons(self) -> NDArray[np.object_]:
        """Why cases failed; empty where they did not."""


def are_told(found: Found) -> bool:
    """Whether cases were drawn so that indices can be told of them."""
    cases = found.cases
    return isinstance(cases, Rows) and (cases.drawn or {}).get("sample") == SALTELLI


def indices_in(found: Found, quantity: str | ArrayLike) -> SobolIndices:
    """Return the indices of a quantity by name, or of a number for each case."""
    if not are_told(found):
        raise InputError(
            f'cases of this study were not drawn for indices; give cases with sample = "{SALTELLI}"'
        )
    if isinstance(quantity, str):
        name, values = quantity, _named(found, quantity)
    else:
        name, values = "the quantity", _given(found, quantity)
    lack = _lack(found, values)
    if lack:
        raise InputError(f"{SHARES} {name} is {lack}")
    if _is_constant(values):
        raise InputError(f"{name} is the same in all cases, so nothing accounts for its variance")
    return _told(found, values)


def _named(found: Found, name: str) -> Array:
    """Return a number that was found, NaN where there is none."""
    items = {item.name: item for item in found.quantities if item.kind != "text"}
    if name not in items:
        raise InputError(f"the study has no number {name!r}; it has {', '.join(items)}")
    values = np.asarray(found.values[name], dtype=float)
    lacking = (found.reasons != "") | (values == items[name].none)
    return np.where(lacking, np.nan, values)


def _given(found: Found, quantity: ArrayLike) -> Array:
    """Return numbers of one's own, NaN where there are none."""
    shape = found.reasons.shape
    try:
        values = np.asarray(quantity)
    except ValueError:  # rows of different lengths
        values = np.empty(0, object)
    if values.dtype.kind not in "biuf" or values.shape != shape:
        what = "words or the like" if values.dtype.kind not in "biuf" else f"shape {values.shape}"
        raise InputError(
            f"the quantity is an array of {what}; give a number for each of the {shape[0]} cases, "
            "or a name"
        )
    return np.where(found.reasons != "", np.nan, values.astype(float))


def _lack(found: Found, values: Array) -> str:
    """Say of how many cases numbers are missing, and why of the first; empty if of none."""
    lost = np.flatnonzero(~np.isfinite(values))
    if not len(lost):
        return ""
    why = str(found.reasons[lost[0]] or found.values.get("reason", {lost[0]: ""})[lost[0]])
    return f"missing in {len(lost)} of {len(values)} cases{'; first: ' if why else ''}{why}"


def _is_constant(values: Array) -> bool:
    return not np.ptp(values) > CONSTANT * np.abs(values).max()


def _told(found: Found, values: Array) -> SobolIndices:
    assert isinstance(found.cases, Rows)
    return indices_of(values, found.cases.names, int((found.cases.drawn or {})["seed"]))


def index_records(found: Found) -> dict[str, Any]:
    """Return the indices of all numbers that differ from case to case, counts aside."""
    return {
        name: {
            parameter: {
                key: float(getattr(item, key)[place])
                for key in ("first", "total", "first_error", "total_error")
            }
            for place, parameter in enumerate(item.names)
        }
        for name, item in _all(found)[0].items()
    }


def index_tables(found: Found) -> list[PrintedTable | list[str]]:
    """Return a table of the indices, and why some are not told."""
    known, missing = _all(found)
    heads = ["index, first and total", *found.cases.names]
    rows = [[name, *_cells(item)] for name, item in known.items()]
    return [*([PrintedTable(heads, rows, heads[:1])] if known else []), missing]


def _cells(item: SobolIndices) -> Iterator[str]:
    for part in zip(item.first, item.first_error, item.total, item.total_error, strict=True):
        yield "{:.2f} +- {:.2f}, {:.2f} +- {:.2f}".format(*part)


def _all(found: Found) -> tuple[Mapping[str, SobolIndices], list[str]]:
    """Return the indices of all numbers but those that count, and why others have none."""
    known, missing = dict[str, SobolIndices](), dict[str, list[str]]()
    for item in found.quantities if are_told(found) else ():
        if item.kind != "real" or not np.isfinite(found.values[item.name]).any():
            continue
        values = _named(found, item.name)
        lack = _lack(found, values)
        if lack:
            missing.setdefault(f"{SHARES} numbers are {lack}", []).append(item.name)
        elif not _is_constant(values):
            try:
                known[item.name] = _told(found, values)
            except InputError as error:
                missing.setdefault(str(error), []).append(item.name)
    return known, [f"no indices of {', '.join(names)}: {why}" for why, names in missing.items()]


OWNER = Quantity(
    "case", "whole", "number of its case, from 0, the last parameter of a grid changing first"
)

NOT_REACHED = "not computed yet"


@dataclass(frozen=True, eq=False, repr=False)
class StudyResult(Result):
    """What was found of every case of a study; frozen.

    Made by `slipfold.study` and `slipfold.load`.

    Notes
    -----
    The dataset of `to_xarray` lies along the parameters of a grid, which label it, so that
    ``dataset.threshold.sel(Vd=0.6)`` is a threshold; along ``case`` if the cases were listed or
    drawn. Special points of all cases lie along ``special``, with ``case_of_special``, and
    attractors along ``attractor``. In the spreadsheet of `to_csv` a case is a row. In `to_json`,
    schema slipfold.study/1, cases and failures. `plot` draws a quantity: over one parameter as a
    line, over two as a map, over up to four as many maps.

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
    work: Annotated[Work, "What was computed of every case."]
    cases: Annotated[Cases, "The cases."]
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

    def _line(self) -> str:
        missing = len(self.failures)
        failed = f", {missing} failed" if missing else ""
        size = f"{self.done} of {len(self)}" if self.interrupted else f"{len(self)}"
        return f"{self._title()}, {size} cases{failed}"

    def _sections(self) -> list[PrintedTable | list[str]]:
        return [self._rows(), *index_tables(self), self._notes()]

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
