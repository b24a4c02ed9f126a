"""A response at neighboring parameter values: its known orbits there, corrected together.

Continuation computes one orbit after the other. The orbits of a response at neighboring parameter
values are good guesses, which Newton's method corrects in one batch. What lies between them is then
located and described as on any batch of responses. Nothing is returned where bifurcations may hide
between the orbits, or if doubled branches or their criticality change: the response has to be
followed.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from slipfold.arrays import Array, Indices, Mask
from slipfold.bifurcations.branches.batched import (
    BatchedCase,
    complete,
    doubled_branches,
    locate_bifurcations,
)
from slipfold.bifurcations.branches.batched_points import FollowedOrbits
from slipfold.bifurcations.branches.batched_walk import BatchedBranch, Bracket, single_events
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.make_branch import bare, with_normal_forms
from slipfold.bifurcations.branches.settings import Settings
from slipfold.bifurcations.branches.start import forced_orbits
from slipfold.continuation.end import End
from slipfold.continuation.interpolation import arcs, hermite_each, lengths_of
from slipfold.continuation.locate import ZERO
from slipfold.continuation.search import Interpolated
from slipfold.errors import BREAKDOWNS
from slipfold.models.model import Model
from slipfold.orbits.continued import hold_parameter
from slipfold.orbits.orbit_batch import TESTS, Converged, OrbitBatch, Solutions
from slipfold.orbits.shooting import Shooting
from slipfold.orbits.test_functions import are_neutral


class MOVED:
    """Rules for the orbits that are corrected."""

    # Minimum distance of the points that are corrected, over the length of the branch. Steps are
    # short where test functions change quickly; a drawn line needs fewer points
    apart: float = 0.02
    # Minimum distance of two special points, over the length of the branch: nearer ones may merge
    distinct: float = 1e-3
    # Neighbors that move this many times as far apart as they were are no longer neighbors, unless
    # they are this close, in scaled variables
    spread: float = 3.0
    close: float = 0.05
    # A correction shorter than this leaves an error of its square: enough to bracket zeros
    last_step: float = 1e-4
    # Power of the fraction of a doubled branch that is left, by which guesses move as its beginning
    # does
    fading: int = 4
    # What is farther from its guess is another orbit
    longest: float = 0.5
    # Known orbits this near to a limit are left out, over the length of the branch: the limit
    # moves, and there orbits change too quickly to be corrected from others
    beside: float = 0.03
    # Maximum fraction of the orbits that may be missing: the rest would show little of the response
    dropped: float = 0.4


SETTINGS = Settings()
TOLERANCE = SETTINGS.newton.tolerance

UNFINISHED = "moved from neighboring parameter values as far as that is sure; the rest follows"

LOCATED = ("PD", "NS", "LP")
"""Types of special points that are located."""


def moved_branches(
    known: Sequence[Branch], model: Model, span: tuple[float, float]
) -> tuple[Branch, ...] | None:
    """Return the branches of a response at other parameter values, None where they may differ.

    >>> import slipfold as sf
    >>> model = sf.SlidingOscillator(f=12.5)
    >>> known = sf.response(model, "Nd", (0, 0.9)).branches
    >>> moved = moved_branches(known, model.replace(f=12.51), (0, 0.9))
    >>> followed = sf.response(model, "Nd", (0, 0.9), f=12.51).branches
    >>> abs(moved[0].special[0].value - followed[0].special[0].value) < 1e-12
    True
    """
    if not (model.forced and all(map(_is_ordinary, known))):
        return None
    try:
        return _moved(known, model, span)
    except BREAKDOWNS:
        return None


def _is_ordinary(branch: Branch) -> bool:
    """Whether a batch can describe what happens on it, and where it begins and ends."""
    return (
        branch.durations is None
        and branch.stuck_fraction is None
        and all(item.type in LOCATED for item in branch.special)
        and branch.started.kind == ("span" if branch.parent is None else "bifurcation")
        and branch.stopped.kind in ("span", "limit")
    )


def _moved(
    known: Sequence[Branch], model: Model, span: tuple[float, float]
) -> tuple[Branch, ...] | None:
    """Return the branches at the model's parameter values, None where they may differ."""
    vary, width = known[0].vary, abs(span[1] - span[0])
    model = model.replace(**{vary: span[0]}).with_scales(known[0].model.estimated_scales)
    orbits = forced_orbits(model, vary, width, SETTINGS)
    if not isinstance(orbits.by, Shooting) or orbits.segments != known[0].nodes.shape[1]:
        return None
    batch, case = OrbitBatch.of_branches([orbits]), BatchedCase(model)
    pairs = [(known[0], BatchedBranch(0, orbits, []))]
    while pairs:
        lines = [_Line(batch, *pair) for pair in pairs]
        if not all(line.follow() for line in lines):
            return None
        locate_bifurcations(batch, [case], [branch for _, branch in pairs], span, TOLERANCE)
        if case.failure or not all(line.is_distinct() for line in lines):
            return None
        for line in lines:
            complete(line.followed, case, None, TOLERANCE)
        if not all(branch.points for _, branch in pairs):
            return None
        for before, branch in pairs:
            if before.stopped.kind != "span":
                place = branch.orbits.place(branch.points[-1].z)
                branch.stopped = End("unfinished", UNFINISHED, place)
        children = doubled_branches([case], batch.period, SETTINGS)
        batch = batch.of_period(2 * batch.period)
        own = [item for item in known if item.parent is not None and item.period == batch.period]
        if len(own) != len(children):
            return None
        pairs = list(zip(own, children, strict=True))
    if len(case.branches) < len(known):
        return None
    # Uncertainties take as long as normal forms; they are computed once the branch is followed.
    results = [found for branch in case.branches for found in branch.found]
    described = with_normal_forms(results, [*map(bare, results)])
    case.described = dict(zip(results, described, strict=True))
    moved = case.assembled(vary, span[0])
    return moved if all(map(_leads_alike, known, moved)) else None


