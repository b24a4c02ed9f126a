"""Where on a branch the response is stable, as intervals of its parameter."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from slipfold.branches.branch import Branch
from slipfold.branches.special_point import BIFURCATIONS

__all__ = ["StableSpan", "stable_spans"]


@dataclass(frozen=True)
class StableSpan:
    """A stretch of a branch between two bifurcations on which it is stable.

    Parameters
    ----------
    low, high
        Least and largest value of the parameter.
    rows
        First row of the branch on the stretch, and the one after the last.
    limit
        Value at which the stretch meets a limit of the model, None if it does not.
    limit_name
        Name of that limit's output; empty if there is none.
    """

    low: float
    high: float
    rows: tuple[int, int]
    limit: float | None = None
    limit_name: str = ""


def stable_spans(branch: Branch) -> list[StableSpan]:
    """Return the stable stretches of a branch; between bifurcations its parameter is monotonic.

    Parameters
    ----------
    branch
        A branch.
    """
    if not len(branch):
        return []
    marks = [(p.arclength, p.value) for p in branch.special if p.type in BIFURCATIONS]
    ends = [(float(branch.arclength[i]), float(branch.parameter[i])) for i in (0, -1)]
    breaks = [ends[0], *marks, ends[1]]
    spans = []
    for place, ((s_a, p_a), (s_b, p_b)) in enumerate(pairwise(breaks)):
        first, last = np.searchsorted(branch.arclength, [s_a, s_b])
        rows = np.arange(first, min(last + 1, len(branch)))
        inside = rows[(branch.arclength[rows] > s_a) & (branch.arclength[rows] < s_b)]
        # On a stretch of no inner point the ends decide; one of them may lie on a bifurcation.
        deciding = inside if len(inside) else rows
        if not len(deciding) or not branch.stable[deciding[len(deciding) // 2]]:
            continue
        at_end = place == len(breaks) - 2 and branch.stopped.kind == "limit"
        spans.append(
            StableSpan(
                min(p_a, p_b),
                max(p_a, p_b),
                (int(rows[0]), int(rows[-1]) + 1),
                p_b if at_end else None,
                branch.stopped.reason.split(":")[0].split("(")[0] if at_end else "",
            )
        )
    return spans
