"""Whether a threshold is the first thing that happens to a response, followed anew."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from slipfold.branches.branch import Branch
from slipfold.branches.response import trace_response
from slipfold.branches.settings import Settings
from slipfold.branches.special_point import BIFURCATIONS, SpecialPoint
from slipfold.branches.stability import loss_of_stability
from slipfold.errors import InputError

BEYOND = 0.05
"""Share of the threshold by which the response is followed past it."""

SAME = 1e-8
"""Difference of thresholds, over their size, that are the same."""


def is_confirmed(
    point: SpecialPoint, values: Mapping[str, float], threshold: float, load: float
) -> bool:
    """Return whether the response from a load on first loses its stability at a threshold.

    Of a point of a longer period, whether the orbits of that period do to which doublings lead, one
    after the other, each of which begins stable. Where contacts begin or cease to do something
    nothing need be lost: that is to come before the loss. If it is interrupted it raises
    `KeyboardInterrupt`.
    """
    end = threshold + BEYOND * abs(threshold)
    if not load < threshold:
        return False
    model = point.model.replace(**{**values, point.vary: load})
    try:
        alone = Settings(largest_period=point.period)
        span = load, end
        branches = trace_response(model, point.vary, span, settings=alone, through_stick=True)
    except InputError:
        return False
    if any(branch.interrupted for branch in branches):
        raise KeyboardInterrupt
    if branches[0].parameter[0] != load:
        return False
    branch = _doubled(branches, point.period)
    if branch is None or not branch.stable[0]:
        return False
    first = lost = loss_of_stability(branch)
    if point.type not in BIFURCATIONS:
        first = next((item for item in branch.special if item.type == point.type), None)
    if first is None or (lost is not None and first.arclength > lost.arclength):
        return False
    gap = abs(first.value - threshold)
    return first.type == point.type and gap <= SAME * max(abs(threshold), 1e-300)


def _doubled(branches: Sequence[Branch], period: int) -> Branch | None:
    """Return the branch of a period to which losses by doubling lead from the first one."""
    known = {branch.id: branch for branch in branches}
    branch: Branch | None = branches[0]
    while branch is not None and branch.period < period:
        lost = loss_of_stability(branch)
        if lost is None or lost.type != "PD" or lost.leads_to is None:
            return None
        branch = known.get(lost.leads_to)
    return branch
