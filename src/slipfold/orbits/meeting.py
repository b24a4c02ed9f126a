"""Orbits on which two changes of contacts happen at once, between orbits that pass them in turn."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.newton import LeastSquares
from slipfold.flow.modes import Ending
from slipfold.newton import Rule, find_root
from slipfold.orbits.continued import parameter_rounding
from slipfold.orbits.orbit_curve import OrbitPoint
from slipfold.orbits.switched_shooting import SwitchedShooting

MEETS = Rule(close=1e-9, longest=0.1)
"""An orbit has converged after a step this short: the next one is of the order of its square."""

AT_ONCE = 1e-11
"""Phases between two changes that are not distinguished from none."""


class _Change(NamedTuple):
    """A change of a contact on an orbit."""

    contact: int
    ending: Ending
    phase: float


def _changes(by: SwitchedShooting, point: OrbitPoint) -> list[_Change]:
    orbits = point.curve.orbits
    passed = by.round(orbits.nodes(point.z), orbits.constants(point.z))
    events = [(part.event, part.end) for part, _ in passed if part.event is not None]
    return [_Change(event.which, event.ending, end) for event, end in events]


def _swapped(
    by: SwitchedShooting, a: OrbitPoint, b: OrbitPoint
) -> tuple[float, _Change, _Change] | None:
    """Return which two changes swap their order first from an orbit to another, and where."""
    before, after, period = _changes(by, a), _changes(by, b), by.period
    orbits, moved = a.curve.orbits, list[float]()
    if len(before) != len(after):
        return None
    for change in before:
        away = [
            (other.phase - change.phase + period / 2) % period - period / 2
            for other in after
            if other[:2] == change[:2]
        ]
        if not away:
            return None
        moved.append(min(away, key=abs))
    shifts, phases = np.array(moved), np.array([change.phase for change in before])
    first = (phases[:, None] - phases + period / 2) % period - period / 2
    gained = shifts - shifts[:, None]
    group = np.empty(len(by.switched.contacts), dtype=int)
    for number, alike in enumerate(by.switched.groups(orbits.constants(a.z))):
        group[alike] = number
    contacts = np.array([change.contact for change in before])
    own = (contacts[:, None] < contacts) & (group[contacts][:, None] == group[contacts])
    meets = own & (first * (first - gained) < 0)
    if not meets.any():
        return None
    fractions = np.where(meets, first, np.inf) / np.where(meets, gained, 1.0)
    i, j = np.unravel_index(int(fractions.argmin()), fractions.shape)
    part = float(fractions[i, j])
    one, other = (before[k]._replace(phase=phases[k] + part * shifts[k]) for k in (i, j))
    return part, one, other


def meeting_between(a: OrbitPoint, b: OrbitPoint) -> tuple[Array | None, float]:
    """Return the unknown of the orbit on which changes meet that swap between two others.

    Also by how much its parameter is uncertain. None if there is no such orbit.
    """
    curve, by = a.curve, a.curve.orbits.by
    assert isinstance(by, SwitchedShooting)
    found = _swapped(by, a, b)
    if found is None:
        return None, np.inf
    fraction, *pair = found
    matrices = list[Array]()

    def step(z: Array) -> Array:
        orbits, part = curve.orbits, curve.linearize(z)
        given = orbits.nodes(z), orbits.constants(z)
        (early, its), (late, other) = (by.phase_of(*given, one.contact, one.phase) for one in pair)
        if its is None or other is None:  # both are one change, to rounding
            return np.zeros(len(z))
        if not part.is_finite:
            return np.full(len(z), np.nan)
        gap = (late - early + by.period / 2) % by.period - by.period / 2
        matrices.append(np.vstack([part.jacobian, other - its]))
        return np.asarray(
            np.linalg.lstsq(matrices[-1], -np.append(part.defect, gap), rcond=None)[0]
        )

    z = find_root(step, a.z + fraction * (b.z - a.z), MEETS)
    if z is None or not matrices:
        return None, np.inf
    gaps = np.append(np.zeros(len(matrices[-1]) - 1), AT_ONCE)
    return z, parameter_rounding(LeastSquares(matrices[-1]), z, gaps)
