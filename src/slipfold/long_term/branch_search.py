"""Where branches were looked for that nothing leads to."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class BranchSearch:
    """Where branches were looked for that nothing leads to; frozen.

    Parameters
    ----------
    values
        Values of the parameter at which trajectories were started.
    low, high
        Least and largest starting value of each state.
    starts
        Trajectories at each value.
    found
        Ids of the branches that were found.
    interrupted
        Whether the search was interrupted.
    undecided
        Trajectories, of all, that came to no motion that can be followed.
    """

    values: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    starts: int
    found: tuple[int, ...]
    interrupted: bool = False
    undecided: int = 0
