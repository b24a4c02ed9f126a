"""Maps of thresholds as plain data for JSON: the schema slipfold.threshold_map/1."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from slipfold.results.record import numbers, record_head
from slipfold.results.threshold_table import SCHEMA

if TYPE_CHECKING:
    from slipfold.results.threshold_map import ThresholdMap

__all__ = ["threshold_record"]


def threshold_record(found: ThresholdMap) -> dict[str, Any]:
    """Return the thresholds, a list for each value of the first parameter, and all failures."""
    return {
        **record_head(SCHEMA, found.model),
        "threshold": found.threshold,
        "type": found.type,
        "over": {name: numbers(values) for name, values in found.over.items()},
        "span": numbers(found.span),
        "interrupted": found.interrupted,
        "failures": found.failures,
        "values": [numbers(row) for row in found.values],
        "kinds": [[kind or None for kind in row] for row in found.kinds.tolist()],
        "reasons": [[reason or None for reason in row] for row in found.reasons.tolist()],
    }
