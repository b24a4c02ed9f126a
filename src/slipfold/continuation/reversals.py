"""Whether what was found along a curve explains where its parameters change their direction."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from slipfold.continuation.point import P
from slipfold.continuation.search import Found
from slipfold.continuation.trail import Trail

FLAT = 1e-7
"""Change of a parameter from point to point, in spans, whose sign may be that of rounding: beside
multipliers of 1e7 orbits are known to 1e-8 or so."""


def goes_back(before: P, after: P, found: Sequence[Found[P]], components: int) -> bool:
    """Whether a parameter moves against both tangents of a step in which nothing was found."""
    if found or components == 0 or before.piece != after.piece:
        return False
    own = slice(-components, None)
    moved = (after.z - before.z)[own]
    against = (before.tangent[own] * moved < 0) & (after.tangent[own] * moved < 0)
    return bool((against & (abs(moved) > FLAT)).any())


def unexplained_reversal(trail: Trail[P]) -> P | None:
    """Return the first point at which a parameter has an extremum and nothing was found.

    None where there is none. The parameters are the last components of an unknown, as many as there
    are test functions that change their sign with the direction of travel.
    """
    points = list(trail.points)
    if trail.end is not None and trail.end.kind == "closed" and not trail.closes:
        points.pop()  # where another curve begins: it is not computed along this one
    for component in range(-len(trail.curve.odd), 0):
        for before, extremum, after, rises in _reversals(points, component):
            if trail.departs and before is points[0]:  # its first step is not searched
                continue
            found = (item.point for item in trail.found)
            if not any(
                before.arclength <= item.arclength <= after.arclength
                and rises * (item.z[component] - extremum.z[component]) > -FLAT
                for item in found
            ):
                return extremum
    return None


def _reversals(points: Sequence[P], component: int) -> Iterator[tuple[P, P, P, int]]:
    """Yield the points beside each extremum of a component, itself, and 1 at a maximum, else -1."""
    direction, last = 0, 0
    for index in range(1, len(points)):
        step: Any = points[index].z[component] - points[index - 1].z[component]
        if (
            points[index].piece != points[index - 1].piece
        ):  # where pieces meet there may be a corner
            direction = 0
        elif abs(step) > FLAT:
            if step * direction < 0:
                between = points[last : index + 1]
                heights = [direction * point.z[component] for point in between]
                yield between[0], between[heights.index(max(heights))], between[-1], direction
            direction, last = (1 if step > 0 else -1), index - 1
