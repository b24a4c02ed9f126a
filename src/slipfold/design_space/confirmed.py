"""Whether a threshold is the first thing that happens to a response, followed anew."""

from __future__ import annotations

from collections.abc import Mapping

from slipfold.branches.response import trace_response
from slipfold.branches.settings import Settings
from slipfold.branches.special_point import BIFURCATIONS, SpecialPoint
from slipfold.branches.stability import loss_of_stability
from slipfold.errors import InputError

__all__ = ["is_confirmed"]

BEYOND = 0.05
"""Share of the threshold by which the response is followed past it."""

SAME = 1e-8
"""Difference of thresholds, over their size, that are the same."""


def is_confirmed(
    point: SpecialPoint, values: Mapping[str, float], threshold: float, load: float
) -> bool:
    """Return whether the response from a load on first loses its stability at a threshold.

    Where contacts begin or cease to do something nothing need be lost: that is to come before the
    loss. It is asked of period 1 only: of other orbits the branch would have to be found first. If
    it is interrupted it raises `KeyboardInterrupt`.
    """
    end = threshold + BEYOND * abs(threshold)
    if point.period > 1 or not load < threshold:
        return False
    model = point.model.replace(**{**values, point.vary: load})
    try:
        alone = Settings(largest_period=1)
        span = load, end
        branch = trace_response(model, point.vary, span, settings=alone, through_stick=True)[0]
    except InputError:
        return False
    if branch.interrupted:
        raise KeyboardInterrupt
    if branch.parameter[0] != load or not branch.stable[0]:
        return False
    first = lost = loss_of_stability(branch)
    if point.type not in BIFURCATIONS:
        first = next((item for item in branch.special if item.type == point.type), None)
    if first is None or (lost is not None and first.arclength > lost.arclength):
        return False
    gap = abs(first.value - threshold)
    return first.type == point.type and gap <= SAME * max(abs(threshold), 1e-300)
