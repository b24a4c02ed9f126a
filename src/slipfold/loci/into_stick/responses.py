"""Responses across a window that come to stick, followed through it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from slipfold.arrays import Array
from slipfold.branches.branch import Branch
from slipfold.branches.settings import Settings
from slipfold.branches.special_point import SpecialPoint
from slipfold.flow.modes import contacts_of
from slipfold.loci.fan import FanLine, follow_line
from slipfold.loci.into_stick.touches import ends_in_stick, is_dear, slips_in_planes
from slipfold.loci.locus import Locus
from slipfold.loci.locus_curve import locus_curve
from slipfold.loci.progress import locus_progress
from slipfold.loci.window import Window
from slipfold.models.model import Model
from slipfold.orbits.grazing import MET
from slipfold.orbits.test_functions import CRITICAL, critical_places
from slipfold.progress import Observer

WHOLE = ("span", "closed")
"""Kinds of ends at which a response is known as far as it goes."""


NONE_STUCK = 1e-5
"""Share of the time below which nothing sticks yet: at a touch a contact comes to rest at once."""

ON = 0.01
"""Distance from a locus, in widths of the window, within which a response ends on it."""

ALONG_LINES, IN_THE_PLANE = 8, 4
"""Responses that are followed, evenly spread over the lines that come to stick: each takes four
times as long as in slip, of contacts in the plane seconds; a locus is met by several lines."""


def follow_sticking(
    model: Model,
    lines: list[FanLine],
    plane: tuple[str, str],
    window: Window,
    settings: Settings,
    observer: Observer | None = None,
) -> Iterator[Branch]:
    """Add to lines their responses through stick, where they come to it, and return these."""
    if not contacts_of(model):
        return
    coming = [number for number, line in enumerate(lines) if _comes_to_stick(line)]
    most = IN_THE_PLANE if slips_in_planes(model) else ALONG_LINES
    some = np.linspace(0, len(coming) - 1, min(len(coming), most)).round().astype(int)
    for number in (coming[place] for place in some):
        line = lines[number]
        along = window[plane.index(line.vary)]
        if observer is not None:
            middle = {line.fixed: line.value, line.vary: sum(along) / 2}
            at, text = (middle[plane[0]], middle[plane[1]]), "through stick"
            observer(locus_progress("responses", number, len(lines), at, text))
        found = follow_line(
            model, line.vary, along, line.fixed, line.value, settings, through_stick=True
        )
        sticking = tuple(item for item in found.branches if item.stuck_fraction is not None)
        failure = found.failure or line.failure
        lines[number] = replace(line, sticking=sticking, failure=failure)
        yield from sticking
        if lines[number].interrupted:
            return


def _comes_to_stick(line: FanLine) -> bool:
    """Whether a response in slip ends at stick, or there is none."""
    ends = (ends_in_stick(branch, row) for branch in line.branches for row in (0, -1))
    return not line.branches or any(ends)


def found_in_stick(branch: Branch) -> Iterator[SpecialPoint]:
    """Yield the special points of a branch where it has come to stick, or to turn.

    Of touches only those at which a response begins to stick at all, or turns back: others change
    nothing that labels of regions say.
    """
    for point in branch.special:
        if not point.stuck_fraction >= 0:
            continue
        if point.type in MET:
            begins = point.stuck_fraction < NONE_STUCK or _turns_back(branch, point)
            if is_dear(branch) or not begins:
                continue
        yield point


def _turns_back(branch: Branch, point: SpecialPoint) -> bool:
    """Whether the parameter goes back from a point on."""
    after = int(np.searchsorted(branch.arclength, point.arclength, "right"))
    sides = branch.parameter[max(after - 2, 0)], branch.parameter[min(after + 1, len(branch) - 1)]
    return bool(np.prod(np.array(sides) - point.value) > 0)


def changes_in_stick(line: FanLine) -> Iterator[float]:
    """Yield where stable responses through stick begin, end or lose their stability."""
    for branch in line.sticking:
        for point in found_in_stick(branch):
            others = np.delete(point.multipliers, critical_places(point.type, point.multipliers))
            changes = point.type in CRITICAL or _turns_back(branch, point)
            if changes and (np.abs(others) <= 1).all():
                yield point.value
        if branch.stopped.kind not in WHOLE and branch.stable[-1]:
            yield branch.stopped.value


def unfinished(
    line: FanLine, plane: tuple[str, str], window: Window, loci: Sequence[Locus]
) -> Iterator[str]:
    """Say of responses through stick that were given up inside the window where and why.

    Not of those that end on a locus: what goes on beyond begins there.
    """
    low, high = np.transpose(window)
    for branch in line.sticking:
        end = branch.stopped
        place = np.array([end.value, line.value])[:: 1 if line.vary == plane[0] else -1]
        inside = (low < place).all() and (place < high).all()
        if end.kind not in WHOLE and inside and not _lies_on_one(place, loci, high - low):
            at = ", ".join(
                f"{name} = {value:.6g}" for name, value in zip(plane, place, strict=True)
            )
            yield f"a response through stick was followed no farther than {at}: {end.reason}"


def _lies_on_one(place: Array, loci: Sequence[Locus], size: Array) -> bool:
    for locus in loci:
        curve = locus_curve(locus)
        for i in range(len(locus) - 1):
            if (np.linalg.norm((curve.between(i) - place) / size, axis=1) < ON).any():
                return True
    return False


def stable_beside(line: FanLine, value: float) -> Iterator[Array]:
    """Yield a state of each stretch of stable orbits beside a value, from which motions settle.

    Shapes: (n_states,).
    """
    for branch in line.sticking:
        parameter, edges = branch.parameter, np.flatnonzero(np.diff(branch.stable)) + 1
        for rows in np.split(np.arange(len(branch)), edges):
            if branch.stable[rows[0]] and np.ptp([*parameter[rows], value]) <= np.ptp(
                parameter[rows]
            ):
                yield branch.nodes[rows[np.abs(parameter[rows] - value).argmin()], 0]
