"""Branches that end on a singular point at the very end of the span."""

from __future__ import annotations

from dataclasses import replace
from itertools import takewhile

from slipfold.branches.detection import Bifurcations
from slipfold.continuation.follow import EDGE
from slipfold.continuation.locate import LostCurveError
from slipfold.continuation.search import Found
from slipfold.continuation.settings import Stepping
from slipfold.continuation.walk import Failure, walk
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["end_on_edge"]

NEAR = 0.01
"""Distance from the end of the span, in spans, within which a failure may be due to it."""

CLEAR = 1e-3
"""Points nearer to the end are taken back: beside a branch point their tangents say little."""

LONGEST = 0.1
"""Longest step over the end, in scaled variables."""


def end_on_edge(
    problem: Orbits,
    points: list[OrbitPoint],
    span: tuple[float, float],
    settings: Stepping,
) -> tuple[list[OrbitPoint], list[Found]] | None:
    """Return how a branch ends that failed since a branch point lies on the end of the span.

    With the parameter held Newton's method is singular there. So a step is taken over the end, and
    the branch point is located between.
    """
    edge = min(problem.bounds(span)[0][1:], key=lambda bound: abs(points[-1].z[-1] - bound))

    def away(point: OrbitPoint) -> float:
        return abs(float(point.z[-1]) - edge)

    close = len(list(takewhile(lambda point: away(point) < CLEAR, reversed(points))))
    kept = points[: len(points) - close]
    if away(points[-1]) > NEAR or not kept:
        return None
    before = kept[-1]
    step = min(2 * away(before) / max(abs(before.tangent[-1]), EDGE), LONGEST)
    beyond = next(iter(walk(problem, kept, step, (), settings)))
    if isinstance(beyond, Failure):
        return None
    try:
        found = Bifurcations(problem, span).between([*kept, beyond], before, beyond)
    except LostCurveError:
        return None
    place = next((i for i, item in enumerate(found) if away(item.point) < EDGE), None)
    if place is None:
        return None
    z = found[place].point.z.copy()
    z[-1] = edge  # exactly, whatever rounding did
    last = replace(found[place].point, z=z)
    found[place] = replace(found[place], point=last)
    return [*kept, last], found[: place + 1]
