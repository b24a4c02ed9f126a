"""Special points and ends of branches, computed again by other means."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from slipfold.branches.branch import Branch
from slipfold.branches.progress import branch_progress
from slipfold.branches.special_point import SpecialPoint
from slipfold.checks.checked import Checked
from slipfold.checks.choice import Candidate, check_some
from slipfold.flow.switched.mode_equations import contacts_of
from slipfold.progress import Observer
from slipfold.text.one_line import parameter_text


def check_branches(branches: Sequence[Branch], observer: Observer | None = None) -> Checked:
    """Check special points, those that come first on each branch first, then ends.

    Whoever interrupted the branches does not wait for checks.
    """
    if any(branch.interrupted for branch in branches):
        return Checked((), interrupted=True)
    points = sum(len(branch) * branch.period for branch in branches)
    ranked = [
        (rank, branch, point) for branch in branches for rank, point in enumerate(branch.special)
    ]
    ranked.sort(key=lambda item: item[0])
    special = (_special(branch, point) for _, branch, point in ranked)
    ends = (end for branch in branches if len(branch) for end in _ends(branch))

    def tell(done: int) -> None:
        if observer is not None:
            last = branches[-1]
            at = last.id, last.period, len(last), last.stopped.value
            names = tuple(point.type for point in last.special)
            parameter = last.model.parameter(last.vary)
            observer(branch_progress(parameter, *at, names, "checks", done))

    return check_some(_each(special, ends), points, tell)


def _each(*groups: Iterator[Candidate]) -> Iterator[Candidate]:
    for group in groups:
        yield from group


def _special(branch: Branch, point: SpecialPoint) -> Candidate:
    name = f"{point.type} of branch {branch.id} at {_at(branch, point.value)}"
    planar = any(len(each.slip) == 2 for each in contacts_of(branch.model))
    if point.type == "GRAZE" and planar:
        return _beside_graze(branch, point, name)
    return Candidate(name, point.orbit, branch.kind == "equilibrium")


def _beside_graze(branch: Branch, point: SpecialPoint, name: str) -> Candidate:
    """Return the orbit beside a graze in the plane, one that always slips if there is one.

    Slip that vanishes there has no direction, so nothing carries a motion through it; and stops
    that only just happen change as square roots, which differences of motions cannot tell.
    """
    away = np.abs(branch.arclength - point.arclength)
    if branch.stuck_fraction is not None and not (branch.stuck_fraction > 0).all():
        away[branch.stuck_fraction > 0] = np.inf
    index = int(away.argmin())
    place = _at(branch, float(branch.parameter[index]))
    return Candidate(f"orbit beside {name}, at {place},", branch.orbit(index), False)


def _ends(branch: Branch) -> Iterator[Candidate]:
    """The last point and the first, unless it is the special point at which the branch is born."""
    for index, word in ((-1, "end"), (0, "beginning")):
        if index == -1 or (branch.begun.kind != "born" and len(branch) > 1):
            place = _at(branch, float(branch.parameter[index]))
            name = f"{word} of branch {branch.id} at {place}"
            yield Candidate(name, branch.orbit(index), branch.kind == "equilibrium")


def _at(branch: Branch, value: float) -> str:
    return parameter_text(branch.model.parameter(branch.vary), value)
