"""Special points and ends at limits on many branches, located in batches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.batched_walk import BATCH, BatchedBranch, Bracket, Located
from slipfold.bifurcations.branches.stops import STOP
from slipfold.continuation.interpolation import hermite_each
from slipfold.continuation.locate import ZERO, BracketedZero
from slipfold.continuation.newton import NEWTON
from slipfold.orbits.orbit_batch import EXACTLY, TESTS, Converged, OrbitBatch, Solutions

Function = Callable[[Sequence[Bracket], Solutions], Array]
"""The function with a zero in each bracket, of an orbit for each, shape (k,)."""


def critical_values(brackets: Sequence[Bracket], orbits: Solutions) -> Array:
    """Return the test functions whose zeros are special points, shape (k,)."""
    kinds = [TESTS.index(item.kind) for item in brackets]
    return np.asarray(orbits.tests[np.arange(len(brackets)), kinds])


def locate_zeros(
    orbits: OrbitBatch,
    brackets: Sequence[Bracket],
    function: Function = critical_values,
    near: float = BATCH.near,
) -> list[Located | None]:
    """Locate the zeros within brackets, along their chords; None where that fails."""
    result: list[Located | None] = [None] * len(brackets)
    if not brackets:
        return result
    z = np.array([item.z for item in brackets])
    cases = np.array([item.case for item in brackets])
    chord = z[:, 1] - z[:, 0]
    lengths = np.sqrt((chord * chord).sum(axis=1))
    rows = chord / lengths[:, None]
    slopes = np.array([item.tangents for item in brackets])
    slopes /= (slopes * rows[:, None]).sum(axis=2)[..., None]  # by the position along the chord
    zeros = [
        BracketedZero(length, (float(item.values[0]), float(item.values[1])))
        for item, length in zip(brackets, lengths.tolist(), strict=True)
    ]
    active = list(range(len(brackets)))
    for _ in range(BATCH.iterations):
        if not active:
            break
        at = np.array([zeros[i].next_guess() for i in active])
        ends = np.column_stack([np.zeros(len(active)), lengths[active]])
        guess, _ = hermite_each(ends, z[active], slopes[active], at)
        off = at - ((guess - z[active, 0]) * rows[active]).sum(axis=1)
        guess += off[:, None] * rows[active]
        solutions = orbits.correct(cases[active], guess, rows[active], BATCH.last_step, np.inf)
        values = function([brackets[i] for i in active], solutions)
        remaining = []
        for row, i in enumerate(active):
            forward, value = float(solutions.tangents[row] @ rows[i]), float(values[row])
            if not np.isfinite(value) or not forward > 0:
                continue
            position = float(at[row])
            if zeros[i].error(position, value) > near < zeros[i].width:
                zeros[i].add(position, value)
                remaining.append(i)
                continue
            slope = zeros[i].slope(position, value) * forward  # along the branch, not its chord
            arclength = float(np.interp(position, (0.0, lengths[i]), brackets[i].arclengths))
            orbit = solutions.z[row], solutions.tangents[row], solutions.multipliers[row]
            result[i] = Located(brackets[i], *orbit, slope, arclength)
        active = remaining
    return result


def refine_zeros(
    orbits: OrbitBatch,
    items: Sequence[Located],
    tolerance: float,
    function: Function = critical_values,
    close: float = ZERO.close,
) -> list[tuple[Converged, float] | None]:
    """Return zeros by the flow itself, each with its remaining value; None where that fails.

    Secant steps along the branch end within an arclength `close` of the zero. The remaining value
    is rounding.
    """
    result: list[tuple[Converged, float] | None] = [None] * len(items)
    cases = np.array([item.bracket.case for item in items])
    slopes = np.array([item.slope for item in items])
    z = np.array([item.z for item in items])
    rows = np.array([item.tangent for item in items])
    active, before = np.arange(len(items)), np.full(len(items), np.nan)
    steps = 4  # of which one or two are needed
    for step in range(steps):
        if not len(active):
            break
        own = cases[active]
        now = orbits.correct(own, z[active], rows[active], NEWTON.exact, np.inf, EXACTLY)
        residuals = orbits.residuals(own, now.z)
        here = Converged(now.z, now.tangents, now.monodromies, residuals)
        value = function([items[i].bracket for i in active.tolist()], here)
        fails = ~(np.isfinite(value) & (residuals <= tolerance))
        # The last step gives the slope again, unless rounding is left.
        ratio = value / before[active]
        slopes[active] *= np.where(np.abs(ratio) < 0.5, 1 - ratio, 1.0)
        before[active] = value
        done = (np.abs(value) <= close * np.abs(slopes[active])) | (step == steps - 1)
        for row in np.flatnonzero(done & ~fails).tolist():
            result[active[row]] = here.of(slice(row, row + 1)), float(value[row])
        more = np.flatnonzero(~done & ~fails)
        active = active[more]
        rows[active] = here.tangents[more]
        z[active] = here.z[more] - (value[more] / slopes[active])[:, None] * rows[active]
    return result


# -- ends at limits of the model ------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class FollowedOrbits:
    """The orbits of a branch, corrected by the flow itself."""

    branch: BatchedBranch
    orbits: Converged
    arclengths: Array


@dataclass(frozen=True, eq=False)
class AtLimit:
    """The last orbit of a branch, at a limit of the model."""

    orbit: Converged  # this one alone
    arclength: float
    limit: int  # index of the limit
    margin: float  # zero to rounding


def orbits_at_limits(
    orbits: OrbitBatch, ended: Sequence[FollowedOrbits], tolerance: float
) -> dict[BatchedBranch, AtLimit]:
    """Return where branches that end at a limit meet it, as far as that is located."""
    bracketed, brackets = list[BatchedBranch](), list[Bracket]()
    for item in ended:
        bracket = _limit_bracket(orbits, item)
        if bracket is not None:
            bracketed.append(item.branch)
            brackets.append(bracket)
    names = [limit.name for limit in orbits.model.limits]

    def margin(brackets: Sequence[Bracket], solutions: Solutions) -> Array:
        which = [names.index(item.kind) for item in brackets]
        each = orbits.margins(np.array([item.case for item in brackets]), solutions.z)
        return np.asarray(each[np.arange(len(which)), which])

    near = zip(bracketed, locate_zeros(orbits, brackets, margin, STOP.limit_close), strict=True)
    located = [(branch, item) for branch, item in near if item is not None]
    items = [item for _, item in located]
    zeros = refine_zeros(orbits, items, tolerance, margin, STOP.limit_close)
    return {
        branch: AtLimit(zero[0], item.arclength, names.index(item.bracket.kind), zero[1])
        for (branch, item), zero in zip(located, zeros, strict=True)
        if zero is not None
    }


def _limit_bracket(orbits: OrbitBatch, followed: FollowedOrbits) -> Bracket | None:
    """Return two orbits between which one limit is broken; None if there is no such limit."""
    last, case = slice(-BATCH.last, None), followed.branch.case
    z, tangents = followed.orbits.z[last], followed.orbits.tangents[last]
    arclengths = followed.arclengths[last]
    if len(z) < BATCH.last:
        return None
    own, factor = np.array([case]), BATCH.beyond
    margins = orbits.margins(np.full(BATCH.last, case), z)
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
    return Bracket(case, name, z[-2:], tangents[-2:], arclengths[-2:], values)