def _leads_alike(known: Branch, moved: Branch) -> bool:
    """Whether doubled branches begin in the same directions."""
    before, after = (
        [(item.leads_to, item.criticality) for item in branch.special if item.leads_to]
        for branch in (known, moved)
    )
    return (known.parent, known.period, before) == (moved.parent, moved.period, after)


class _Line:
    """One branch: its known orbits, and what they become."""

    def __init__(self, batch: OrbitBatch, known: Branch, branch: BatchedBranch) -> None:
        self._batch, self._known, self._branch = batch, known, branch
        self.followed: FollowedOrbits  # once it is followed

    def follow(self) -> bool:
        """Give the branch its points and brackets; return whether that is sure."""
        guesses, places = self._guesses()
        rows = np.gradient(guesses, axis=0)
        branch, ends = self._branch, self._known.stopped.kind
        branch.end = "span"
        if branch.first is not None:  # the beginning moves as it does on the parent
            left = (1 - places / places[-1]) ** MOVED.fading
            guesses += left[:, None] * (branch.first.z - guesses[0])
            if branch.first.tangent @ rows[0] < 0:
                branch.first = branch.orbits.turned(branch.first)
            guesses, rows, places = guesses[1:], rows[1:], places[1:]
        held = [0] * (branch.first is None) + [-1] * (ends == "span")
        rows[held] = hold_parameter(self._batch.size) * np.sign(rows[held, -1:])
        rows /= np.linalg.norm(rows, axis=1)[:, None]
        some = np.zeros(len(guesses), dtype=int)  # there is one case
        found = self._batch.correct(some, guesses, rows, MOVED.last_step, MOVED.longest)
        found.z[held, -1] = guesses[held, -1]
        count = int(np.argmin(found.found)) if not found.found.all() else len(guesses)
        chosen = _forward(found, count, branch.first)
        if not _is_coherent(found.z[chosen], guesses):
            return False
        if ends == "span" and count < len(guesses):
            return False
        if ends != "span":
            chosen = chosen[: self._until_limit(found.z[chosen])]
        if len(chosen) < max(4, (1 - MOVED.dropped) * len(guesses)):
            return False
        exact = self._settled(found.z[chosen], rows[chosen])
        for _ in range(ZERO.depth):
            z, tangents, tests, s = self._joined(exact)
            unsure = np.flatnonzero(self._may_hide(s, tests))
            if not len(unsure) or not exact.found.all():
                break
            near, middles = _nearest(s)[unsure], 0.5 * (s[unsure] + s[unsure + 1])
            between = self._settled(*hermite_each(s[near], z[near], tangents[near], middles))
            exact = exact.joined(between, unsure + 1 - self._departs)
        return bool(exact.found.all()) and self._bracket(exact)

    def _settled(self, z: Array, rows: Array) -> Converged:
        """Return the orbits nearest guesses, NaN where they are far."""
        found = self._batch.settled(np.zeros(len(z), dtype=int), z, rows, TOLERANCE)
        found.z[lengths_of(found.z - z) > MOVED.close] = np.nan
        return found

    def is_distinct(self) -> bool:
        """Whether no two special points are so near that they may merge."""
        nearest = MOVED.distinct * self._branch.steps[-1][2]
        apart = np.diff([item.point.arclength for item in self._branch.found])
        return bool((apart > nearest).all())

    def _guesses(self) -> tuple[Array, Array]:
        """Return known orbits in order, special ones among them, and arclengths.

        None is needlessly close to another.
        """
        known, end = self._known, np.inf
        if known.stopped.kind == "limit":
            end = known.arclength[-1] - MOVED.beside * float(np.ptp(known.arclength))
        special = [item for item in known.special if item.arclength < end]
        at_special = [item.arclength for item in special]
        chosen = [i for i in _thinned(known.arclength, at_special) if known.arclength[i] < end]
        places = np.array([*known.arclength[chosen], *at_special])
        order = np.argsort(places)
        nodes = np.array([*known.nodes[chosen], *(item.nodes for item in special)])[order]
        values = [*known.parameter[chosen], *(item.value for item in special)]
        guesses = self._batch.join(np.zeros(len(nodes), int), nodes, np.array(values)[order])
        return guesses, places[order]

    def _until_limit(self, z: Array) -> int:
        """Return how many orbits keep all limits; near the last, where the known branch ended."""
        limits, count = self._batch.model.limits, len(z)
        last = slice(-(len(z) // 2), None)
        margins = self._batch.margins(np.zeros(len(z[last]), int), z[last])
        kept = np.asarray((margins > 0).all(axis=1))
        return count if not limits or kept.all() else count - len(kept) + int(np.argmin(kept))

    def _joined(self, orbits: Converged) -> tuple[Array, Array, Array, Array]:
        """Return unknowns, tangents, test functions and arclengths, with the branch's first."""
        z, tangents, tests, first = orbits.z, orbits.tangents, orbits.tests, self._branch.first
        if first is not None:
            z, tangents = np.vstack([first.z, z]), np.vstack([first.tangent, tangents])
            tests = np.vstack([[first.tests[name] for name in TESTS], tests])
        lengths = arcs(np.diff(z, axis=0), tangents[:-1], tangents[1:])[0]
        return z, tangents, tests, np.concatenate([[0.0], np.cumsum(lengths)])

    def _may_hide(self, s: Array, tests: Array) -> Mask:
        """Return between which orbits functions may have zeros that no signs show.

        In the first step from another branch there are none. Shapes: s (k,); tests (k, f).
        """
        near, ends, noise = _nearest(s), (s[:-1], s[1:]), self._branch.orbits.noise
        given = s[near], tests[near], ends, tests[near[:, :2]], (0, 1), noise
        found = np.asarray(Interpolated.between(*given).ambiguous.any(axis=1))
        found[: self._departs] = False
        return found

    @property
    def _departs(self) -> int:
        """One if the branch begins on another one, else zero."""
        return int(self._branch.first is not None)

    def _bracket(self, result: Converged) -> bool:
        """Store the points, and bracket zeros between them.

        Return whether none may be hidden and the model is valid from the first point to the last.
        What was a special point is near the zero, so that few more orbits are needed.
        """
        branch, departs = self._branch, self._departs
        z, tangents, tests, s = self._joined(result)
        self.followed = FollowedOrbits(branch, result, s[departs:])
        branch.steps[:] = list(zip(z, tangents, s.tolist(), strict=True))
        changed = (tests[:-1] > 0) != (tests[1:] > 0)
        changed[:departs] = False
        unstable = (np.abs(result.multipliers) > 1).sum(axis=1)
        unstable = np.append(unstable[:departs], unstable)
        branch.stable = bool(unstable[0] == 0)
        kinds, explained = single_events(changed, np.abs(np.diff(unstable)))
        margins = self._batch.margins(np.zeros(len(z), dtype=int), z)
        valid = explained.all() and (margins > 0).all()
        neutral = are_neutral(result.multipliers).sum(axis=1)  # along a branch, it hides others
        valid &= not (neutral[:-1] * neutral[1:]).any()
        if not valid or self._may_hide(s, np.hstack([tests, margins])).any():
            return False
        for i in np.flatnonzero(kinds >= 0).tolist():
            near = [i, i + 1, *range(max(i - 2, 0), i), *range(i + 2, min(i + 4, len(s)))]
            parts = z[near], tangents[near], s[near], tests[near, kinds[i]]
            counts = int(unstable[i]), int(unstable[i + 1])
            branch.brackets.append(Bracket(0, branch.orbits, TESTS[kinds[i]], *parts, counts))
        return True


def _thinned(s: Array, at_special: list[float]) -> list[int]:
    """Choose points of a branch: the first two, the last, and others not too near to a chosen one.

    A special point may move to just beside the first. Between two special points at least one is
    chosen, so that they are distinguished.
    """
    apart = MOVED.apart * float(np.ptp(s))
    chosen = [0, min(1, len(s) - 1), len(s) - 1]
    taken = [*s[chosen].tolist(), *at_special]
    for left, right in pairwise(sorted(taken)):
        inside = np.flatnonzero((s > left) & (s < right))
        if len(inside):
            middle = int(inside[np.abs(s[inside] - 0.5 * (left + right)).argmin()])
            chosen.append(middle)
            taken.append(float(s[middle]))
    for i in range(1, len(s) - 1):
        if min(abs(other - s[i]) for other in taken) >= apart:
            chosen.append(i)
            taken.append(float(s[i]))
    return sorted(set(chosen))


def _forward(result: Solutions, count: int, first: object) -> list[int]:
    """Return the orbits in order, without those that have overtaken a neighbor or the beginning."""
    z, tangents, chosen = result.z, result.tangents, list[int]()
    begin = getattr(first, "z", None)
    for i in range(count):
        if begin is not None and (z[i] - begin) @ tangents[i] <= 0:
            continue
        while chosen and (z[i] - z[chosen[-1]]) @ tangents[chosen[-1]] <= 0:
            chosen.pop()
        chosen.append(i)
    return chosen


def _is_coherent(z: Array, before: Array) -> bool:
    """Whether neighbors are still neighbors."""
    apart = np.linalg.norm(np.diff(z, axis=0), axis=1)
    longest = float(np.linalg.norm(np.diff(before, axis=0), axis=1).max(initial=0.0))
    return bool((apart < MOVED.spread * longest + MOVED.close).all())


def _nearest(s: Array) -> Indices:
    """Return the numbers of both orbits of each interval, and of two others, the nearer one first.

    Shapes: s (k,); returns (k - 1, 4).
    """
    first = np.arange(len(s) - 1)
    window = np.clip(first - 1, 0, len(s) - 4)[:, None] + np.arange(4)
    away = np.abs(s[window] - 0.5 * (s[:-1] + s[1:])[:, None])
    near = np.take_along_axis(window, away.argsort(axis=1), axis=1)
    near[:, :2] = np.column_stack([first, first + 1])
    return near
