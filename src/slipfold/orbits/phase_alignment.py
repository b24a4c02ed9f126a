"""The same cycle begun elsewhere: cycles have no phase of their own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from slipfold.orbits.cycles import Cycles

__all__ = ["begun_nearest"]

Array = NDArray[np.float64]

RESTING = 1e-9
"""A cycle whose nodes differ by less, in scaled states, is an equilibrium: it has no phase."""

SAMPLES = 32
"""Places in each segment that are looked at first."""

CORRECTIONS = 4
"""Newton steps from the nearest of them: each doubles the digits."""


def begun_nearest(problem: Cycles, z: Array, reference: Array) -> Array:
    """Return a cycle begun in the phase in which its nodes lie nearest to those of another."""
    m, period = problem.segments, problem.period
    constants, wanted = problem.constants(z), problem.nodes(reference)
    start: Array = np.arange(m, dtype=float) * (period / m)
    if np.ptp(problem.nodes(z) / problem.scales, axis=0).max() < RESTING:
        return z
    samples = problem.flow.sample(
        problem.nodes(z), start, start + period / m, SAMPLES, constants
    ).reshape(m * SAMPLES, -1)
    rolled = [np.roll(samples, -shift, axis=0)[::SAMPLES] for shift in range(m * SAMPLES)]
    gaps = [float(np.linalg.norm((item - wanted) / problem.scales)) for item in rolled]
    nodes = rolled[int(np.argmin(gaps))]
    apart = period / (m * SAMPLES)
    for _ in range(CORRECTIONS):
        rates = problem.flow.rates(nodes, start, constants) / problem.scales
        gap = (wanted - nodes) / problem.scales
        later = float((rates * gap).sum() / (rates * rates).sum())
        later = min(max(later, -apart), apart)  # beside an equilibrium all phases are as near
        nodes = problem.flow.advance(nodes, start, start + later, constants)
    return problem.join(nodes, problem.free_values(z))
