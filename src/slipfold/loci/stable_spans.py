"""Where on a branch the response is stable, as intervals of its parameter, and its orbits there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.branch import Branch
from slipfold.branches.special_point import BIFURCATIONS
from slipfold.branches.stability import stability_stretches
from slipfold.continuation.newton import correct
from slipfold.models.model import Model
from slipfold.models.turns import without_turns
from slipfold.orbits.continued import hold_parameter
from slipfold.orbits.kinds import ForcedOrbits

ONE_ORBIT = 1e-4
"""Two stable orbits this close in scaled states are one."""


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


def stable_orbits(branches: Sequence[Branch], value: float) -> dict[int, list[NDArray[np.float64]]]:
    """Return the stable orbits of branches at a value of their parameter, by period.

    Returns shapes (m, n_states).
    """
    found: dict[int, list[NDArray[np.float64]]] = {}
    for branch in branches:
        for span in stable_spans(branch):
            if span.low <= value <= span.high:
                nodes = _orbit_on(branch, span, value)
                known = found.setdefault(branch.period, [])
                if nodes is not None and not is_among(branch.model, nodes, branch.period, known):
                    known.append(nodes)
    return {period: orbits for period, orbits in found.items() if orbits}


def is_among(
    model: Model,
    nodes: NDArray[np.float64],
    period: int,
    known: Sequence[NDArray[np.float64]],
) -> bool:
    """Whether an orbit is one of others, begun in whichever forcing period.

    Shapes: nodes (m, n_states).
    """
    scales, whole = model.state_scales(), model.whole_turns
    each, rest = divmod(len(nodes), period)
    begun = [np.roll(nodes, k * each, axis=0) for k in range(period if rest == 0 else 1)]
    return any(
        np.abs(without_turns(copy - other, whole) / scales).max() < ONE_ORBIT
        for copy in begun
        for other in known
    )


def _orbit_on(branch: Branch, span: StableSpan, value: float) -> NDArray[np.float64] | None:
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
