"""How the orbits stand on each interval of a branch, and where it first loses its stability."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from slipfold.arrays import Complex
from slipfold.bifurcations.branches.bifurcations import BIFURCATION
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.orbits.bifurcation_types import BIFURCATION_TYPES, PAIRED, REQUESTED_TYPES
from slipfold.text import outside


@dataclass(frozen=True, eq=False)
class StabilityInterval:
    """A part of a branch on which no multiplier crosses the unit circle."""

    # Arclength of its ends
    begin: float
    end: float
    outside: Complex  # the multipliers outside the unit circle, as at a point in its middle

    @property
    def stable(self) -> bool:
        """Whether there are none: it is stable, or neutral where nothing damps."""
        return len(self.outside) == 0


def stability_intervals(branch: Branch) -> tuple[StabilityInterval, ...]:
    """Cut a branch at its bifurcations, and where its contacts begin to do something else.

    Where no point of the branch lies between two of them, what is outside follows from what was
    outside before and from which multipliers are critical.

    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(f=12.5), vary="Nd", span=(0, 0.3))
    >>> [interval.stable for interval in stability_intervals(diagram.branches[0])]
    [True, False]
    """
    marks = [item for item in branch.special if item.type not in REQUESTED_TYPES]
    first, last = float(branch.arclength[0]), float(branch.arclength[-1])
    breaks = [first, *(item.arclength for item in marks), last]
    intervals: list[StabilityInterval] = []
    for i, (begin, end) in enumerate(pairwise(breaks)):
        clear = np.minimum(branch.arclength - begin, end - branch.arclength)
        middle = int(clear.argmax())
        if clear[middle] > BIFURCATION.undecided * (last - first):
            outside = _outside(branch.multipliers[middle])
        elif i == 0 or i == len(marks):
            outside = _outside(branch.multipliers[-1 if i == len(marks) else 0])
        elif marks[i - 1].type not in BIFURCATION_TYPES:
            outside = intervals[-1].outside
        else:
            cycle = not branch.model.forced and branch.kind == "periodic"
            outside = _behind(marks[i - 1], len(intervals[-1].outside), cycle)
        intervals.append(StabilityInterval(begin, end, outside))
    return tuple(intervals)


def loss_of_stability(branch: Branch) -> SpecialPoint | None:
    """Return the bifurcation by which a branch that begins stable first becomes unstable."""
    stable = branch.stable
    if not stable[0]:
        return None
    lost = len(stable) if stable.all() else int(stable.argmin())
    begin = branch.arclength[lost - 1]
    end = branch.arclength[lost] if lost < len(stable) else math.inf
    for point in branch.special:
        if point.type in BIFURCATION_TYPES and begin < point.arclength <= end:
            return point
    return None


def _outside(multipliers: Complex) -> Complex:
    return multipliers[outside(multipliers)]


def _behind(point: SpecialPoint, before: int, cycle: bool) -> Complex:
    """Return what is outside behind a bifurcation, from how many were outside before it."""
    values = point.multipliers
    target = BIFURCATION_TYPES[point.type].critical
    if point.type in PAIRED:
        upper = np.array(point.critical_multiplier)
        critical = np.argsort(np.minimum(abs(values - upper), abs(values - upper.conj())))[:2]
    else:
        # A cycle has a multiplier one anyway, that of its own direction.
        count = 2 if cycle and target == 1 else 1
        critical = np.argsort(np.abs(values - target))[:count]
    rest = _outside(np.delete(values, critical))
    if before > len(rest):
        return rest
    crossing = values[critical if point.type in PAIRED else critical[:1]]
    return np.concatenate([rest, BIFURCATION.outside * crossing / np.abs(crossing)])
