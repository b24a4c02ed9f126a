"""Stability by Floquet multipliers, and revolutions of angles, in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.text.one_line import number_text

Multipliers = NDArray[np.complex128]

NEUTRAL = 1e-9
"""A multiplier this near to the unit circle is neither inside nor outside: rounding may move it."""


def outside(multipliers: Multipliers) -> NDArray[np.bool_]:
    """Whether each multiplier lies outside the unit circle, beyond rounding.

    Shapes: multipliers (...).
    """
    return np.asarray(np.abs(multipliers) > 1 + NEUTRAL)


def stability_word(multipliers: Multipliers, *, cycle: bool) -> str:
    """Return ``"stable"``, ``"unstable"`` or, of what nothing damps, ``"neutral"``.

    Of a cycle one multiplier is one anyway. Shapes: multipliers (n,).

    >>> stability_word(np.array([0.5, 1.0]), cycle=True)
    'stable'
    >>> stability_word(np.array([1j, -1j]), cycle=False)
    'neutral'
    """
    if outside(multipliers).any():
        return "unstable"
    others: Any = np.delete(multipliers, np.abs(multipliers - 1).argmin()) if cycle else multipliers
    return "neutral" if np.abs(others).max(initial=0.0) > 1 - NEUTRAL else "stable"


def multipliers_text(multipliers: Multipliers, *, cycle: bool) -> str:
    """Return the stability of an orbit, and the modulus of its largest multiplier.

    >>> multipliers_text(np.array([-1.2, 0.5j, -0.5j]), cycle=False)
    'unstable by 1 of 3 multipliers, the largest 1.2'
    """
    word = stability_word(multipliers, cycle=cycle)
    if word == "unstable":
        word += f" by {outside(multipliers).sum()} of {len(multipliers)} multipliers"
    largest = float(np.abs(multipliers).max(initial=0.0))
    return f"{word}, the largest {number_text(largest)}" if len(multipliers) else word


def revolutions_text(revolutions: Mapping[str, int]) -> str:
    """Say how many revolutions angles make in a period; empty where none does.

    >>> revolutions_text({"phi": -1, "psi": 0, "theta": 2})
    'phi makes 1 revolution, backwards; theta makes 2 revolutions'
    """
    return "; ".join(
        f"{name} makes {abs(count)} revolution{'s' * (abs(count) != 1)}"
        f"{', backwards' if count < 0 else ''}"
        for name, count in revolutions.items()
        if count
    )
