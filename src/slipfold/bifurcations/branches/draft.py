"""Drafts of a response: the branches at neighboring parameter values, corrected in one batch.

Continuation computes one orbit after the other. All orbits of the branches at neighboring parameter
values are good guesses, which Newton's method corrects in one batch. Bifurcations are located
again, to the accuracy of a drawing. There is no draft if a bifurcation appears or vanishes, or if
the criticality of a period doubling changes: the response has to be followed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.bifurcations.branches.batched_points import locate_zeros
from slipfold.bifurcations.branches.batched_walk import Bracket
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.continuation.end import End
from slipfold.continuation.interpolation import polynomial
from slipfold.continuation.locate import LostCurveError
from slipfold.continuation.traced_curve import Found
from slipfold.models.model import Model
from slipfold.orbits.bifurcation_types import BIFURCATION_TYPES
from slipfold.orbits.kinds import ForcedOrbits
from slipfold.orbits.limits import broken_limit
from slipfold.orbits.normal_forms.normal_form import normal_form
from slipfold.orbits.orbit_batch import TESTS, Corrected, OrbitBatch, correct_orbits


@dataclass(frozen=True)
class DraftRules:
    """Rules for drafts."""

    # Minimum distance of the points that are corrected, over the length of the branch. Steps are
    # short where test functions change quickly; a drawn line needs fewer points
    apart: float = 0.02
    # Minimum distance of two special points, over the length of the branch. A thousandth of it is
    # the error to which they are located, which takes one secant more than a drawing shows
    distinct: float = 1e-3
    # Neighbors that move this many times as far apart as they were are no longer neighbors, unless
    # they are this close, in scaled variables
    spread: float = 3.0
    close: float = 0.05
    # Maximum fraction of the points that may be missing at the end of a branch
    dropped: float = 0.4


DRAFT = DraftRules()


REASON = "a draft, from neighboring parameter values, as far as that is sure"

CHANGES = {"PD": 1, "NS": 2, "LP": 1}
"""Multipliers that cross the unit circle at each type of special point that a draft may have."""


def draft_branches(branches: Sequence[Branch], model: Model) -> tuple[Branch, ...] | None:
    """Return the branches of a response at other parameter values, None where they may differ.

    >>> import slipfold as sf
    >>> model = sf.SlidingOscillator(f=12.5)
    >>> known = sf.response(model, "Nd", (0, 0.9)).branches
    >>> draft = draft_branches(known, model.replace(f=12.51))
    >>> followed = sf.response(model, "Nd", (0, 0.9), f=12.51).branches
    >>> abs(draft[0].special[0].value - followed[0].special[0].value) < 1e-5
    True
    """
    drafts: list[Branch] = []
    for branch in branches:
        if branch.durations is not None or not model.forced:
            return None
        draft = _Draft(branch, model, drafts).branch()
        if draft is None:
            return None
        drafts.append(draft)
    return tuple(drafts)


@dataclass(frozen=True, eq=False)
class _Curve:
    """Orbits of one branch in order."""

    z: Array  # shape (k, u)
    tangents: Array  # unit tangents of the branch, shape (k, u)
    multipliers: NDArray[np.complex128]  # shape (k, n)
    tests: Array  # test functions, shape (k, len(TESTS))

    @property
    def arclength(self) -> Array:
        """Sums of the chords, shape (k,)."""
        steps = np.linalg.norm(np.diff(self.z, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)])

    def rows(self, chosen: Sequence[int]) -> _Curve:
        """Return a selection of them, as copies."""
        rows = list(chosen)
        return _Curve(self.z[rows], self.tangents[rows], self.multipliers[rows], self.tests[rows])

    def with_ends(self, first: Array | None, last: Array | None) -> _Curve:
        """Join orbits to the ends. No test function changes sign there: they take their neighbors'.

        Shapes: first, last (u,).
        """
        end = len(self.z) - 1
        rows = [0] * (first is not None) + [*range(end + 1)] + [end] * (last is not None)
        joined = self.rows(rows)
        for row, z in ((0, first), (-1, last)):
            if z is not None:
                joined.z[row] = z
        return joined


class _Draft:
    """A known branch whose orbits are corrected at other parameter values.

    `drafts` are those of the branches before it.
    """

    def __init__(self, known: Branch, model: Model, drafts: Sequence[Branch]) -> None:
        self.known = known
        self.special = [item for item in known.special if item.type in BIFURCATION_TYPES]
        width, segments = float(np.ptp(known.parameter)), known.nodes.shape[1]
        self.orbits = ForcedOrbits(model, {known.vary: width}, known.period, segments)
        self.first, self.last = self._parent_points(drafts)

    def branch(self) -> Branch | None:
        """Return the draft, None if it may differ from what is followed."""
        if any(item.type not in CHANGES for item in self.special):
            return None
        arclengths, guesses = self._guesses()
        if len(guesses) < 4:
            return None  # too few to draw a line through
        if self.known.parent is not None and self.first is None:
            return None  # the draft of its parent does not reach that far
        inner = slice(int(self.first is not None), len(guesses) - int(self.last is not None))
        result = correct_orbits(self.orbits, guesses[inner], self._rows(guesses)[inner])
        count = self._reliable(result)
        if count < (1 - DRAFT.dropped) * len(result.z):
            return None
        complete = count == len(result.z)
        first = self._doubled(self.first, result.z[0])
        last = self._doubled(self.last, result.z[count - 1]) if complete else None
        forward = _forward(result.z[:count], result.tangents[:count], first, last)
        if len(forward) < 4:
            return None
        parts = result.z, result.tangents, result.multipliers, result.tests
        curve = _Curve(*parts).rows(forward).with_ends(first, last)
        if not _coherent(curve.z, guesses):
            return None
        reached = float(arclengths[inner][count - 1])
        special = [item for item in self.special if item.arclength <= reached]
        located = self._located(curve, special)
        forms = None if located is None else self._normal_forms(special, located)
        if located is None or forms is None:
            return None
        return self._assembled(curve, special, located, forms, complete)

    # -- orbits ------------------------------------------------------------------------------------

    def _guesses(self) -> tuple[Array, Array]:
        """Return arclengths and unknowns of known orbits in order, none needlessly close."""
        known, special = self.known, self.special
        at_special = [item.arclength for item in special]
        chosen = _thinned(known.arclength, at_special)
        arclengths = np.concatenate([known.arclength[chosen], at_special])
        order = np.argsort(arclengths)
        nodes = np.concatenate([known.nodes[chosen], *(item.nodes[None] for item in special)])
        values = np.concatenate([known.parameter[chosen], [item.value for item in special]])
        pairs = zip(nodes[order], values[order], strict=True)
        return arclengths[order], np.array([self.orbits.pack(*item) for item in pairs])

    def _rows(self, z: Array) -> Array:
        """Return directions of the branch; at an end of the span that of the parameter."""
        rows = np.gradient(z, axis=0)
        for index, end in ((0, self.known.started), (-1, self.known.stopped)):
            if end.kind == "span":
                rows[index] = 0.0
                rows[index, -1] = 1.0
        return np.asarray(rows / np.linalg.norm(rows, axis=1)[:, None])

    def _reliable(self, result: Corrected) -> int:
        """Return how many orbits from the first one lie in the span and within the limits.

        Near a limit, as where the spring collapses, orbits change too quickly for a draft.
        """
        good = result.found & self._is_within(result.z[:, -1] * self.orbits.width)
        count = int(np.argmin(good)) if not good.all() else len(good)
        # The known branch is within the limits up to its end: only orbits near that are examined.
        while count and self.orbits.model.limits and broken_limit(self.orbits, result.z[count - 1]):
            count -= 1
        return count

    def _is_within(self, values: Array) -> NDArray[np.bool_]:
        """Whether values lie between those of the branch, or beyond an end inside the span."""
        known = self.known
        low, high = known.parameter.min(), known.parameter.max()
        ends = {end.value for end in (known.started, known.stopped) if end.kind == "span"}
        tolerance = 1e-9 * (high - low)
        above = values >= low - tolerance if low in ends else np.ones(len(values), bool)
        below = values <= high + tolerance if high in ends else np.ones(len(values), bool)
        return np.asarray(above & below)

    # -- where doubled branches begin and end ------------------------------------------------------

    def _parent_points(
        self, drafts: Sequence[Branch]
    ) -> tuple[SpecialPoint | None, SpecialPoint | None]:
        """Return the period doublings of drafts on which a doubled branch begins and ends."""
        known = self.known
        if known.parent is None or known.parent > len(drafts):
            return None, None
        joined = [item for item in drafts[known.parent - 1].special if item.leads_to == known.id]
        if not joined:
            return None, None
        first = min(joined, key=lambda item: abs(item.value - known.parameter[0]))
        others = [item for item in joined if item is not first]
        return first, others[0] if others and known.stopped.kind == "closed" else None

    def _doubled(self, point: SpecialPoint | None, neighbor: Array) -> Array | None:
        """Return the orbit of a period doubling, passed twice, in phase with a neighbor."""
        if point is None:
            return None
        half = point.nodes[::2]
        nodes = np.concatenate([half, half])
        step = max(len(nodes) // self.orbits.period, 1)
        shifted = (
            self.orbits.pack(np.roll(nodes, -shift, axis=0), point.value)
            for shift in range(0, len(nodes), step)
        )
        near = [self.orbits.beside(z, neighbor) for z in shifted]
        return min(near, key=lambda z: float(np.linalg.norm(z - neighbor)))

    # -- special points ----------------------------------------------------------------------------

    def _located(self, curve: _Curve, special: Sequence[SpecialPoint]) -> list[Found] | None:
        """Locate all special points; None if they are not those that the branch had."""
        s, unstable = curve.arclength, (np.abs(curve.multipliers) > 1).sum(axis=1)
        brackets = list[Bracket]()
        for i, (before, after) in enumerate(pairwise(unstable.tolist())):
            ends = slice(i, i + 2)
            for kind, change in CHANGES.items():
                values = curve.tests[ends, TESTS.index(kind)]
                if abs(after - before) == change and values[0] * values[1] < 0:
                    parts = curve.z[ends], curve.tangents[ends], s[ends], values
                    brackets.append(Bracket(0, self.orbits, kind, *parts, (before, after)))
        if [item.kind for item in brackets] != [item.type for item in special] or _may_hide(curve):
            return None
        length = float(s[-1])
        batch, near = OrbitBatch.of_branch(self.orbits), 1e-3 * DRAFT.distinct * length
        zeros = locate_zeros(batch, brackets, near=near)
        located = [item for item in zeros if not isinstance(item, LostCurveError)]
        apart = np.diff([item.point.arclength for item in located])
        failed = len(located) < len(brackets) or (apart < DRAFT.distinct * length).any()
        return None if failed else located

    def _normal_forms(
        self, special: Sequence[SpecialPoint], located: Sequence[Found]
    ) -> list[tuple[float, str | None]] | None:
        """Return coefficients and criticality; None if the number of folds changes.

        A doubled branch gains or loses one where its period doubling turns from soft to hard.
        """
        forms = []
        for item, at in zip(special, located, strict=True):
            try:
                form = normal_form(self.orbits, at.point, item.type)
            except np.linalg.LinAlgError:
                return None  # a second multiplier is critical
            if item.type == "PD" and item.leads_to is not None and form[1] != item.criticality:
                return None
            forms.append(form)
        return forms

    def _assembled(
        self,
        curve: _Curve,
        special: Sequence[SpecialPoint],
        located: Sequence[Found],
        forms: Sequence[tuple[float, str | None]],
        complete: bool,
    ) -> Branch:
        orbits, known, values = self.orbits, self.known, curve.z[:, -1] * self.orbits.width
        unfinished = End("unfinished", REASON, float(values[-1]))
        return replace(
            known,
            model=orbits.model,
            parameter=values,
            nodes=np.array([orbits.nodes(item) for item in curve.z]),
            multipliers=curve.multipliers,
            residual=np.full(len(curve.z), np.nan),
            arclength=curve.arclength,
            special=tuple(
                replace(
                    item,
                    model=orbits.model_at(at.point.z),
                    value=orbits.value(at.point.z),
                    uncertainty=np.nan,
                    nodes=orbits.nodes(at.point.z),
                    multipliers=at.point.multipliers,
                    residual=np.nan,
                    arclength=at.point.arclength,
                    coefficient=coefficient,
                    criticality=criticality,
                )
                for item, at, (coefficient, criticality) in zip(
                    special, located, forms, strict=True
                )
            ),
            started=_moved_end(known.started, values[0]),
            stopped=_moved_end(known.stopped, values[-1]) if complete else unfinished,
        )


def _thinned(s: Array, at_special: list[float]) -> list[int]:
    """Choose points of a branch: both ends, and others not too near to another choice.

    Between two special points at least one is chosen, so that they are distinguished.
    """
    apart = DRAFT.apart * float(np.ptp(s))
    chosen = [0, len(s) - 1]
    taken = [float(s[0]), float(s[-1]), *at_special]
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
    return sorted(chosen)


def _forward(z: Array, tangents: Array, first: Array | None, last: Array | None) -> list[int]:
    """Return the orbits in order, without those that have overtaken a neighbor or an end."""
    chosen: list[int] = []
    for i in range(len(z)):
        before = first is None or (z[i] - first) @ tangents[i] > 0
        after = last is None or (last - z[i]) @ tangents[i] > 0
        if not (before and after):
            continue
        while chosen and (z[i] - z[chosen[-1]]) @ tangents[chosen[-1]] <= 0:
            chosen.pop()
        chosen.append(i)
    return chosen


def _coherent(z: Array, before: Array) -> bool:
    """Whether neighbors are still neighbors."""
    apart = np.linalg.norm(np.diff(z, axis=0), axis=1)
    longest = float(np.linalg.norm(np.diff(before, axis=0), axis=1).max())
    return bool((apart < DRAFT.spread * longest + DRAFT.close).all())


def _may_hide(curve: _Curve) -> bool:
    """Whether a test function seems to have two zeros between two orbits."""
    s, tests = curve.arclength, curve.tests[:, [TESTS.index(kind) for kind in CHANGES]]
    for i in range(len(s) - 1):
        near = slice(min(max(i - 1, 0), len(s) - 4), max(i + 3, 4))
        between = polynomial(s[near], tests[near], np.linspace(s[i], s[i + 1], 10)[1:-1])
        same = tests[i] * tests[i + 1] > 0
        if (same & (between * tests[i] < 0).any(axis=0)).any():
            return True
    return False


def _moved_end(end: End, value: float) -> End:
    return end if end.kind == "span" else End(end.kind, end.reason, float(value))
