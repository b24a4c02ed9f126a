"""Colours of what motions do, the same in every figure."""

from __future__ import annotations

from typing import Any

import numpy as np

COLOURS = {
    "period 1": "#eef0e2",
    "period 2": "#b7ddd0",
    "period 4": "#6fb7b0",
    "period 8": "#3a8a94",
    "other periods": "#8db4dc",
    "torus": "#f5c451",
    "chaos": "#b5322b",
    "sticks": "#8f7cc0",
    "stopped": "#9a9a9a",
    "undecided": "#ffffff",
    "not done": "#ffffff",
    "none": "#ffffff",
}
"""Colour of each regime: lightness tells them apart in grey as well."""


def grouped(names: Any) -> Any:
    """Return what motions do, with periods that have no colour of their own together.

    >>> grouped(["torus", "period 4", "period 5"]).tolist()
    ['torus', 'period 4', 'other periods']
    """
    named = np.asarray(names).astype(object)
    named[~np.isin(named, list(COLOURS))] = "other periods"
    return named
