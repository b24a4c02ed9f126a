"""The special points of the responses of many cases, found side by side.

Nothing is taken for granted: a case in which anything is out of the ordinary is left, to be
followed by itself. Ordinary are branches in slip that begin at the response of period 1, change by
folds, period doublings and tori alone, and end at an end of the span or at a limit at which nothing
sticks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

import numpy as np

from slipfold.arrays import Array
from slipfold.branches.abreast.assembled import (
    assembled,
    placed_on,
    settle,
    settle_special,
)
from slipfold.branches.abreast.located import Approached, approach
from slipfold.branches.abreast.own_branch import Case, OwnBranch
from slipfold.branches.abreast.walk import MOST, SMALLEST, Start, Walk
from slipfold.branches.bifurcations import ON_CIRCLE, is_torus
from slipfold.branches.branch import Branch
from slipfold.branches.describe import describe
from slipfold.branches.method import forced_orbits
from slipfold.branches.response import measured_over
from slipfold.branches.settings import Settings
from slipfold.branches.special_point import SpecialPoint
from slipfold.errors import BREAKDOWNS, InputError
from slipfold.flow.explicit_steps import LinearisedSteps, linearised_steps_of
from slipfold.flow.flow import flow_of
from slipfold.flow.modes import contacts_of
from slipfold.flow.scales import linear_response
from slipfold.models.model import Model
from slipfold.orbits.continued import hold_parameter
from slipfold.orbits.first_orbits import NEAR
from slipfold.orbits.orbit_batch import ITERATIONS, OrbitBatch
from slipfold.orbits.shooting import SEGMENTS, Shooting

FEWEST = 16
"""Cases from which on they go side by side: four are as quick by themselves, and what is needed
takes seconds to compile."""

TOGETHER = 64
"""Cases that go side by side, at least: of 16 each takes twice as long, of 128 four fifths."""

LONG = 4.0
"""Arclength of a branch, in spans, for which the rounds of steps have to suffice."""


Tell = Callable[[str, float], None]
"""Called with what is done now, and which share of it is."""


@dataclass(frozen=True, eq=False)
class FollowedBranch:
    """A branch as far as its special points go."""

    period: int
    stable: bool  # whether its first orbit is; of one that leaves another that is not known
    ends: str  # how it ends: ``"span"`` or ``"limit"``
    special: tuple[SpecialPoint, ...]  # in order
    unstable: tuple[tuple[int, int], ...]  # multipliers outside the circle around each of these


@dataclass(frozen=True, eq=False)
class FollowedResponse:
    """A response: its branches, numbered in their order."""

    branches: tuple[FollowedBranch, ...]

    @property
    def loss(self) -> SpecialPoint | None:
        """Where the response of period 1, stable at first, loses its stability."""
        first = self.branches[0]
        crossed = zip(first.special, first.unstable, strict=True)
        return next((point for point, (before, after) in crossed if before == 0 < after), None)


def responses_abreast(
    models: Sequence[Model], vary: str, span: tuple[float, float], settings: Settings
) -> list[FollowedResponse | None]:
    """Follow the responses of models of one kind; None of each that has to be followed by itself.

    What is found of a case does not depend on which others are beside it.
    """
    cases = _followed(models, vary, span, settings, whole=False)
    return [_described(case, vary, abs(span[1] - span[0])) for case in cases]


def branches_abreast(
    models: Sequence[Model], vary: str, span: tuple[float, float], settings: Settings
) -> list[tuple[Branch, ...] | None]:
    """Follow them in the same way; return the branches with all their points."""
    return [assembled(case, vary, span) for case in follow_abreast(models, vary, span, settings)]


def follow_abreast(
    models: Sequence[Model],
    vary: str,
    span: tuple[float, float],
    settings: Settings,
    tell: Tell = lambda stage, share: None,
) -> list[Case]:
    """Follow them in the same way; return what the branches with all their points are made of."""
    return _followed(models, vary, span, settings, tell, whole=True)


def _followed(
    models: Sequence[Model],
    vary: str,
    span: tuple[float, float],
    settings: Settings,
    tell: Tell = lambda stage, share: None,
    *,
    whole: bool,
) -> list[Case]:
    """Follow all branches of all cases, the shorter periods first."""
    tell("equations", 0.0)
    steps = _steps_for(models[0], settings)
    if steps is None:
        return [Case(model, lost="another kind of model") for model in models]
    models = [model.replace(**{vary: span[0]}) for model in models]
    models = [
        model if model.found_sizes is not None else measured_over(model, vary, span)
        for model in models
    ]
    cases = [Case(model) for model in models]
    width, forward = abs(span[1] - span[0]), float(np.sign(span[1] - span[0]))
    vectors = np.array([model.vector for model in models])
    scales = np.array([model.state_scales() for model in models])
    orbits = OrbitBatch(models[0], vectors, scales, (vary, width), steps=steps)
    starts = _begun(orbits, cases, vary, width, forward, settings)
    parents: list[tuple[int, int] | None] = [None] * len(starts)
    while starts:
        walk = Walk(orbits, starts, span, settings.steps)
        walk.run(partial(tell, f"branches of period {orbits.period}"))
        stage = f"orbits of period {orbits.period}"
        tell(stage, 0.0)
        found = _approached(orbits, walk)
        fresh = list[OwnBranch]()
        for place, start in enumerate(starts):
            case, fate = cases[start.case], walk.fates[place]
            located = [item for item in found[place] if item is not None]
            genuine = [item for item in located if _is_genuine(item)]
            if fate not in ("span", "limit"):
                case.lost = case.lost or fate
            elif len(located) < len(found[place]):
                case.lost = case.lost or "not located"
            elif any(not min(span) <= item.z[-1] * width <= max(span) for item in located):
                case.lost = case.lost or "turns outside the span"
            elif any(_crosses(item) != _is_genuine(item) for item in located):
                case.lost = case.lost or "not accounted for"
            stable = bool(walk.stable[place])
            fresh.append(OwnBranch(orbits.period, stable, fate, genuine, parents[place]))
            case.branches.append(fresh[-1])
        settle_special(orbits, cases, fresh, settings.newton.tolerance)
        if whole:
            tell(stage, 0.5)
            settle(orbits, walk, cases, fresh, settings.newton.tolerance)
        orbits, starts, parents = _next_starts(orbits, cases, settings)
    return cases


def _steps_for(model: Model, settings: Settings) -> LinearisedSteps | None:
    """Return what carries orbits of such models; None if these are not for this way."""
    slips = all(contact.limits for contact in contacts_of(model))
    if not model.forced or not slips or np.any(model.whole_turns):
        return None
    return linearised_steps_of(model) if _are_kept(settings) else None


def _are_kept(settings: Settings) -> bool:
    """Whether branches that are followed side by side keep to all settings."""
    steps = settings.steps
    return (
        settings.discretisation != "collocation"
        and settings.newton.iterations >= ITERATIONS
        and steps.smallest <= SMALLEST
        and steps.largest * MOST > LONG
    )


def _begun(
    orbits: OrbitBatch,
    cases: Sequence[Case],
    vary: str,
    width: float,
    forward: float,
    settings: Settings,
) -> list[Start]:
    """Find the responses at the first value from the linear ones."""
    flow, size, guesses = flow_of(cases[0].model), orbits.size, dict[int, Array]()
    for number, case in enumerate(cases):
        model = case.model
        case.lost = "no linear response"
        with suppress(InputError, *BREAKDOWNS):
            if isinstance(forced_orbits(model, vary, width, settings).by, Shooting):
                constants, scales = flow.constants(model.vector), model.state_scales()
                nodes = linear_response(flow, constants, scales, SEGMENTS, model.start)
                some = np.array([number])
                value = np.array([model.values[vary]])
                guesses[number], case.lost = orbits.join(some, nodes[None], value)[0], ""
    if not guesses:
        return []
    some, z = np.array(list(guesses)), np.array(list(guesses.values()))
    rows = np.tile(hold_parameter(size) * forward, (len(some), 1))
    found = orbits.correct(some, z, rows, 1e-6, NEAR)
    for row, number in enumerate(some.tolist()):
        if not found.found[row]:
            cases[number].lost = "no response"
    return [
        Start(number, found.z[row], found.tangents[row])
        for row, number in enumerate(some.tolist())
        if found.found[row]
    ]


def _approached(orbits: OrbitBatch, walk: Walk) -> list[list[Approached | None]]:
    """Return what lies within the brackets of each branch that came to an end."""
    kept = [
        item
        for fate, items in zip(walk.fates, walk.brackets, strict=True)
        for item in items
        if fate in ("span", "limit")
    ]
    found: list[list[Approached | None]] = [[] for _ in walk.fates]
    for bracket, item in zip(kept, approach(orbits, kept), strict=True):
        found[bracket.branch].append(item)
    return found


def _is_genuine(item: Approached) -> bool:
    """Whether a multiplier is where the type says: a neutral saddle has no pair on the circle."""
    if item.bracket.kind == "NS":
        return is_torus(item.multipliers)
    target = -1.0 if item.bracket.kind == "PD" else 1.0
    return bool(np.abs(item.multipliers - target).min() < ON_CIRCLE)


def _crosses(item: Approached) -> bool:
    before, after = item.bracket.unstable
    return before != after


def _next_starts(
    orbits: OrbitBatch, cases: Sequence[Case], settings: Settings
) -> tuple[OrbitBatch, list[Start], list[tuple[int, int] | None]]:
    """Return where the branches of twice the period begin."""
    period, starts = 2 * orbits.period, list[Start]()
    parents = list[tuple[int, int] | None]()
    if period > settings.largest_period:
        return orbits, starts, parents
    for number, case in enumerate(cases):
        for place, branch in enumerate(case.branches):
            if case.lost or branch.period != orbits.period:
                continue
            for birth, item in enumerate(branch.special):
                if item.bracket.kind == "PD":
                    starts.append(_doubled(number, item))
                    parents.append((place, birth))
    return orbits.of_period(period), starts, parents


def _doubled(case: int, item: Approached) -> Start:
    """Return an orbit at a period doubling passed twice, as `doubled_orbit` does."""
    m, n = item.blocks.shape[:2]
    monodromy = np.eye(n)
    for block in item.blocks:
        monodromy = block @ monodromy
    values, vectors = np.linalg.eig(monodromy)
    direction = vectors[:, np.argmin(np.abs(values + 1))].real
    along = [direction]
    for block in item.blocks[:-1]:
        along.append(block @ along[-1])
    same = np.resize(np.arange(0, m, 2), m)  # a segment of the child is two of the parent
    signs = np.where(np.arange(m) < m // 2, 1.0, -1.0)
    tangent = np.append((np.array(along)[same] * signs[:, None]).ravel(), 0.0)
    tangent *= np.sign(direction[np.abs(direction).argmax()]) / np.linalg.norm(tangent)
    nodes = item.z[:-1].reshape(m, n)[same]
    return Start(case, np.append(nodes.ravel(), item.z[-1]), tangent, item.multipliers**2)


def _described(case: Case, vary: str, width: float) -> FollowedResponse | None:
    """Return a response with its special points as the flow itself has them."""
    if case.lost:
        return None
    branches = []
    for branch in case.branches:
        found = placed_on(case, branch, vary, width)
        special = tuple(describe(item) for item in found)
        unstable = tuple(item.bracket.unstable for item in branch.special)
        branches.append(
            FollowedBranch(branch.period, branch.stable, branch.fate, special, unstable)
        )
    return FollowedResponse(tuple(branches))
