"""Where branches were looked for that nothing leads to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

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
    undecided: Annotated[
        int, "Trajectories, of all, that came to no motion that can be followed."
    ] = 0
