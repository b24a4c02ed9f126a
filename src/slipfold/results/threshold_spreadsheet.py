"""Maps of thresholds as comma-separated values."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from slipfold.results.csv_text import complex_parts, csv_text, multiplier_heads, with_unit

if TYPE_CHECKING:
    from slipfold.results.threshold_map import ThresholdMap

__all__ = ["threshold_csv"]


def threshold_csv(found: ThresholdMap) -> str:
    """Return all points of the grid, the second parameter varying faster."""
    model = found.model
    heads = [with_unit(model.parameter(name)) for name in (*found.axes, found.threshold)]
    heads += [with_unit(item) for item in model.states] + multiplier_heads(model)
    return csv_text([*heads, "residual", "no threshold", "reason", "followed"], _rows(found))


def _rows(found: ThresholdMap) -> Iterator[list[Any]]:
    first, second = found.over.values()
    for at in np.ndindex(found.values.shape):
        results = [float(found.values[at]), *found.states[at].tolist()]
        results += [*complex_parts(found.multipliers[at]), float(found.residuals[at])]
        row: list[Any] = [float(first[at[0]]), float(second[at[1]])]
        row += ["" if np.isnan(value) else value for value in results]
        yield [*row, str(found.kinds[at]), found.reasons[at], int(found.followed[at])]
