"""What motions settle on, verified: orbits, cycles, equilibria, tori and chaos, each once."""

from __future__ import annotations

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.equilibrium import equilibrium_near
from slipfold.flow.flow import flow_of
from slipfold.long_term.attractor import at_rest, of_exponents, of_orbit, strobes_of
from slipfold.long_term.exponents import find_exponents
from slipfold.long_term.known import SAME, Known, KnownCloud, KnownCycle, KnownPoint
from slipfold.models.model import Model
from slipfold.models.turns import without_turns
from slipfold.orbits.find import may_slip, periodic_orbit
from slipfold.orbits.orbit_batch import orbits_from
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.text.stability import stability_word

LONGEST = 16
"""Longest period, in forcing periods, that is tried where motions nearly repeat."""

CANDIDATES = 3
"""Periods tried at a time."""

NEARLY = 0.03
"""A motion that moves by less in a period of its own, in scaled states, has an orbit nearby, which
Newton's method finds."""

NEAR = 10.0
"""Distance from it, in such movements, within which an orbit that is known is the one."""

BESIDE = 3e-3
"""Distance from a cycle, in scaled states, within which it is the one."""

CLOSED = 0.03
"""A motion that comes back this near, over its extent, is near a cycle."""

FINELY = 64
"""Samples in an interval in which that is seen."""

POINT = 1e-5
"""Extent, in scaled states, of a cycle that is none: Newton's method turns about an equilibrium."""

EXPONENTS = (2000, 8000)
"""Periods from which is told, one after the other, whether a motion is a torus or chaos."""

TOLERANCE = 1e-8
"""Error of exponents below which no more are needed."""


class Verified:
    """The attractors that are known so far."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.known: list[Known] = []
        self._slips = may_slip(model)  # else each orbit turns, sticking or not

    def settling(self, states: Array, sticks: bool) -> Known | None:
        """Return what attracts a motion and is not known, if its last states tell that.

        Shapes: states (m, n).
        """
        if not self.model.forced:
            return self._at_rest(states[-1]) or self._cycle(states, sticks)
        gaps = self._gaps(states)
        for k in np.flatnonzero(gaps < NEARLY)[:CANDIDATES]:
            if self._is_known(states[-1], NEAR * gaps[k] + SAME):
                return None
            known = self._orbit(states[-1], int(k) + 1, sticks)
            if known is not None:
                return known
        return None

    def measured(self, state: Array, sticks: bool) -> Known | None:
        """Return the torus or chaos that a motion is on by its exponents, known or not.

        Where they tell that it repeats, its orbit if that is not known. Shapes: state (n,).
        """
        for periods in EXPONENTS:
            try:
                found = find_exponents(self.model, state, periods, TOLERANCE)
            except InputError:
                return None
            if found.verdict.kind == "periodic" and found.verdict.period is not None:
                return self._orbit(found.state, found.verdict.period, sticks)
            if found.verdict.kind in ("torus", "chaos"):
                cloud = KnownCloud(found.model, of_exponents(found, self._next))
                clouds = [known for known in self.known if isinstance(known, KnownCloud)]
                return next((known for known in clouds if known.holds(cloud)), cloud)
        return None

    @property
    def _next(self) -> int:
        return len(self.known) + 1

    def _gaps(self, states: Array) -> Array:
        """Return how far a motion moved over 1, 2, ... of its last periods, in scaled states."""
        before = states[-2 : -2 - LONGEST : -1]
        apart = without_turns(states[-1] - before, self.model.whole_turns)
        return np.asarray(np.abs(apart / self.model.state_scales()).max(axis=1))

    def _orbit(self, state: Array, period: int, sticks: bool) -> Known | None:
        if not sticks and self._slips:
            (nodes,) = orbits_from(self.model, period, state[None])
            if nodes is None:
                return None
            state = nodes[0]
        try:
            orbit = periodic_orbit(self.model, period, state)
        except InputError:
            return None
        strobes = strobes_of(orbit)
        apart = without_turns(strobes - orbit.state, self.model.whole_turns)
        away = np.abs(apart / self.model.state_scales()).max(axis=1)
        for shorter in range(1, period):
            if period % shorter == 0 and away[shorter] < SAME:
                return self._orbit(orbit.state, shorter, sticks)
        if not _attracts(orbit) or self._is_known(orbit.state, SAME):
            return None
        return KnownPoint(orbit.model, of_orbit(orbit, self._next))

    def _at_rest(self, state: Array) -> Known | None:
        rest = equilibrium_near(self.model, state)
        if rest is None or rest.growth >= 0 or rest.distance >= NEARLY:
            return None
        if self._is_known(rest.state, SAME):
            return None
        return KnownPoint(self.model, at_rest(self.model, rest.state, self._next))

    def _cycle(self, states: Array, sticks: bool) -> Known | None:
        state = states[-1]
        duration = None if sticks else self._round(states)  # one that sticks is simulated on
        if (duration is None and not sticks) or self._is_known(state, BESIDE):
            return None
        try:
            orbit = periodic_orbit(self.model, state=state, duration=duration)
        except InputError:
            return None
        extent = np.ptp(orbit.nodes, axis=0) / self.model.state_scales()
        if extent.max() < POINT or not _attracts(orbit) or self._is_known(orbit.state, BESIDE):
            return None
        return KnownCycle(self.model, orbit, of_orbit(orbit, self._next))

    def _round(self, states: Array) -> float | None:
        """Return after how many seconds the end of a motion comes nearly back, if it does."""
        flow, count = flow_of(self.model), len(states) - 1
        constants = flow.constants_of(self.model)
        finely = flow.sample(states[:-1], np.zeros(count), np.ones(count), FINELY, constants)
        passed = finely.reshape(-1, states.shape[1])[::-1]
        apart = without_turns(passed - states[-1], self.model.whole_turns)
        away = np.linalg.norm(apart / self.model.state_scales(), axis=1)
        left = np.flatnonzero(away > 0.5 * away.max())
        near = (
            left[0] + np.flatnonzero(away[left[0] :] < CLOSED * away.max()) if len(left) else left
        )
        if away.max() < POINT or not len(near):
            return None
        (ends,) = np.nonzero(np.diff(near) > 1)
        first = near[: ends[0] + 1] if len(ends) else near
        nearest = int(first[away[first].argmin()])
        return (nearest + 1) * constants.period / FINELY

    def _is_known(self, state: Array, reach: float) -> bool:
        points = [known for known in self.known if not isinstance(known, KnownCloud)]
        return any(float(known.distance(state)) < reach for known in points)


def _attracts(orbit: PeriodicOrbit) -> bool:
    return stability_word(orbit.multipliers, cycle=not orbit.model.forced) == "stable"
