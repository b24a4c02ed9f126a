"""What summaries share: which parameters were set, and which points are uncertain."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence

from slipfold.models.model import Model
from slipfold.models.parameter import Parameter
from slipfold.text.one_line import parameter_text
from slipfold.text.printed_table import with_unit

UNCERTAIN = 1e-6
"""Share of the span from which on the uncertainty of a point is told: points are located to 1e-12,
and in a figure this cannot be seen."""


def without_defaults(model: Model, varied: Collection[str]) -> str:
    """Return the parameters that were set, as the end of a title: nothing if none was.

    The duration of a cycle is found, not set.
    """
    values = ", ".join(
        with_unit(f"{item.name} = {model.values[item.name]:.6g}", item.unit)
        for item in model.variable_parameters
        if item.name not in varied and model.values[item.name] != item.default
    )
    return f"; {values}" if values else ""


def uncertain_point(
    name: str,
    parameters: Sequence[Parameter],
    values: Sequence[float],
    uncertainty: Sequence[float],
    spans: Sequence[tuple[float, float]],
) -> Iterator[str]:
    """Yield a sentence if a special point is less certain than it should be."""
    widths = [abs(last - first) for first, last in spans]
    if all(u <= UNCERTAIN * width for u, width in zip(uncertainty, widths, strict=True)):
        return
    place = ", ".join(parameter_text(item, v) for item, v in zip(parameters, values, strict=True))
    if any(map(math.isnan, uncertainty)):
        yield f"{name} at {place}: interrupted before it was computed how certain it is."
    elif all(map(math.isfinite, uncertainty)):
        amounts = [
            with_unit(f"{amount:.0e}", item.unit)
            for item, amount in zip(parameters, uncertainty, strict=True)
        ]
        yield f"{name} at {place} is uncertain by {' and '.join(amounts)}."
    else:
        yield f"{name} at {place}: how certain it is could not be computed."
