"""Orbits of a branch between its points, and at values of its parameter."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import partial
from itertools import pairwise

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.branch import Branch
from slipfold.continuation.newton import correct
from slipfold.errors import BREAKDOWNS, InputError
from slipfold.orbits.continued import fitted, hold_parameter
from slipfold.orbits.find import as_orbit
from slipfold.orbits.kinds import orbits_of
from slipfold.orbits.modal_shooting import shooting_for
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.periodic_orbit import PeriodicOrbit, StickSlipOrbit
from slipfold.orbits.switched_shooting import SwitchedShooting

AT_ORBIT = 1e-6
"""Distance from a known orbit, over the length of the branch, at which that orbit is returned."""

NEAR = 0.1
"""Maximum distance of an orbit with a requested value, in scaled variables, unless the points
around it are farther apart."""


def orbit_between(branch: Branch, arclength: float, value: float | None = None) -> PeriodicOrbit:
    """Find the orbit at any arclength of a branch.

    The chord between the two nearest known orbits is the guess; Newton's method corrects it across
    the chord, so that it works at folds too.
    """
    known = _known(branch)
    if not known:
        raise InputError(f"branch {branch.id} has 0 points, so there is no orbit on it")
    s = np.array(list(known))
    nearest = int(np.abs(s - arclength).argmin())
    exact = abs(s[nearest] - arclength) <= AT_ORBIT * float(np.ptp(s))
    if exact or not s[0] < arclength < s[-1]:
        return _with_value(branch, known[s[nearest]](), value, NEAR)
    after = int(np.searchsorted(s, arclength))
    ends, apart = s[after - 1 : after + 1], float(s[after] - s[after - 1])
    before, behind = (known[end]() for end in ends)
    orbit = _corrected(branch, before, behind, float(arclength - ends[0]) / apart)
    return _with_value(branch, orbit, value, max(NEAR, apart))


def passes(
    branch: Branch, value: float
) -> Iterator[tuple[float, PeriodicOrbit, PeriodicOrbit, float]]:
    """Yield where a branch passes a value of its parameter, in order.

    That is an arclength, the two nearest known orbits, folds among them, and the fraction of the
    chord from one to the other; twice the same orbit where it has the value. Left out is where one
    of them has no model: a branch may end on a bound that excludes its end.
    """
    known = _known(branch)
    for place, before, after, fraction in _intervals(branch, value):
        with suppress(InputError):
            yield place, known[before](), known[after](), fraction


def _intervals(branch: Branch, value: float) -> Iterator[tuple[float, float, float, float]]:
    """Yield the same with the arclengths of the two orbits."""
    away = dict(zip(branch.arclength.tolist(), (branch.parameter - value).tolist(), strict=True))
    away |= {point.arclength: point.value - value for point in branch.special}
    places = sorted(away)
    folds = {item.arclength for item in branch.special if item.type == "LP"}
    for before, after in pairwise([*places, *places[-1:]]):
        first, last = away[before], away[after]
        if first == 0:
            yield before, before, before, 0.0
        elif first * last < 0:
            fraction = first / (first - last)
            if after in folds:  # the parameter is a parabola with its vertex there
                fraction = 1 - (1 - fraction) ** 0.5
            elif before in folds:
                fraction **= 0.5
            yield before + fraction * (after - before), before, after, fraction


def orbits_at(branch: Branch, value: float) -> Iterator[PeriodicOrbit]:
    """Yield the orbits of a branch at a value of its parameter, as far as they are found."""
    width = float(np.ptp(branch.parameter))
    for arclength, *_ in _intervals(branch, value):
        with suppress(*BREAKDOWNS):
            orbit = orbit_between(branch, arclength, value)
            if abs(orbit.model.values[branch.vary] - value) <= AT_ORBIT * width:
                yield orbit


def _known(branch: Branch) -> dict[float, Callable[[], PeriodicOrbit]]:
    """Return what makes the orbits of points and special points, in order of their arclengths."""
    orbits = {float(s): partial(branch.orbit, i) for i, s in enumerate(branch.arclength)}
    orbits |= {point.arclength: partial(getattr, point, "orbit") for point in branch.special}
    return dict(sorted(orbits.items()))


def _corrected(
    branch: Branch, before: PeriodicOrbit, after: PeriodicOrbit, fraction: float
) -> PeriodicOrbit:
    orbits, (start, end) = _orbits(branch, before, after)
    chord = orbits.in_phase(end, start) - start
    found = correct(orbits, start + fraction * chord, chord / np.linalg.norm(chord))
    if not found.converged:
        raise InputError(
            f"no orbit was found between two points of branch {branch.id}: {found.failure}; "
            "choose an arclength nearer to a point"
        )
    return as_orbit(orbits, found)


def _with_value(
    branch: Branch, orbit: PeriodicOrbit, value: float | None, reach: float
) -> PeriodicOrbit:
    """Return the orbit with a value of the parameter, if there is one near a given orbit."""
    if value is None or value == orbit.model.values[branch.vary]:
        return orbit
    orbits, (guess,) = _orbits(branch, orbit)
    guess[-1] = value / orbits.width
    found = correct(orbits, guess, hold_parameter(len(guess) - 1))
    return as_orbit(orbits, found) if found.converged and found.distance < reach else orbit


def _orbits(branch: Branch, *known: PeriodicOrbit) -> tuple[Orbits, list[Array]]:
    """Return the equations of a branch, scaled as at the first of some orbits, and these."""
    width, first = float(np.ptp(branch.parameter)) or 1.0, known[0]
    given = first.model, {branch.vary: width}, branch.period
    if any(isinstance(orbit, StickSlipOrbit) for orbit in known):
        return _switched(orbits_of(*given, 1, by=SwitchedShooting), known)
    by, resting = shooting_for(first.model), branch.kind == "equilibrium"
    # Special points keep their own number of nodes; points of a branch have that of the finest.
    even = [orbits_of(*given, len(orbit.nodes), resting=resting, by=by) for orbit in known]
    found = [each.unknown(item.nodes, item.model) for each, item in zip(even, known, strict=True)]
    orbits, _ = fitted(even[0], found[0])
    return orbits, [orbits.adopt(each, z) for each, z in zip(even, found, strict=True)]


def _switched(orbits: Orbits, known: Sequence[PeriodicOrbit]) -> tuple[Orbits, list[Array]]:
    """Return orbits through stick and slip from where no contact of the first changes its mode."""
    by = orbits.by
    assert isinstance(by, SwitchedShooting)
    constants = [orbits.flow.constants_of(orbit.model) for orbit in known]
    other = by.better(known[0].nodes[:1], constants[0]) or by
    nodes = [
        by.states(orbit.nodes[:1], own, other.start)
        for orbit, own in zip(known, constants, strict=True)
    ]
    orbits = orbits.described_by(other)
    return orbits, [
        orbits.unknown(node, orbit.model) for node, orbit in zip(nodes, known, strict=True)
    ]
