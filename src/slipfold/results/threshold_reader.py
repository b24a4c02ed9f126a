"""A map of thresholds made again from its labelled arrays."""

from __future__ import annotations

from types import MappingProxyType
from typing import Any

from numpy.typing import NDArray

from slipfold.results.saved_table import SavedTable
from slipfold.results.threshold_map import ThresholdMap
from slipfold.results.threshold_table import column_name

__all__ = ["read_threshold_map"]


def read_threshold_map(saved: SavedTable) -> ThresholdMap:
    """Make a map from the arrays that `threshold_table` made of one."""
    given, model = saved.given, saved.model
    threshold, first, second = (
        model.parameter(name).name for name in (given["threshold"], *given["over"])
    )
    over = {name: saved.columns[column_name(name)] for name in (first, second)}
    shape = tuple(len(values) for values in over.values())

    def checked(name: str, values: NDArray[Any], *more: int) -> NDArray[Any]:
        if values.shape != (*shape, *more):
            raise ValueError(f"{name} has the shape {values.shape}, not {(*shape, *more)}")
        return values

    def grid(name: str, *more: int) -> NDArray[Any]:
        return checked(name, saved.columns[name], *more)

    begin, end = given["span"]
    size = len(model.states)
    return ThresholdMap(
        model=model,
        threshold=threshold,
        type=str(given["type"]),
        over=MappingProxyType(over),
        span=(float(begin), float(end)),
        values=grid(column_name(threshold)),
        states=grid("states", size),
        multipliers=checked("multipliers", saved.complex("multipliers", ...), size),
        residuals=grid("residual"),
        kinds=grid("kind"),
        reasons=grid("reason").astype(object),
        followed=grid("followed"),
        provenance=saved.provenance,
    )
