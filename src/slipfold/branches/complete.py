"""What branches compute when they are asked, computed at once: files hold all of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from slipfold.branches.branch import Branch
from slipfold.flow.batches import LANES
from slipfold.flow.flow import flow_of
from slipfold.orbits.extrema import TOGETHER, Extrema, find_extrema
from slipfold.orbits.uncertainty import multiplier_uncertainty

Tell = Callable[[int, int], None]
"""Called with how many points are done, and how many there are."""


def complete_branches(branches: Sequence[Branch], tell: Tell) -> bool:
    """Compute extrema and uncertainties at all points, until whoever watches stops it.

    Return whether all is done; what is not is NaN.
    """
    total, done = sum(map(len, branches)), 0
    for branch in branches:
        names = flow_of(branch.model).output_names
        low, high = np.full((2, len(branch), len(names)), np.nan)
        vars(branch)["extrema"] = Extrema(names, low, high)
        vars(branch)["multiplier_uncertainty"] = np.full(branch.multipliers.shape, np.nan)
    try:
        for branch in branches:
            for first in range(0, len(branch), TOGETHER):
                some = range(len(branch))[first : first + TOGETHER]
                tell(done, total)
                _find_extrema(branch, slice(some.start, some.stop))
                for begin in some[::LANES]:
                    tell(done, total)
                    end = min(begin + LANES, some.stop)
                    _find_uncertainty(branch, slice(begin, end))
                    done += end - begin
    except KeyboardInterrupt:
        pass
    return done == total


def _find_extrema(branch: Branch, some: slice) -> None:
    model, extrema = branch.model, branch.extrema
    if branch.stuck_fraction is not None:
        for index in range(some.start, some.stop):
            one = branch.orbit(index).extrema
            extrema.minimum[index], extrema.maximum[index] = one.minimum, one.maximum
        return
    found = find_extrema(model, branch.parameters[some], branch.nodes[some], branch.period)
    extrema.minimum[some], extrema.maximum[some] = found.minimum, found.maximum


def _find_uncertainty(branch: Branch, some: slice) -> None:
    if branch.stuck_fraction is not None:
        for index in range(some.start, some.stop):
            branch.multiplier_uncertainty[index] = branch.orbit(index).multiplier_uncertainty
        return
    branch.multiplier_uncertainty[some] = multiplier_uncertainty(
        branch.model,
        branch.parameters[some],
        branch.nodes[some],
        branch.period,
        branch.multipliers[some],
    )
