"""Maps of thresholds as labelled arrays: the schema slipfold.threshold_map/1 of netCDF files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.models.parameter import Parameter
from slipfold.results.attributes import result_attributes
from slipfold.results.columns import Columns, state_labels
from slipfold.results.labelled_table import LabelledTable, Variable

if TYPE_CHECKING:
    from slipfold.results.threshold_map import ThresholdMap

__all__ = ["SCHEMA", "column_name", "threshold_table"]

SCHEMA = "slipfold.threshold_map/1"

TAKEN = {
    "state", "state_units", "state_long_name", "states", "multiplier", "multipliers_real",
    "multipliers_imag", "residual", "kind", "reason", "followed",
}  # fmt: skip
"""Names that a parameter of the same name must not take from a column or a dimension."""


def column_name(parameter: str) -> str:
    """Return the name of the column of a parameter.

    Examples
    --------
    >>> column_name("Nd"), column_name("state")
    ('Nd', 'state_value')
    """
    return f"{parameter}_value" if parameter in TAKEN else parameter


def threshold_table(found: ThresholdMap) -> LabelledTable:
    """Return all numbers of a map with their names, units and meanings."""
    model = found.model
    labels = state_labels(model)
    for name, values in found.over.items():
        labels |= _named(column_name(name), model.parameter(name), values)
    first, second = found.axes
    title = f"first {found.type} of {model.name} in {found.threshold} over {first} and {second}"
    attributes = {
        "threshold": found.threshold,
        "type": found.type,
        "over": f"{first} {second}",
        "span": np.array(found.span, dtype=float),
        **result_attributes(SCHEMA, title, model, _input(found), found.provenance),
    }
    return LabelledTable(labels | _results(found), tuple(labels), attributes)


def _results(found: ThresholdMap) -> dict[str, Variable]:
    first, second = map(column_name, found.axes)
    columns = Columns(first)
    parameter = found.model.parameter(found.threshold)
    about = parameter.doc or parameter.name
    columns.add(column_name(parameter.name), found.values, about, parameter.unit, second)
    columns.add("kind", found.kinds, "why there is no threshold, in a few words", None, second)
    columns.add("reason", found.reasons.astype(str), "why there is no threshold", None, second)
    about = "whether the whole response was followed here"
    columns.add("followed", found.followed, about, None, second)
    about = "how far the orbit fails to close, in scaled states"
    columns.add("residual", found.residuals, about, "", second)
    columns.add("states", found.states, "state at phase zero", None, second, "state")
    about = "Floquet multipliers"
    columns.add("multipliers", found.multipliers, about, "", second, "multiplier")
    return columns.variables


def _named(name: str, parameter: Parameter, values: NDArray[np.float64]) -> dict[str, Variable]:
    columns = Columns(name)
    columns.add(name, values, parameter.doc or parameter.name, parameter.unit)
    return columns.variables


def _input(found: ThresholdMap) -> dict[str, Any]:
    return {
        "threshold": found.threshold,
        "type": found.type,
        "over": {name: values.tolist() for name, values in found.over.items()},
        "span": list(found.span),
    }
