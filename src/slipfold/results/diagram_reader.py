"""A diagram made again from its labelled arrays."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.branch import Branch, End
from slipfold.branches.event import Event
from slipfold.branches.settings import Newton, Settings, Steps
from slipfold.branches.special_point import SpecialPoint
from slipfold.models.model import Model
from slipfold.models.registry import model_named
from slipfold.orbits.extrema import Extrema
from slipfold.results.diagram import Diagram
from slipfold.results.labelled_table import LabelledTable
from slipfold.results.provenance import Provenance

__all__ = ["read_diagram", "read_model", "read_provenance"]

Columns = Mapping[str, NDArray[Any]]


def read_diagram(table: LabelledTable, kind: type[Model] | None = None) -> Diagram:
    """Make a diagram from the arrays that `diagram_table` made of one.

    Parameters
    ----------
    table
        The arrays.
    kind
        The class of the model, if it is not a built-in one.

    Raises
    ------
    InputError
        If the model is unknown.
    LookupError, TypeError, ValueError
        If something is missing or does not fit.
    """
    given = json.loads(table.attributes["input"])
    model = read_model(given, kind)
    vary = str(given["vary"])
    model.parameter(vary)
    columns = {name: item.values for name, item in table.variables.items()}
    points = _rows(table, "point", columns["branch_of_point"])
    special = _rows(table, "special", columns["branch_of_special"])
    branches = tuple(
        _branch(model, vary, columns, row, points[identity], special[identity])
        for row, identity in enumerate(columns["branch"].tolist())
    )
    first, last = given["span"]
    return Diagram(
        model,
        vary,
        (float(first), float(last)),
        branches,
        _settings(given["settings"]),
        tuple(Event(**event) for event in given["events"]),
        read_provenance(table.attributes),
    )


def read_model(given: Mapping[str, Any], kind: type[Model] | None = None) -> Model:
    """Make the model that a result was computed with.

    Parameters
    ----------
    given
        Its input: ``"model"``, the name, and ``"parameters"``.
    kind
        The class of the model, if it is not a built-in one.

    Raises
    ------
    InputError
        If the model is unknown or a parameter does not fit it.
    """
    if kind is not None:
        return kind(**given["parameters"])
    return model_named(str(given["model"]), **given["parameters"])


def read_provenance(attributes: Mapping[str, Any]) -> Provenance:
    """Return where a result comes from.

    Parameters
    ----------
    attributes
        Attributes of the file.
    """
    return Provenance(
        slipfold=str(attributes["slipfold_version"]),
        heyoka=str(attributes["heyoka_version"]),
        numpy=str(attributes["numpy_version"]),
        python=str(attributes["python_version"]),
        computed=str(attributes["computed"]),
        seconds=float(attributes["seconds"]),
    )


def _settings(given: Mapping[str, Any]) -> Settings:
    rest = {key: value for key, value in given.items() if key not in ("newton", "steps")}
    return Settings(newton=Newton(**given["newton"]), steps=Steps(**given["steps"]), **rest)


class _Rows(dict[int, NDArray[np.int64]]):
    """Row numbers by branch; a branch without rows has none."""

    def __missing__(self, key: int) -> NDArray[np.int64]:
        return np.empty(0, np.int64)


def _rows(table: LabelledTable, dimension: str, owners: NDArray[np.int64]) -> _Rows:
    for name, item in table.variables.items():
        if item.dimensions[0] == dimension and len(item.values) != len(owners):
            raise ValueError(f"{name} has {len(item.values)} rows, not {len(owners)}")
    return _Rows({int(key): np.flatnonzero(owners == key) for key in np.unique(owners)})


def _branch(
    model: Model,
    vary: str,
    columns: Columns,
    row: int,
    points: NDArray[np.int64],
    special: NDArray[np.int64],
) -> Branch:
    branch = Branch(
        id=int(columns["branch"][row]),
        kind=str(columns["branch_kind"][row]),
        period=int(columns["branch_period"][row]),
        parent=int(columns["branch_parent"][row]) or None,
        model=model,
        vary=vary,
        parameter=columns["parameter"][points],
        nodes=columns["nodes"][points, : int(columns["node_count"][row])],
        multipliers=_complex(columns, "multipliers", points),
        residual=columns["residual"][points],
        arclength=columns["arclength"][points],
        special=tuple(_special(model, vary, columns, int(each)) for each in special),
        stopped=_end(columns, "stopped", row),
        begun=_end(columns, "begun", row),
    )
    # What the branch would compute when asked is in the file already.
    names = tuple(columns["output"].tolist())
    vars(branch)["extrema"] = Extrema(names, columns["minimum"][points], columns["maximum"][points])
    vars(branch)["multiplier_uncertainty"] = columns["multiplier_uncertainty"][points]
    return branch


def _special(model: Model, vary: str, columns: Columns, row: int) -> SpecialPoint:
    value = float(columns["special_value"][row])
    coefficient = float(columns["special_coefficient"][row])
    return SpecialPoint(
        type=str(columns["special_type"][row]),
        name=str(columns["special_name"][row]),
        model=model.replace(**{vary: value}),
        vary=vary,
        value=value,
        uncertainty=float(columns["special_uncertainty"][row]),
        period=int(columns["special_period"][row]),
        nodes=columns["special_nodes"][row, : int(columns["special_node_count"][row])],
        multipliers=_complex(columns, "special_multipliers", row),
        multiplier_uncertainty=columns["special_multiplier_uncertainty"][row],
        residual=float(columns["special_residual"][row]),
        arclength=float(columns["special_arclength"][row]),
        criticality=str(columns["special_criticality"][row]) or None,
        coefficient=None if np.isnan(coefficient) else coefficient,
        leads_to=int(columns["special_leads_to"][row]) or None,
    )


def _complex(columns: Columns, name: str, rows: Any) -> NDArray[np.complex128]:
    real, imag = columns[f"{name}_real"][rows], columns[f"{name}_imag"][rows]
    values = np.empty(real.shape, complex)
    values.real, values.imag = real, imag  # exact, also where a part is not finite
    return values


def _end(columns: Columns, which: str, row: int) -> End:
    return End(
        str(columns[f"{which}_kind"][row]),
        str(columns[f"{which}_reason"][row]),
        float(columns[f"{which}_value"][row]),
    )
