"""What a reading is of: an output, and what of it over a period."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.models.suggestion import unknown
from slipfold.orbits.extrema import Extrema

MEASURES = ("max", "min", "peak_to_peak", "modulus")
"""What of an output is measured over a period, as diagrams draw it."""


@dataclass(frozen=True)
class Quantity:
    """What is measured of an output over a period of the response.

    Parameters
    ----------
    measure
        ``"max"``, ``"min"``, ``"peak_to_peak"`` or ``"modulus"``, the largest absolute value.
    output
        A state or output of the model.
    unit
        Its unit.
    """

    measure: str
    output: str
    unit: str

    def __str__(self) -> str:
        """Return it as columns are headed, without its unit."""
        return f"{self.measure} {self.output}"


def headed_quantities(quantities: Sequence[Quantity]) -> list[str]:
    """Return the heads of columns, with units, e.g. ``"max y (mm)"``."""
    return [f"{item} ({item.unit})" if item.unit else str(item) for item in quantities]


def parse_measured(text: str, model: Model) -> Quantity:
    """Read ``MEASURE OUTPUT``.

    >>> from slipfold.models import SlidingOscillator
    >>> parse_measured("max y", SlidingOscillator())
    Quantity(measure='max', output='y', unit='')
    """
    measure, _, output = (part.strip() for part in text.strip().partition(" "))
    if measure not in MEASURES or not output:
        raise InputError(
            f"{text!r} does not say what is measured; write one of {', '.join(MEASURES)} and an "
            f"output, e.g. 'max {model.states[0].name}'"
        )
    units = {item.name: item.unit for item in model.states}
    units |= {item.name: item.unit for item in model.outputs()}
    if output not in units:
        raise unknown(f"{model.name} has no output", output, units)
    return Quantity(measure, output, units[output])


def read_off(extrema: Extrema, quantities: Sequence[Quantity]) -> NDArray[np.float64]:
    """Return what is measured of each orbit, shape (n_orbits, n_quantities)."""
    columns = [_read(extrema, item) for item in quantities]
    return np.column_stack(columns)


def _read(extrema: Extrema, quantity: Quantity) -> NDArray[np.float64]:
    low, high = extrema.of(quantity.output)
    if quantity.measure in ("min", "max"):
        return low if quantity.measure == "min" else high
    whole = extrema.peak_to_peak if quantity.measure == "peak_to_peak" else extrema.modulus
    return whole(quantity.output)
