"""One branch from its first point to its end: what is watched along it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from slipfold.branches.bifurcations import CLOSED, Bifurcations
from slipfold.branches.change import Change, Growing
from slipfold.branches.closed_branches import (
    Birth,
    MeetsCopy,
    Returns,
    close_on_parent,
    has_copy,
    noise_beside_birth,
    step_beside_parent,
)
from slipfold.branches.ends import BranchEndings
from slipfold.branches.event import Event
from slipfold.branches.events import Events
from slipfold.branches.homoclinic import Homoclinic, nears_homoclinic
from slipfold.branches.seams import Seams
from slipfold.branches.settings import Settings
from slipfold.branches.stops import Families, Limits, Undetermined, Unresolved
from slipfold.continuation.follow import BIRTH, follow
from slipfold.continuation.monitor import Monitor
from slipfold.continuation.trail import Trail
from slipfold.continuation.walk import Failure, walk
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits

LEVEL = 1e-7
"""Share of the tangent along the parameter below which rounding may decide its sign, so near to
where another branch passes and Newton's method is singular."""


def trace_branch(
    orbits: Orbits,
    start: OrbitPoint,
    span: tuple[float, float],
    settings: Settings,
    *,
    departs: bool = False,
    births: Sequence[Birth] = (),
    events: Sequence[Event] = (),
    watch: Callable[[Trail[OrbitPoint]], None] = lambda trail: None,
    through_stick: bool = False,
) -> Trail[OrbitPoint]:
    """Follow a branch to its end."""
    change = Change(settings, through_stick=through_stick)
    return follow(
        orbits,
        start,
        orbits.bounds(span),
        lambda curve: [
            *_monitors(curve, span, settings, departs, births, events),
            *([Growing(curve)] if change.may_come(curve) else []),
        ],
        settings=settings,
        departs=departs,
        first_step=partial(_first_step, orbits, start, settings) if departs else None,
        cap=step_beside_parent if has_copy(orbits) else None,
        endings=BranchEndings(span, settings),
        otherwise=change.otherwise,
        watch=watch,
    )


def _monitors(
    orbits: Orbits,
    span: tuple[float, float],
    settings: Settings,
    departs: bool,
    births: Sequence[Birth],
    events: Sequence[Event],
) -> list[Monitor[OrbitPoint]]:
    """What is watched along a branch: what ends it early first, what takes longest last."""
    monitors: list[Monitor[OrbitPoint]] = [
        Seams(orbits),
        Unresolved(orbits, partial(nears_homoclinic, orbits)),
    ]
    if has_copy(orbits):
        monitors.append(MeetsCopy(orbits, partial(close_on_parent, orbits, births)))
    if not departs:  # else it comes back to a branch point
        monitors.append(Returns(orbits, CLOSED))
    monitors.append(Limits(orbits))
    if events:
        monitors.append(Events(orbits, events))
    monitors.append(Bifurcations(orbits, span))
    if orbits.model.forced:
        monitors.append(Undetermined(orbits))
    return [*monitors, Homoclinic(orbits, settings.largest_duration), Families(orbits)]


def _first_step(orbits: Orbits, start: OrbitPoint, settings: Settings) -> float:
    """Leave another branch by a step so short that nothing else can happen within it.

    All multipliers of the orbit but the critical one are near those where the branches meet, so the
    number outside the circle may differ by that one alone; and the parameter goes on in the
    direction in which it began, else a fold lies between. Otherwise the step is shortened.
    """
    others = np.delete(start.multipliers, np.abs(start.multipliers - 1).argmin())
    outside = int(np.count_nonzero(np.abs(others) > 1))
    step = BIRTH
    for _ in range(6):
        first = next(iter(walk(orbits, [start], step, (), settings)))
        if not isinstance(first, Failure) and first.unstable in (outside, outside + 1):
            nearer = next(iter(walk(orbits, [start], step / 4, (), settings)))
            if isinstance(nearer, Failure) or _goes_on(nearer, first):
                return step
        step /= 4
    return BIRTH


def _goes_on(nearer: OrbitPoint, first: OrbitPoint) -> bool:
    """Whether the parameter moves in the same direction at both, or hardly at one of them."""
    slopes = float(nearer.tangent[-1]), float(first.tangent[-1])
    level = max(LEVEL, noise_beside_birth(nearer)[1])
    return slopes[0] * slopes[1] > 0 or min(map(abs, slopes)) < level
