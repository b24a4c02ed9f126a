"""How thresholds move with every parameter, in one call."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from slipfold.branches.branch import Branch
from slipfold.branches.progress import branch_progress
from slipfold.branches.settings import Settings
from slipfold.branches.special_point import SpecialPoint
from slipfold.computations.given import checked_point
from slipfold.loci.gradients import threshold_gradients
from slipfold.progress import Observer, Progress
from slipfold.results.diagram import Labelled


def gradients(point: SpecialPoint | Labelled) -> dict[str, float]:
    """Return how a special point moves with every parameter but the one that was followed.

    Exact derivatives of its value, from the equations of its locus in two parameters: one linear
    system serves all parameters. Values that depend on parameters move with them, as masses do that
    follow from a stiffness and a frequency.

    Parameters
    ----------
    point
        A special point of a branch: LP, PD, NS, HB, BP, GRAZE or LIFT.

    Returns
    -------
    dict
        Derivatives by name of the parameter, in the unit of the point's value over that of the
        parameter, angles in rad. NaN where there is none: a branch point is gone where a parameter
        parts the branches that cross, and nothing is known where the orbit is not found again.

    Raises
    ------
    InputError
        If the point has no locus, as a user's event.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.05), f=12.5)
    >>> doubling = diagram.special[0].point
    >>> round(sf.gradients(doubling)["Vd"], 9)
    -0.041609201
    """
    found = threshold_gradients(checked_point(point))
    assert found is not None
    return found


def with_gradients(
    branches: Sequence[Branch], settings: Settings, observer: Observer | None
) -> tuple[tuple[Branch, ...], bool]:
    """Return branches whose special points have gradients, and whether all of them do."""
    total, done = sum(len(branch.special) for branch in branches), 0
    found = list[Branch]()
    try:
        for branch in branches:
            special = list[SpecialPoint]()
            for point in branch.special:
                if observer is not None:
                    observer(_progress(branch, done, total))
                special.append(replace(point, gradients=threshold_gradients(point, settings)))
                done += 1
            found.append(replace(branch, special=tuple(special)))
    except KeyboardInterrupt:
        return (*found, *branches[len(found) :]), False
    return tuple(found), True


def _progress(branch: Branch, done: int, total: int) -> Progress:
    names = tuple(point.type for point in branch.special)
    at = branch.id, branch.period, len(branch), branch.stopped.value, names
    return branch_progress(branch.model.parameter(branch.vary), *at, "gradients", done, total)
