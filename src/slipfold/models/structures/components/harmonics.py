"""Numbers of harmonics of the forcing."""

from __future__ import annotations

from typing import Any

import numpy as np

from slipfold.errors import InputError
from slipfold.models.structures.shown import shown

HIGHEST = 64
"""Highest harmonic; each one takes a cosine and a sine at every step of the integration."""


def checked_harmonic(value: Any, what: str, lowest: int = 1) -> int:
    """Return the number of a harmonic, or raise if it is none."""
    whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not whole or not lowest <= value <= HIGHEST:
        raise InputError(
            f"a {what} has the harmonic {shown(value)}; give a whole number from {lowest} to "
            f"{HIGHEST}"
        )
    return int(value)
