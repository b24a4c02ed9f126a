"""A measured response as plain data."""

from __future__ import annotations

from typing import Any

from slipfold.explorer.views.numbers import number
from slipfold.measured.measurement import Measurement


def readings_view(measurement: Measurement) -> dict[str, Any]:
    """Return readings by quantity, SI units; None where nothing was read, or no error is known."""
    return {
        "vary": measurement.vary,
        "values": measurement.values.tolist(),
        "sweep": list(measurement.sweep),
        "quantities": [
            {
                "show": item.output,
                "statistic": item.measure,
                "readings": [number(value) for value in measurement.readings[:, k]],
                "errors": [number(value) for value in measurement.errors[:, k]],
            }
            for k, item in enumerate(measurement.quantities)
        ],
    }
