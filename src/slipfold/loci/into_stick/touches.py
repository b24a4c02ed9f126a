"""Where responses in slip end since a contact begins to stick, or opens: starts of those loci."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from slipfold.arrays import Array
from slipfold.branches.branch import Branch
from slipfold.branches.seams import NAMES
from slipfold.branches.special_point import SpecialPoint
from slipfold.continuation.newton import Correction, correct
from slipfold.errors import BREAKDOWNS, InputError
from slipfold.flow.modes import contacts_of
from slipfold.loci.locus_equations import LocusEquations
from slipfold.loci.window import Window
from slipfold.models.model import Model
from slipfold.models.turns import without_turns
from slipfold.orbits.grazing import GRAZED, GrazingShooting
from slipfold.orbits.kinds import orbits_of
from slipfold.orbits.limits import limit_margins, limit_met
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.switched_shooting import SwitchedShooting

BranchEnd = tuple[Branch, int]
"""A branch with its first row, 0, or its last, -1."""

BESIDE = 0.05
"""Distance in scaled variables within which the touch lies: slip ends at 1e-4 of its size, and
where slip falls steeply towards a touch the way to it goes as the root of that."""

SAME = 1e-4
"""Difference of an orbit's halves, in scaled states, below which they are one."""


class Touches:
    """The touches beside whose orbits responses of a set end; each is looked for once."""

    def __init__(self, plane: tuple[str, str], window: Window) -> None:
        self._plane, self._window = plane, window
        self.of = dict[BranchEnd, SpecialPoint]()

    def beside(self, branches: Sequence[Branch]) -> Iterator[SpecialPoint]:
        """Yield the touches beside the ends of some branches."""
        ends = [(branch, row) for branch in branches for row in (0, -1)]
        for branch, row in ends:
            if ends_in_stick(branch, row) and not is_dear(branch):
                touch = _beside(branch, row, self._plane, self._window)
                if touch is not None:
                    self.of[branch, row] = touch
                    yield touch


def is_dear(branch: Branch) -> bool:
    """Whether the locus is too dear: of doubled orbits in the plane other slip soon is slow, too.

    Equations are stiff there, and a point takes ten seconds.
    """
    return slips_in_planes(branch.model) and branch.period > 1


def slips_in_planes(model: Model) -> bool:
    """Whether contacts of a model slip in the plane: orbits through stick take seconds there."""
    return any(len(contact.slip) == 2 for contact in contacts_of(model))


def ends_in_stick(branch: Branch, row: int = -1) -> bool:
    """Whether a branch in slip ends, or begins, where a contact comes to stick or to open."""
    slips = branch.kind == "periodic" and branch.stuck_fraction is None
    if not slips or branch.ends[row].kind != "limit" or not len(branch):
        return False
    try:
        model = branch.orbit(row).model
    except InputError:  # it ends where parameters contradict each other: there is no model
        return False
    beyond = {name for contact in contacts_of(model) for name in contact.limits}
    if not beyond:
        return False
    before = _margins(branch, 1 if row == 0 else -2) if len(branch) > 1 else None
    return model.limits[limit_met(_margins(branch, row), before)].name in beyond


def _margins(branch: Branch, row: int) -> Array:
    """Return by how much an orbit of a branch keeps each limit."""
    model = branch.orbit(row).model
    orbits = orbits_of(model, {branch.vary: 1.0}, branch.period, branch.nodes.shape[1])
    return limit_margins(orbits, orbits.unknown(branch.nodes[row], model))


def _beside(
    branch: Branch, row: int, plane: tuple[str, str], window: Window
) -> SpecialPoint | None:
    """Return the touch just beyond the end of a branch in slip, None if Newton finds none.

    It lies at the same value of the parameter that the branch does not follow.
    """
    last = branch.orbit(row)
    # A small window does not make the way to the touch long.
    widths = {
        name: max(high - low, abs(last.model.values[name]))
        for name, (low, high) in zip(plane, window, strict=True)
    }
    orbits = orbits_of(last.model, widths, branch.period, 1, by=SwitchedShooting)
    z = orbits.unknown(last.nodes[:1], last.model)
    fixed = np.zeros(len(z))
    fixed[len(z) - 2 + (1 - plane.index(branch.vary))] = 1.0
    found = [_corrected(orbits, z, fixed, kind) for kind in GRAZED]
    near = [item for item in found if item is not None]
    if not near:
        return None
    kind, curve, touched = min(near, key=lambda item: item[2].distance)
    return _as_point(branch, row, kind, curve, touched)


def _corrected(
    orbits: Orbits, z: Array, fixed: Array, kind: str
) -> tuple[str, LocusEquations, Correction] | None:
    """Return a touch, None where none is near."""
    by = orbits.by
    assert isinstance(by, SwitchedShooting)
    try:
        touching = GrazingShooting.at(by, orbits.nodes(z), orbits.constants(z), kind)
        if touching is None:
            return None
        curve = LocusEquations(orbits.described_by(touching), kind)
        guess = curve.orbits.adopt(orbits, z)
        correction = correct(curve, guess, fixed, reach=BESIDE)
    except BREAKDOWNS:
        return None
    if not correction.converged or correction.distance > BESIDE:
        return None
    if _repeats(curve.orbits, correction.z):
        return None
    return kind, curve, correction


def _repeats(orbits: Orbits, z: Array) -> bool:
    """Whether an orbit of an even period is one of half the period, gone round twice."""
    if orbits.period % 2:
        return False
    nodes, whole = orbits.evenly(z), orbits.model.whole_turns
    halves = without_turns(nodes - np.roll(nodes, len(nodes) // 2, axis=0), whole)
    return float(np.abs(halves / orbits.model.state_scales()).max()) < SAME


def _as_point(
    branch: Branch, row: int, kind: str, curve: LocusEquations, correction: Correction
) -> SpecialPoint:
    """Return a touch as what a locus starts from, at the arclength of the end beside it."""
    point = curve.point(correction, float(branch.arclength[row]))
    orbits, model = curve.orbits, curve.orbits.model_at(point.z)
    multipliers = orbits.multipliers(point)
    return SpecialPoint(
        kind,
        NAMES[kind],
        model,
        branch.vary,
        model.values[branch.vary],
        np.inf,
        branch.period,
        orbits.evenly(point.z),
        multipliers,
        np.full(len(multipliers), np.inf),
        point.residual,
        point.arclength,
        stuck_fraction=0.0,
    )
