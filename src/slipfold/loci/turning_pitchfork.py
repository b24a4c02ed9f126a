"""Where a pitchfork turns soft: a zero on the locus of branch points, at which folds end."""

from __future__ import annotations

import numpy as np

from slipfold.continuation.newton import correct
from slipfold.continuation.search import Found
from slipfold.errors import BREAKDOWNS
from slipfold.loci.locus_equations import LocusEquations
from slipfold.orbits.orbit_curve import OrbitPoint

STEP = 1e-3
"""First step along the branch points, in scaled variables."""

REACH = 0.1
"""Distance along them within which the zero is looked for: folds are that near to them there."""

CLOSE = 1e-12
"""Distance to which it is found."""

STEPS = 20


def turning_pitchfork(found: Found[OrbitPoint], curve: LocusEquations) -> Found[OrbitPoint]:
    """Return a degenerate pitchfork at the end of folds as the locus of branch points has it.

    At their end the equations of folds hold along the branch points as well, and rounding decides
    how far they lead on. It is returned as it was found where that locus does not show it.
    """
    crossing = LocusEquations(curve.orbits, "BP")
    try:
        known = _branch_point(crossing, found.point)
        return found if known is None else _zero(crossing, known) or found
    except BREAKDOWNS:
        return found


def has_branch_point(curve: LocusEquations, point: OrbitPoint) -> bool:
    """Whether families of orbits cross near a point: Newton's method converges to where they do."""
    try:
        crossing = LocusEquations(curve.orbits, "BP")
        there = _branch_point(crossing, point)
        return there is not None and float(np.linalg.norm(there.z - point.z)) < REACH
    except BREAKDOWNS:
        return False


def _branch_point(crossing: LocusEquations, point: OrbitPoint) -> OrbitPoint | None:
    """Return the branch point next to a point, None if Newton's method finds none."""
    z = point.z
    start = correct(crossing, z, np.linalg.svd(crossing.linearise(z).jacobian)[2][-1])
    return crossing.point(start, point.arclength) if start.converged else None


def _zero(curve: LocusEquations, known: OrbitPoint) -> Found[OrbitPoint] | None:
    """Return the zero of the cubic coefficient near a branch point, by secants."""
    places, values, place = [0.0], [known.tests["DP"]], STEP
    for _ in range(STEPS):
        guess = known.z + place * known.tangent
        correction = correct(curve, guess, known.tangent)
        if not correction.converged:
            return None
        point = curve.point(correction, known.arclength)
        places.append(place)
        values.append(point.tests["DP"])
        slope = (values[-1] - values[-2]) / (places[-1] - places[-2])
        if not (np.isfinite(slope) and slope):
            return None
        step = -values[-1] / slope
        if abs(step) < CLOSE or values[-1] == 0.0:
            return Found("DP", point, slope)
        place += step
        if not abs(place) < REACH:
            return None
    return None
