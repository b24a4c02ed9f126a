"""Many motions at once: the work that every program gets.

Five hundred and twelve starts of the base case at f = 12.5 Hz and Nd = 0.05 N, at rest but for y/L
between -0.3 and 0.3, for a hundred forcing periods each. All come to one response of period 2, so
that what programs end at can be compared.
"""

import numpy as np

COUNT, PERIODS, AMPLITUDE = 512, 100, 0.05
COMPARED = 8
"""Starts whose last displacements are compared."""


def starts(count: int = COUNT) -> np.ndarray:
    """Starting states, shape (count, 4)."""
    states = np.zeros((COUNT, 4))
    states[:, 1] = np.linspace(-0.3, 0.3, COUNT)
    return states[:: COUNT // count]


def compared(displacements: np.ndarray) -> list[float]:
    """Last x/L and y/L of those that are compared, from an array of shape (count, 2)."""
    return displacements[:: max(len(displacements) // COMPARED, 1)][:COMPARED].ravel().tolist()
