"""Drafts of a response: its branches at neighboring parameter values, corrected all at once.

A branch that is followed costs one orbit after the other. Where the branches at neighboring
parameter values are known, all their orbits are good guesses, and Newton's method corrects them
together. Bifurcations are located again, to the accuracy of a drawing. Where one appears or
vanishes, or the criticality of a period doubling changes, there is no draft: the response has to be
followed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.branches.batched_points import locate_zeros
from slipfold.branches.batched_walk import Bracket, Located
from slipfold.branches.branch import Branch
from slipfold.branches.special_point import BIFURCATIONS, SpecialPoint
from slipfold.continuation.end import End
from slipfold.continuation.interpolation import polynomial
from slipfold.models.model import Model
from slipfold.orbits.kinds import ForcedOrbits
from slipfold.orbits.limits import broken_limit
from slipfold.orbits.normal_forms.normal_form import normal_form
from slipfold.orbits.orbit_batch import TESTS, Corrected, OrbitBatch, correct_orbits

APART = 0.02
"""Least distance of the points that are corrected, over the length of the branch. Steps are short
where test functions change quickly; a drawn line needs fewer points."""

DISTINCT = 1e-3
"""Least distance of two special points, over the length of the branch; a thousandth of it is the
error to which they are located, in one secant more than what a drawing shows."""

SPREAD, CLOSE = 3.0, 0.05
"""Neighbors that move this many times as far apart as they were are no longer neighbors, unless
they are this close, in scaled variables."""

DROPPED = 0.4
"""Largest fraction of the points that may be missing at the end of a branch."""

REASON = "a draft, from neighboring parameter values, as far as that is sure"

CHANGES = {"PD": 1, "NS": 2, "LP": 1}
"""Multipliers that cross the unit circle at each type of special point that a draft may have."""


@dataclass(frozen=True, eq=False)
class _Curve:
    """Orbits of one branch in order."""

    orbits: ForcedOrbits
    z: Array  # shape (k, u)
    tangents: Array  # unit tangents of the branch, shape (k, u)
    multipliers: NDArray[np.complex128]  # shape (k, n)
    tests: Array  # test functions, shape (k, len(TESTS))
    reach: float  # arclength of the known branch up to which there are orbits
    whole: bool  # whether that is all of it

    @property
    def arclength(self) -> Array:
        """Sums of the chords, shape (k,)."""
        steps = np.linalg.norm(np.diff(self.z, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)])


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
        special = [item for item in branch.special if item.type in BIFURCATIONS]
        if any(item.type not in CHANGES for item in special):
            return None
        curve = _corrected(branch, special, model, drafts)
        draft = None if curve is None else _as_branch(branch, special, curve)
        if draft is None:
            return None
        drafts.append(draft)
    return tuple(drafts)


# -- orbits ------------------------------------------------------------------------------------


def _corrected(
    branch: Branch, special: list[SpecialPoint], model: Model, parents: Sequence[Branch]
) -> _Curve | None:
    """Correct the points of a branch and its special points at the new parameter values."""
    places, nodes, values = _knots(branch, special)
    if len(places) < 4:
        return None  # too few to draw a line through
    width = float(np.ptp(branch.parameter))
    orbits = ForcedOrbits(model, {branch.vary: width}, branch.period, nodes.shape[1])
    guesses = np.array([orbits.pack(*item) for item in zip(nodes, values, strict=True)])
    born, closed = _births(branch, parents, orbits, guesses)
    if branch.parent is not None and born is None:
        return None  # the draft of its parent does not reach that far
    inner = slice(int(born is not None), len(guesses) - int(closed is not None))
    found = correct_orbits(orbits, guesses[inner], _rows(branch, guesses)[inner])
    count = _sure(branch, orbits, found)
    if count < (1 - DROPPED) * len(found.z):
        return None
    whole = count == len(found.z)
    ends = _ends(orbits, found.z[0], found.z[count - 1], born, closed if whole else None)
    forward = _forward(found.z[:count], found.tangents[:count], *ends)
    if len(forward) < 4:
        return None
    curve = _Curve(
        orbits,
        found.z[forward],
        found.tangents[forward],
        found.multipliers[forward],
        found.tests[forward],
        float(places[inner][count - 1]),
        whole,
    )
    curve = _with_ends(curve, *ends)
    return curve if _coherent(curve, guesses) else None


def _knots(branch: Branch, special: list[SpecialPoint]) -> tuple[Array, Array, Array]:
    """Arclengths, nodes and parameter values of known orbits in order, none needlessly close."""
    taken = [item.arclength for item in special]
    chosen = _thinned(branch.arclength, taken)
    places = np.concatenate([branch.arclength[chosen], taken])
    order = np.argsort(places)
    nodes = np.concatenate([branch.nodes[chosen], *(item.nodes[None] for item in special)])
    values = np.concatenate([branch.parameter[chosen], [item.value for item in special]])
    return places[order], nodes[order], values[order]


def _thinned(s: Array, taken: list[float]) -> list[int]:
    """Choose points of a branch: both ends, and others not too near to what is chosen.

    Between two special points at least one is chosen, so that they are distinguished.
    """
    apart = APART * float(np.ptp(s))
    chosen = [0, len(s) - 1]
    held = [float(s[0]), float(s[-1]), *taken]
    for left, right in pairwise(sorted(held)):
        inside = np.flatnonzero((s > left) & (s < right))
        if len(inside):
            middle = int(inside[np.abs(s[inside] - 0.5 * (left + right)).argmin()])
            chosen.append(middle)
            held.append(float(s[middle]))
    for i in range(1, len(s) - 1):
        if min(abs(place - s[i]) for place in held) >= apart:
            chosen.append(i)
            held.append(float(s[i]))
    return sorted(chosen)


def _rows(branch: Branch, z: Array) -> Array:
    """Directions of the branch; at an end of the span the parameter is kept instead."""
    rows = np.gradient(z, axis=0)
    for index, end in ((0, branch.begun), (-1, branch.stopped)):
        if end.kind == "span":
            rows[index] = 0.0
            rows[index, -1] = 1.0
    return np.asarray(rows / np.linalg.norm(rows, axis=1)[:, None])


def _within(branch: Branch, values: Array) -> NDArray[np.bool_]:
    """Whether values lie between those of the branch, or beyond an end that is no end of a span."""
    low, high = branch.parameter.min(), branch.parameter.max()
    spans = {end.value for end in (branch.begun, branch.stopped) if end.kind == "span"}
    slack = 1e-9 * (high - low)
    above = values >= low - slack if low in spans else np.ones(len(values), bool)
    below = values <= high + slack if high in spans else np.ones(len(values), bool)
    return np.asarray(above & below)


def _sure(branch: Branch, orbits: ForcedOrbits, found: Corrected) -> int:
    """Return how many orbits from the start are found, in the span and within the limits.

    Near a limit, as where the spring collapses, orbits change too quickly for a draft.
    """
    good = found.found & _within(branch, found.z[:, -1] * orbits.width)
    count = int(np.argmin(good)) if not good.all() else len(good)
    # A branch that was followed keeps its limits up to its end: only those near it are looked at.
    while count and orbits.model.limits and broken_limit(orbits, found.z[count - 1]):
        count -= 1
    return count


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


def _coherent(curve: _Curve, before: Array) -> bool:
    """Whether neighbors are still neighbors."""
    if len(curve.z) < 4:
        return False
    apart = np.linalg.norm(np.diff(curve.z, axis=0), axis=1)
    longest = float(np.linalg.norm(np.diff(before, axis=0), axis=1).max())
    return bool((apart < SPREAD * longest + CLOSE).all())


# -- where doubled branches begin and end --------------------------------------------------------


def _births(
    branch: Branch, parents: Sequence[Branch], orbits: ForcedOrbits, z: Array
) -> tuple[SpecialPoint | None, SpecialPoint | None]:
    """Return the period doublings of drafts on which a doubled branch begins and ends."""
    if branch.parent is None or branch.parent > len(parents):
        return None, None
    joined = [item for item in parents[branch.parent - 1].special if item.leads_to == branch.id]
    if not joined:
        return None, None
    values = z[[0, -1], -1] * orbits.width
    born = min(joined, key=lambda item: abs(item.value - values[0]))
    others = [item for item in joined if item is not born]
    closed = others[0] if others and branch.stopped.kind == "closed" else None
    return born, closed


def _ends(
    orbits: ForcedOrbits,
    first: Array,
    last: Array,
    born: SpecialPoint | None,
    closed: SpecialPoint | None,
) -> tuple[Array | None, Array | None]:
    """Return the orbits of the parent's period doublings, passed twice, where a branch ends."""
    return (
        None if born is None else _doubled(orbits, born, first),
        None if closed is None else _doubled(orbits, closed, last),
    )


