"""Which parts of a result are computed again: as many as a tenth of its work pays for."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from slipfold.checks.checked import Check, Checked
from slipfold.checks.orbit_difference import (
    ALLOWED,
    Difference,
    orbit_difference,
    pieces_of,
    retraced_difference,
)
from slipfold.checks.switched_difference import switched_difference
from slipfold.orbits.periodic_orbit import PeriodicOrbit, StickSlipOrbit

SHARE = 0.1
"""Share of the work for a result that goes into its checks."""

ONCE, EACH, LARGE = 0.35, 0.0125, 20
"""A check of an orbit of n states in N pieces takes the time of ONCE + N EACH (1 + n / LARGE)
points of a branch of period 1, as measured with 2 to 20 states. Work is counted, not timed, so that
the same is checked on every machine."""

QUICK, SWITCHED = 0.1, 1.0
"""The same of an equilibrium, and of an orbit through stick and slip."""


LEVELS = 4
"""Halvings in `spread`: 17 places at most."""


class Candidate(NamedTuple):
    """An orbit that may be checked."""

    name: str
    orbit: PeriodicOrbit
    resting: bool


def check_some(
    candidates: Iterable[Candidate],
    points: float,
    tell: Callable[[int], None] = lambda done: None,
) -> Checked:
    """Check orbits in their order as long as the work for so many points of a branch allows it.

    The first is checked in any case; if it is too expensive, only its motion is. Whoever interrupts
    it has what is done.
    """
    left, checks = SHARE * points, list[Check]()
    try:
        for candidate in candidates:
            if left < QUICK and checks:
                break
            tell(len(checks))
            cost, check = _check(candidate, left, first=not checks)
            left -= cost
            checks += [] if check is None else [check]
    except KeyboardInterrupt:
        return Checked(tuple(checks), interrupted=True)
    return Checked(tuple(checks))


def spread(count: int) -> list[int]:
    """Choose some of a row in their order: the last, the first, then halfway between others.

    >>> spread(100)[:5]
    [99, 0, 49, 24, 74]
    """
    shares = [1.0, 0.0]
    for level in range(1, LEVELS + 1):
        shares += [odd / 2**level for odd in range(1, 2**level, 2)]
    return list(dict.fromkeys(int(share * (count - 1)) for share in shares))


def _check(candidate: Candidate, left: float, *, first: bool) -> tuple[float, Check | None]:
    """Return the cost of a check and the check, if that much is left; never an exception."""
    orbit = candidate.orbit
    try:
        with np.errstate(all="ignore"):  # numbers of a wrong orbit may overflow
            if isinstance(orbit, StickSlipOrbit):
                found = switched_difference(orbit)
                return SWITCHED, _named(candidate, "other steps", found)
            pieces = 0 if candidate.resting else pieces_of(orbit)
            each = EACH * (1 + len(orbit.state) / LARGE)
            cost = QUICK if candidate.resting else ONCE + each * pieces if pieces else np.inf
            if cost <= left:
                found = orbit_difference(orbit, pieces)
                if found.excess > 1 and found.what == "multipliers":
                    found = orbit_difference(orbit, pieces, orbit.multiplier_uncertainty)
                return cost, _named(candidate, "collocation", found)
            if first:
                found = retraced_difference(orbit)
                return 0.0, _named(candidate, found.method, found)
    except np.linalg.LinAlgError:
        return left, Check(candidate.name, "collocation", np.inf, ALLOWED)
    return 0.0, None


def _named(candidate: Candidate, method: str, found: Difference) -> Check:
    return Check(candidate.name, method, found.value, found.allowed, found.what, found.unknown)
