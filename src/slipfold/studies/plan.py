"""The plan of a study, from a file or a mapping, checked before anything starts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from math import prod
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.models.definitions.source import Source, source_of_file
from slipfold.models.definitions.tables import check_keys, validated
from slipfold.models.model import Model
from slipfold.models.quantities import Parameter
from slipfold.models.registry import model_of_case
from slipfold.models.units import parse_quantity
from slipfold.parameter_space.distributions import parse_correlation, parse_distribution
from slipfold.parameter_space.sampling import SALTELLI, check_power, drawn, index_design
from slipfold.studies.works import WORK, Known, Work


@dataclass(frozen=True, eq=False)
class Grid:
    """All combinations of some values of each parameter; the last parameter changes first."""

    axes: Mapping[str, Array]

    @property
    def names(self) -> tuple[str, ...]:
        """Parameters that differ from case to case."""
        return tuple(self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """How many values each has."""
        return tuple(len(values) for values in self.axes.values())

    def values(self, numbers: Any) -> Array:
        """Return the values of some cases. Shapes: numbers (k,), from 0; returns (k, n_names)."""
        indices = np.unravel_index(numbers, self.shape)
        columns = [values[index] for values, index in zip(self.axes.values(), indices, strict=True)]
        return np.stack(columns, axis=-1)

    def record(self) -> dict[str, Any]:
        """Return them as plain data."""
        return {"grid": {name: values.tolist() for name, values in self.axes.items()}}


@dataclass(frozen=True, eq=False)
class Rows:
    """Cases that are listed, or were drawn at random."""

    names: tuple[str, ...]
    rows: Array  # shape (n_cases, n_names)
    drawn: Mapping[str, Any] | None = None  # how they were drawn; None if they were listed

    @property
    def shape(self) -> tuple[int, ...]:
        """How many there are."""
        return (len(self.rows),)

    def values(self, numbers: Any) -> Array:
        """Return the values of some cases."""
        return self.rows[numbers]

    def record(self) -> dict[str, Any]:
        """Return them as plain data."""
        if self.drawn is not None:
            return dict(self.drawn)
        columns = zip(self.names, self.rows.T.tolist(), strict=True)
        return {"list": dict(columns)}


StudyCases = Grid | Rows
"""Values of some parameters for every case."""


def digest(cases: StudyCases) -> str | None:
    """Return a digest of cases that were drawn; None of those that are given.

    Another version may draw other cases with the same seed; last digits differ between processors.
    """
    if not isinstance(cases, Rows) or cases.drawn is None:
        return None
    return sha256(cases.rows.astype("<f4").tobytes()).hexdigest()[:16]


def total(cases: StudyCases) -> int:
    """Return how many cases there are.

    >>> total(Grid({"Vd": np.array([0.5, 0.6]), "mu": np.array([0.4, 0.5, 0.6])}))
    6
    """
    return prod(cases.shape)


TABLES = ("compute", "cases")
"""Tables of a study that a case file does not have."""


@dataclass(frozen=True, eq=False)
class Plan:
    """The base model, the computation and the cases."""

    model: Model  # the base case
    work: Work
    cases: StudyCases


class _Steps(BaseModel):
    """Values of a grid from one to another."""

    model_config = ConfigDict(extra="forbid")

    first: float | str = Field(alias="from")
    last: float | str = Field(alias="to")
    count: int = Field(ge=1)
    spacing: Literal["linear", "logarithmic"] = "linear"


class _Given(BaseModel):
    """The table of cases."""

    model_config = ConfigDict(extra="forbid")

    grid: dict[str, Any] | None = None
    rows: list[dict[str, float | str]] | None = Field(None, alias="list")
    sample: Literal["latin hypercube", "sobol", "random", "saltelli"] | None = None
    count: int | None = Field(None, ge=1)
    seed: int = Field(0, ge=0)
    distributions: dict[str, Any] = Field(default_factory=dict)
    correlation: dict[str, float | str] = Field(default_factory=dict)


def read_plan(given: str | Path | Mapping[str, Any]) -> Plan:
    """Read and check what a study is to compute."""
    if isinstance(given, Mapping):
        return _plan(given, "the study", Path())
    if not isinstance(given, str | Path):
        raise InputError(f"{given!r} is not a study; give the name of its file, or a mapping")
    source = source_of_file(Path(given), "another file that holds a study")
    return _plan(source.tables, str(given), Path(given).parent)


def _plan(tables: Mapping[str, Any], label: str, folder: Path) -> Plan:
    missing = [name for name in TABLES if not isinstance(tables.get(name), Mapping)]
    if missing:
        raise InputError(
            f"{label} has no table [{missing[0]}]; a study has [compute], with e.g. "
            'what = "threshold", vary = "Nd", span = [0, 0.98], and [cases], with e.g. '
            "grid = {Vd = [0.5, 0.6]}"
        )
    model = _model(tables, label, folder)
    try:
        work = validated(_work, tables["compute"], "compute", "what").checked(model)
        cases = _cases(validated(_given, tables["cases"], "cases"), model)
        clash = [name for name in cases.names if name in work.varied()]
        if clash:
            raise InputError(
                f"{clash[0]} is varied by each case itself, so cases cannot differ in it; leave it "
                "out of cases"
            )
    except InputError as error:
        raise InputError(f"{label}: {error}") from None
    return Plan(model, work, cases)


def _work(given: Mapping[str, Any]) -> Work:
    for kind in get_args(Known):
        if given.get("what") in get_args(kind.model_fields["what"].annotation):
            check_keys(given, list(kind.model_fields), {})
    return WORK.validate_python(given)


def _given(given: Mapping[str, Any]) -> _Given:
    check_keys(given, [item.alias or name for name, item in _Given.model_fields.items()], {})
    return _Given.model_validate(given)


def _model(tables: Mapping[str, Any], label: str, folder: Path) -> Model:
    given = tables.get("model")
    if isinstance(given, Model):
        unknown = sorted(set(tables) - {"model", "parameters", *TABLES})
        if unknown:
            raise InputError(
                f"{label} has the entry {unknown[0]!r} next to a slipfold.Model, which has all "
                "of it but parameters; leave it out"
            )
        return given.replace(**tables.get("parameters", {}))
    return model_of_case(Source(tables, label), folder, {}, others=TABLES)


def _cases(given: _Given, model: Model) -> StudyCases:
    kinds = {"grid": given.grid, "list": given.rows, "sample": given.sample}
    chosen = [name for name, value in kinds.items() if value is not None]
    if len(chosen) != 1:
        raise InputError(
            f"cases has {' and '.join(chosen) or 'none of grid, list and sample'}; give one of "
            "grid, list and sample"
        )
    if given.sample is None and (
        given.distributions or given.correlation or given.count is not None
    ):
        raise InputError(
            f"cases.{chosen[0]} is not a sample; leave out distributions, correlation and count"
        )
    if given.grid is not None:
        return _grid(given.grid, model)
    if given.rows is not None:
        return _listed(given.rows, model)
    return _drawn(given, model)


def _grid(given: Mapping[str, Any], model: Model) -> Grid:
    if not given:
        raise InputError("cases.grid names no parameter; give e.g. grid = {Vd = [0.5, 0.6]}")
    axes = {}
    for name, values in given.items():
        parameter = model.variable_parameter(name)
        result = _axis(values, parameter, f"cases.grid.{name}")
        for value in result:
            parameter.check(value)
        if len(np.unique(result)) < len(result):
            raise InputError(f"cases.grid.{name} has a value twice; give each once")
        axes[name] = result
    return Grid(axes)


def _axis(given: Any, parameter: Parameter, entry: str) -> NDArray[np.float64]:
    if isinstance(given, Mapping):
        steps = validated(_Steps.model_validate, given, entry)
        first, last = (_number(end, parameter) for end in (steps.first, steps.last))
        if steps.spacing == "linear":
            return np.linspace(first, last, steps.count)
        if not first * last > 0:
            raise InputError(f"{entry} has logarithmic steps; give both ends above zero")
        return np.geomspace(first, last, steps.count)
    if not isinstance(given, list | tuple | np.ndarray) or not len(given):
        raise InputError(
            f"{entry} = {given!r} is not a list of values; give e.g. [0.5, 0.6] or "
            "{from = 0.5, to = 1, count = 6}"
        )
    return np.array([_number(value, parameter) for value in given])


def _listed(given: list[dict[str, float | str]], model: Model) -> Rows:
    names = tuple(given[0]) if given else ()
    if not names:
        raise InputError('cases.list holds no cases; give e.g. [{Vd = 0.5, alpha = "60deg"}]')
    for number, row in enumerate(given):
        if set(row) != set(names):
            raise InputError(
                f"cases.list.{number} gives {', '.join(row)}, the first case {', '.join(names)}; "
                "give the same parameters in each"
            )
    parameters = [model.variable_parameter(name) for name in names]
    rows = [[_number(row[item.name], item) for item in parameters] for row in given]
    return Rows(names, np.array(rows))


def _drawn(given: _Given, model: Model) -> Rows:
    assert given.sample is not None
    if given.count is None or not given.distributions:
        lacks = "count" if given.count is None else "distributions"
        raise InputError(
            f"cases.{lacks} is missing; a sample has e.g. count = 256 and "
            'distributions = {mu = "normal 5%"}'
        )
    distributions = [
        parse_distribution(
            item, model.variable_parameter(name), model.values[name], f"cases.distributions.{name}"
        )
        for name, item in given.distributions.items()
    ]
    matrix = parse_correlation(given.correlation, tuple(given.distributions))
    if given.sample == SALTELLI:
        if given.correlation:
            raise InputError(
                'sample = "saltelli" is of independent parameters; leave out '
                "cases.correlation, or take another sample"
            )
        check_power(given.count, "cases.count")
        rows = index_design(distributions, given.count, given.seed, "cases.count")
    else:
        rows = drawn(given.sample, given.count, given.seed, distributions, "cases.count", matrix)
    how = {"sample": given.sample, "count": given.count, "seed": given.seed}
    if given.correlation:
        how["correlation"] = matrix.tolist()
    uncertain = {item.name: item.record() for item in distributions}
    return Rows(tuple(given.distributions), rows, {**how, "distributions": uncertain})


def _number(given: Any, parameter: Parameter) -> float:
    return parse_quantity(given, parameter.unit, parameter.name)
