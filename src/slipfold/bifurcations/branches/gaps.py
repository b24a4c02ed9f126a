"""Parts of a span that no branch reaches, and where branches were searched for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from slipfold.bifurcations.branches.branch import Branch
from slipfold.read_only import Documented


@dataclass(frozen=True)
class BranchSearch(Documented):
    """Where branches were looked for that nothing leads to; frozen."""

    values: Annotated[
        tuple[float, ...], "Values of the parameter at which trajectories were started."
    ]
    low: Annotated[tuple[float, ...], "Least and largest starting value of each state."]
    high: Annotated[tuple[float, ...], ""]
    starts: Annotated[int, "Trajectories at each value."]
    found: Annotated[tuple[int, ...], "Ids of the branches that were found."]
    interrupted: Annotated[bool, "Whether the search was interrupted."] = False
    undecided: Annotated[int, "Trajectories, of all, that had not settled after `periods`."] = 0
    periods: Annotated[int, "Periods of each trajectory."] = 256


def gaps_between(
    branches: Sequence[Branch], span: tuple[float, float], share: float, settled: bool = False
) -> list[tuple[float, float]]:
    """Return the parts of a span, wider than a share of it, that no branch reaches.

    With `settled` an equilibrium counts only where it is stable.
    """
    low, high = sorted(span)
    gaps, reached = [], low
    for first, last in sorted(part for branch in branches for part in _reach(branch, settled)):
        if first > reached:
            gaps.append((reached, first))
        reached = max(reached, last)
    if reached < high:
        gaps.append((reached, high))
    return [gap for gap in gaps if gap[1] - gap[0] > share * (high - low)]


def _reach(branch: Branch, settled: bool) -> Iterator[tuple[float, float]]:
    if settled and branch.kind == "equilibrium":
        for i in np.flatnonzero(branch.stable[:-1] & branch.stable[1:]):
            ends = branch.parameter[i : i + 2]
            yield float(ends.min()), float(ends.max())
        return
    values = [*branch.parameter, *(point.value for point in branch.special)]
    if values:
        yield float(min(values)), float(max(values))