def _with_ends(curve: _Curve, first: Array | None, last: Array | None) -> _Curve:
    """Join orbits to the ends of a curve."""
    for z, end in ((first, 0), (last, -1)):
        if z is None:
            continue
        at = 0 if end == 0 else len(curve.z)
        # No test function changes its sign there: the orbit takes those of its neighbor.
        curve = replace(
            curve,
            z=np.insert(curve.z, at, z, axis=0),
            tests=np.insert(curve.tests, at, curve.tests[end], axis=0),
            tangents=np.insert(curve.tangents, at, curve.tangents[end], axis=0),
            multipliers=np.insert(curve.multipliers, at, curve.multipliers[end], axis=0),
        )
    return curve


def _doubled(orbits: ForcedOrbits, point: SpecialPoint, beside: Array) -> Array:
    """Return an orbit passed twice, begun in that forcing period in which it is near another."""
    half = point.nodes[::2]
    nodes = np.concatenate([half, half])
    step = max(len(nodes) // orbits.period, 1)
    shifted = [
        orbits.pack(np.roll(nodes, -shift, axis=0), point.value)
        for shift in range(0, len(nodes), step)
    ]
    near = [orbits.beside(z, beside) for z in shifted]
    return min(near, key=lambda z: float(np.linalg.norm(z - beside)))


# -- special points ------------------------------------------------------------------------------


def _as_branch(before: Branch, special: list[SpecialPoint], curve: _Curve) -> Branch | None:
    """Return the branch with its special points, None if they are not those of before."""
    special = [item for item in special if item.arclength <= curve.reach]
    located = _located(curve, special)
    forms = None if located is None else _normal_forms(curve.orbits, special, located)
    if located is None or forms is None:
        return None
    orbits = curve.orbits
    values = curve.z[:, -1] * orbits.width
    return replace(
        before,
        model=orbits.model,
        parameter=values,
        nodes=np.array([orbits.nodes(item) for item in curve.z]),
        multipliers=curve.multipliers,
        residual=np.full(len(curve.z), np.nan),
        arclength=curve.arclength,
        special=tuple(
            replace(
                item,
                model=orbits.model_at(at.z),
                value=orbits.value(at.z),
                uncertainty=np.nan,
                nodes=orbits.nodes(at.z),
                multipliers=at.multipliers,
                residual=np.nan,
                arclength=at.arclength,
                coefficient=coefficient,
                criticality=criticality,
            )
            for item, at, (coefficient, criticality) in zip(special, located, forms, strict=True)
        ),
        begun=_end(before.begun, values[0]),
        stopped=_end(before.stopped, values[-1])
        if curve.whole
        else End("unfinished", REASON, float(values[-1])),
    )


def _end(end: End, value: float) -> End:
    return end if end.kind == "span" else End(end.kind, end.reason, float(value))


def _located(curve: _Curve, special: Sequence[SpecialPoint]) -> list[Located] | None:
    """Locate all special points at once; None if they are not those that the branch had."""
    s, unstable = curve.arclength, (np.abs(curve.multipliers) > 1).sum(axis=1)
    brackets = list[Bracket]()
    for i, (before, after) in enumerate(pairwise(unstable.tolist())):
        ends = slice(i, i + 2)
        for kind, change in CHANGES.items():
            values = curve.tests[ends, TESTS.index(kind)]
            if abs(after - before) == change and values[0] * values[1] < 0:
                parts = curve.z[ends], curve.tangents[ends], s[ends], values
                brackets.append(Bracket(0, kind, *parts, (before, after)))
    if [item.kind for item in brackets] != [item.type for item in special] or _may_hide(curve):
        return None
    length = float(s[-1])
    batch, near = OrbitBatch.of_branch(curve.orbits), 1e-3 * DISTINCT * length
    located = [item for item in locate_zeros(batch, brackets, near=near) if item is not None]
    apart = np.diff([item.arclength for item in located])
    failed = len(located) < len(brackets) or (apart < DISTINCT * length).any()
    return None if failed else located


def _may_hide(curve: _Curve) -> bool:
    """Whether a test function seems to cross zero and come back between two orbits."""
    s, tests = curve.arclength, curve.tests[:, [TESTS.index(kind) for kind in CHANGES]]
    for i in range(len(s) - 1):
        near = slice(min(max(i - 1, 0), len(s) - 4), max(i + 3, 4))
        between = polynomial(s[near], tests[near], np.linspace(s[i], s[i + 1], 10)[1:-1])
        same = tests[i] * tests[i + 1] > 0
        if (same & (between * tests[i] < 0).any(axis=0)).any():
            return True
    return False


def _normal_forms(
    orbits: ForcedOrbits, special: Sequence[SpecialPoint], located: Sequence[Located]
) -> list[tuple[float, str | None]] | None:
    """Return coefficients and criticality; None where a doubled branch has one fold more or less.

    That is so where the period doubling at which it begins turns from soft to hard, or back.
    """
    forms = []
    for item, at in zip(special, located, strict=True):
        monodromy = orbits.linearize(at.z).monodromy
        point = orbits.derived_point(at.z, at.tangent, item.arclength, monodromy, np.nan)
        try:
            form = normal_form(orbits, point, item.type)
        except np.linalg.LinAlgError:
            return None  # a second multiplier is critical
        if item.type == "PD" and item.leads_to is not None and form[1] != item.criticality:
            return None
        forms.append(form)
    return forms
