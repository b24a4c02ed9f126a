"""Where on a branch the response is stable, as intervals of its parameter."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.branch import Branch
from slipfold.branches.special_point import BIFURCATIONS
from slipfold.branches.stability import stability_stretches
from slipfold.continuation.newton import correct
from slipfold.orbits.carry_to import hold_parameter
from slipfold.orbits.forced_orbits import ForcedOrbits

__all__ = ["StableSpan", "orbit_on", "stable_spans"]


@dataclass(frozen=True)
class StableSpan:
    """A stretch of a branch between two bifurcations on which it is stable."""

    # Least and largest value of the parameter
    low: float
    high: float
    rows: tuple[int, int]  # first row of the branch on the stretch, and the one after the last


def stable_spans(branch: Branch) -> list[StableSpan]:
    """Return the stable stretches of a branch; between bifurcations its parameter is monotonic."""
    if not len(branch):
        return []
    marks = [p.value for p in branch.special if p.type in BIFURCATIONS]
    values = [float(branch.parameter[0]), *marks, float(branch.parameter[-1])]
    spans = []
    for stretch, (a, b) in zip(stability_stretches(branch), pairwise(values), strict=True):
        if stretch.stable:
            first, last = np.searchsorted(branch.arclength, [stretch.begin, stretch.end])
            spans.append(StableSpan(min(a, b), max(a, b), (int(first), min(last + 1, len(branch)))))
    return spans


def orbit_on(branch: Branch, span: StableSpan, value: float) -> NDArray[np.float64] | None:
    """Return the orbit at a value of the parameter, None if Newton's method does not find it.

    Returns shape (m, n_states).
    """
    rows = np.arange(*span.rows)
    order = rows[np.argsort(np.abs(branch.parameter[rows] - value), kind="stable")]
    width = float(np.ptp(branch.parameter)) or 1.0
    orbits = ForcedOrbits(branch.model, {branch.vary: width}, branch.period, branch.nodes.shape[1])
    for row in order[:2]:
        guess = orbits.pack(branch.nodes[row], value)
        correction = correct(orbits, guess, hold_parameter(orbits.size), iterations=15)
        if correction.converged and correction.linearisation is not None:
            multipliers = np.linalg.eigvals(correction.linearisation.monodromy)
            if np.abs(multipliers).max() < 1:
                return orbits.nodes(correction.z)
    return None
