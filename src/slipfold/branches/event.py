"""Values a user wants located on a branch."""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Real

from slipfold.errors import InputError

MEASURES = ("max", "min", "peak_to_peak", "parameter")


@dataclass(frozen=True)
class Event:
    """A value of an output or of the parameter that is to be found on the branch.

    Parameters
    ----------
    name
        Name of the event in results: a state or output, or the parameter that is varied.
    value
        The value to be found, in its unit.
    measure
        ``"max"``, ``"min"`` or ``"peak_to_peak"`` of the output over the orbit, or
        ``"parameter"`` for a value of the parameter itself.
    stop
        Whether the branch ends there.

    Raises
    ------
    InputError
        For an unknown measure.

    Examples
    --------
    >>> Event("x", 0.3)
    Event(name='x', value=0.3, measure='max', stop=False)
    """

    name: str
    value: float
    measure: str = "max"
    stop: bool = False

    def __post_init__(self) -> None:
        """Refuse an unknown measure or a value that is none."""
        if not _is_finite(self.value):
            raise InputError(
                f"event value = {self.value!r} is not a finite number; give one in the unit of "
                f"{self.name}"
            )
        if self.measure not in MEASURES:
            raise InputError(
                f"event measure {self.measure!r} is unknown; give one of {', '.join(MEASURES)}"
            )


def _is_finite(value: object) -> bool:
    return isinstance(value, Real) and math.isfinite(value)
