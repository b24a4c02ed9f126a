"""Rates of which fast vibrations follow at once: a structure's highest modes carry no motion."""

from __future__ import annotations

import numpy as np

from slipfold.arrays import Array

FAST = 64.0
"""Vibrations this many times faster than the slowest one, and than the forcing, carry none of the
motion: they follow it. A chain of forty masses has none, a beam of three elements has."""

VIBRATES = 1e-9
"""Imaginary part of an eigenvalue, over the fastest rate, that rounding may feign."""


def followed_at_once(jacobian: Array, forcing: float) -> Array | None:
    """Return what makes of rates those of slow motion, shape (n, n); None if all motion is slow.

    With rates r and their derivatives A it is the rate of one implicit step of Euler's method,
    ``(I - h A)^-1 r``, over a time h in which slow motion hardly changes.

    Shapes: jacobian (n, n).

    Examples
    --------
    >>> from scipy.linalg import block_diag
    >>> modes = block_diag([[0.0, 1.0], [-1.0, 0.0]], [[0.0, 1.0], [-1e10, -1.0]])
    >>> slow = followed_at_once(modes, 0.0)
    >>> bool(np.linalg.norm(slow @ [0.0, 0.0, 0.0, 1.0]) < 1e-6)
    True
    >>> followed_at_once(modes, 1e5) is None
    True
    """
    if not np.isfinite(jacobian).all():
        return None
    values = np.linalg.eigvals(jacobian)
    largest = float(np.abs(values).max())
    turning = np.abs(values[np.abs(values.imag) > VIBRATES * largest])
    rate = FAST * max(float(turning.min(initial=np.inf)) if len(turning) else 0.0, forcing)
    if not 0 < rate < largest or not rate < turning.max(initial=0.0):
        return None
    return np.asarray(np.linalg.inv(np.eye(len(jacobian)) - jacobian / rate))
