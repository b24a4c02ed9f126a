"""Special points and ends at limits on many branches, located in batches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.batched_walk import BATCH, BatchedBranch, Bracket
from slipfold.bifurcations.branches.stops import STOP
from slipfold.continuation.locate import Guess, LostCurveError, corrected_together
from slipfold.continuation.newton import NEWTON
from slipfold.continuation.traced_curve import Found
from slipfold.orbits.orbit_batch import EXACTLY, TESTS, Converged, OrbitBatch, Solutions
from slipfold.orbits.orbit_curve import OrbitPoint

Function = Callable[[Sequence[Bracket], Solutions], Array]
"""The function with a zero in each bracket, of an orbit for each, shape (k,)."""


def critical_values(brackets: Sequence[Bracket], orbits: Solutions) -> Array:
    """Return the test functions whose zeros are special points, shape (k,)."""
    kinds = [TESTS.index(item.kind) for item in brackets]
    return np.asarray(orbits.tests[np.arange(len(brackets)), kinds])


Located = list[Found[OrbitPoint] | LostCurveError]
"""What was found in each bracket, or why nothing was."""


def exact_zeros(
    orbits: OrbitBatch,
    brackets: Sequence[Bracket],
    tolerance: float,
    function: Function = critical_values,
    close: float = BATCH.zero,
) -> Located:
    """Locate the zeros within brackets by the flow itself, all at the same time."""

    def correct(guesses: dict[int, Guess]) -> dict[int, OrbitPoint | LostCurveError]:
        own, known = [brackets[number] for number in guesses], guesses.values()
        z, rows = np.array([item.z for item in known]), np.array([item.row for item in known])
        cases = np.array([item.case for item in own])
        found = orbits.correct(cases, z, rows, NEWTON.exact, np.inf, EXACTLY)
        values, points = function(own, found), dict[int, OrbitPoint | LostCurveError]()
        for row, (number, guess) in enumerate(guesses.items()):
            points[number] = LostCurveError("no orbit was found between two others")
            if np.isfinite(values[row]):
                points[number] = point = found.point(row, own[row].orbits, guess.arclength, np.nan)
                point.tests[own[row].kind] = float(values[row])
        return points

    located: Located = corrected_together([item.locating(close) for item in brackets], correct)
    there = [(i, item) for i, item in enumerate(located) if isinstance(item, Found)]
    cases = np.array([brackets[i].case for i, _ in there], dtype=np.int64)
    residuals = orbits.residuals(cases, np.array([item.point.z for _, item in there]))
    for (i, item), residual in zip(there, residuals.tolist(), strict=True):
        lost = LostCurveError("the orbit at a zero does not close")
        known = replace(item, point=replace(item.point, residual=residual))
        located[i] = known if residual <= tolerance else lost
    return located


# -- ends at limits of the model ------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class FollowedOrbits:
    """The orbits of a branch, corrected by the flow itself."""

    branch: BatchedBranch
    orbits: Converged
    arclengths: Array


def orbits_at_limits(
    orbits: OrbitBatch, ended: Sequence[FollowedOrbits], tolerance: float
) -> dict[BatchedBranch, Found[OrbitPoint] | LostCurveError]:
    """Return where branches that end at a limit meet it, as far as that is located."""
    long = [item for item in ended if len(item.arclengths) >= BATCH.last]
    if not long:
        return {}
    cases = np.repeat([item.branch.case for item in long], BATCH.last)
    last = np.concatenate([item.orbits.z[-BATCH.last :] for item in long])
    margins = np.split(orbits.margins(cases, last), len(long))
    brackets = dict[BatchedBranch, Bracket]()
    for item, own in zip(long, margins, strict=True):
        bracket = _limit_bracket(orbits, item, own)
        if bracket is not None:
            brackets[item.branch] = bracket
    names = [limit.name for limit in orbits.model.limits]

    def margin(brackets: Sequence[Bracket], solutions: Solutions) -> Array:
        which = [names.index(item.kind) for item in brackets]
        each = orbits.margins(np.array([item.case for item in brackets]), solutions.z)
        return np.asarray(each[np.arange(len(which)), which])

    zeros = exact_zeros(orbits, [*brackets.values()], tolerance, margin, STOP.limit_close)
    return dict(zip(brackets, zeros, strict=True))


def _limit_bracket(orbits: OrbitBatch, followed: FollowedOrbits, margins: Array) -> Bracket | None:
    """Return two orbits between which one limit is broken; None if there is no such limit.

    Shapes: margins (BATCH.last, n_limits).
    """
    last, case = slice(-BATCH.last, None), followed.branch.case
    z, tangents = followed.orbits.z[last], followed.orbits.tangents[last]
    arclengths = followed.arclengths[last]
    own, factor = np.array([case]), BATCH.beyond
    if not (margins[-2] > 0).all():
        z, tangents, arclengths = z[:-1], tangents[:-1], arclengths[:-1]
        margins = margins[:-1]
    maximum = BATCH.max_distance * (arclengths[-1] - arclengths[-2])
    for _ in range(BATCH.attempts):
        if not (margins[-1] > 0).all():
            break
        length = arclengths[-1] - arclengths[-2]
        falls = np.maximum(margins[-2] - margins[-1], 1e-300)
        further, row = factor * float((margins[-1] / falls * length).min()), tangents[-1:]
        if not further < maximum:
            return None
        now = orbits.correct(own, z[-1:] + further * row, row, BATCH.last_step, further)
        if not now.found[0]:
            factor *= BATCH.shorter
            continue
        factor = BATCH.beyond
        z, tangents = np.concatenate([z, now.z]), np.concatenate([tangents, now.tangents])
        arclengths = np.append(arclengths, arclengths[-1] + further)
        margins = np.concatenate([margins, orbits.margins(own, now.z)])
    broken = np.flatnonzero(~(margins[-1] > 0))
    if not (margins[-2] > 0).all() or len(broken) != 1 or not np.isfinite(tangents[-2:]).all():
        return None
    index = int(broken[0])
    name, values = orbits.model.limits[index].name, margins[-2:, index]
    known = z[-2:], tangents[-2:], arclengths[-2:], values
    return Bracket(case, followed.branch.orbits, name, *known)
