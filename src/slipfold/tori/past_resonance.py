"""Tori beyond an interval in which they are locked at a resonance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.newton import correct
from slipfold.continuation.trail import Trail
from slipfold.errors import BREAKDOWNS
from slipfold.tori.circles import RESONANCES, TAIL, CirclePoint, Circles
from slipfold.tori.harmonics import resampled, tail

NEAR = 2e-3
"""Distance of a rotation number from a resonance at which circles are squeezed by it."""

BEYOND = (1.0, 2.0, 0.5)
"""Times of that distance on the other side where a circle is looked for."""

ROUGH = 1e3 * TAIL
"""Size of the last harmonics at which a circle beyond is taken: it gets more of them there."""

KNOWN = 3
"""Circles before a resonance from which those beyond are expected."""


def past_resonance(trail: Trail[CirclePoint]) -> tuple[Circles, CirclePoint] | None:
    """Return a circle on the other side of the resonance at which tori ended.

    Towards it the states crowd where the locked orbits will be, and harmonics grow; before that the
    circle knows nothing of it, and is continued by the rotation number, across. A strong one may be
    passed like this where nothing happens but that the angles of the circle on it are free.
    """
    if trail.end is None or trail.end.kind not in ("broken", "failed", "resonance"):
        return None
    last = trail.points[-1]
    away = {ratio: last.curve.rotation(last.z) - float(ratio) for ratio in RESONANCES}
    ratio = min(away, key=lambda each: abs(away[each]))
    if abs(away[ratio]) > NEAR:
        return None
    rotation = float(ratio)
    # The last circle may lie on it, or to either side by rounding.
    apart = [point for point in trail.points if abs(point.z[-2] - rotation) > NEAR]
    side = float(np.sign(apart[-1].z[-2] - rotation)) if apart else 0.0
    known = [point for point in apart if side * (point.z[-2] - rotation) > 0][-KNOWN:]
    for times in BEYOND if len(known) > 1 else ():
        found = _at(known, rotation - side * times * NEAR, -side)
        if found is not None:
            length = abs(found.z[-1] - last.z[-1]) + abs(found.z[-2] - last.z[-2])
            return found.curve, replace(found, arclength=last.arclength + length)
    return None


def _at(known: list[CirclePoint], rotation: float, side: float) -> CirclePoint | None:
    """Return the circle of a rotation number as others let expect it."""
    last = known[-1].curve
    circles = last.described_at(known[-1].z, last.count)
    unknowns = []
    for point in known:
        states = resampled(point.curve.states(point.z), circles.count)
        unknowns.append(circles.join(states, point.z[point.curve.size :]))
    guess = _extrapolated(np.array(unknowns), rotation)
    row = np.zeros(len(guess))
    row[-2] = side
    try:
        correction = correct(circles, guess, row)
    except BREAKDOWNS:
        return None
    if not correction.converged or tail(circles.states(correction.z)) > ROUGH:
        return None
    return circles.point(correction, 0.0)


def _extrapolated(known: Array, rotation: float) -> Array:
    """Return the unknown that others let expect at a rotation number. Shapes: known (k, z)."""
    places = known[:, -2]
    weights = [
        np.prod([(rotation - other) / (place - other) for other in places if other != place])
        for place in places
    ]
    return np.asarray(weights @ known)
