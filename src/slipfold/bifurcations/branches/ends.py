"""How branches and loci end, in words: at the span, beside a limit, near a homoclinic orbit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import islice, pairwise, takewhile

import numpy as np

from slipfold.bifurcations.branches.bifurcations import (
    BIFURCATION,
    Bifurcations,
    count_on_circle,
    is_off_circle,
    may_cross,
    span_end,
)
from slipfold.bifurcations.branches.homoclinic import nears_homoclinic
from slipfold.bifurcations.branches.standing import seen_without, standing_between
from slipfold.bifurcations.branches.stops import (
    STOP,
    family_end,
    far_away,
    in_family,
    size_in_scales,
)
from slipfold.continuation.end import End
from slipfold.continuation.follow import Endings
from slipfold.continuation.locate import LostCurveError
from slipfold.continuation.newton import NEWTON, SINGULAR
from slipfold.continuation.pieces import PIECE
from slipfold.continuation.settings import Stepping
from slipfold.continuation.step_length import STEP
from slipfold.continuation.traced_curve import Found, TracedCurve
from slipfold.continuation.walk import CurveSteps, Failure
from slipfold.errors import BREAKDOWNS
from slipfold.orbits.collocation import Collocation
from slipfold.orbits.limits import is_singular_near, limit_ahead, limit_margins
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.orbits.shooting import RESOLVED
from slipfold.orbits.test_functions import ALIKE

SEVERAL = (
    "several multipliers are critical where it begins, as a symmetry makes them: several branches "
    "begin there, and in the one direction tried there is none"
)

UNDAMPED = (
    "{} multipliers are one there, as where nothing damps a free vibration of that period: the "
    "orbits are a family, with any amplitude and phase ({})"
)

CONSERVED = 1e-10
"""Part of a volume that rounding changes in a period; decays that are slower are none."""

UNSOLVED = (
    "the motion turns so sharply that on an interval of the mesh no polynomials were found that "
    "meet the equations; simulate continues in implicit steps of any length"
)

FAST = 64
"""Vibrations in a period above which a mode is much faster than an orbit."""

LASTING = 1e-3
"""Multiplier below which a mode has decayed within a period, so that its turns bend no branch."""

NO_VALUE = (
    "where the equations have no value, such as the logarithm or root of what is negative or a "
    "quotient 0/0 (x/(1 - exp(-x)) is written 1/exprel(-x))"
)

LOST = (
    f"trajectories beyond could not be computed: they reach states {NO_VALUE}, or turn more "
    "sharply than explicit steps follow, where simulate continues in implicit ones"
)


@dataclass(frozen=True, eq=False)
class BranchEndings(Endings[OrbitPoint]):
    """The ends of branches in words."""

    span: tuple[float, float]
    settings: Stepping

    def left(self, traced: TracedCurve[OrbitPoint]) -> End:
        """Return the end of a branch that reached the end of the span.

        On which side of a bifurcation at that very value the last orbit lies is rounding. Where
        several pairs are critical, nothing damps, and which of them crosses is not defined.
        """
        *_, before, last = [*traced.points[-1:], *traced.points[-2:]]
        standing = standing_between(before, last)
        _, (before, last) = seen_without(standing, traced.curve, [before, last])
        crossing = is_off_circle(before) and not is_off_circle(last)
        if crossing and count_on_circle(last) <= 2:
            self._put_on_edge(traced)
        return span_end(traced.curve, traced.points[-1])

    def failed(self, traced: TracedCurve[OrbitPoint], failure: Failure) -> End:
        """Return the end of a branch that cannot be followed: there, or on the end of the span."""
        orbits = traced.curve
        if failure.kind == "failed" and self._put_on_edge(traced):
            return span_end(orbits, traced.points[-1])
        if _is_line(traced):
            return family_end(orbits, traced.points)
        last, neared = traced.points[-1], nears_homoclinic(orbits, traced.points)
        kind, reason = failure_reason(orbits, last, failure)
        reason += _too_fast(orbits, last) if kind == "points" else ""
        critical = np.count_nonzero(np.abs(last.multipliers - 1) < ALIKE)
        if kind == "failed" and critical > 1 and len(traced.points) == 1:
            reason = SEVERAL
        elif kind == "failed":
            reason = _family(orbits, last, reason) or reason
        if kind == "failed" and neared:
            kind, reason = neared[0], f"{neared[1]} (no cycle was found any nearer to it)"
        elif neared:
            reason = f"{reason}; {neared[1]}"
        return End(kind, reason, orbits.place(last.z))

    def contradiction(self, traced: TracedCurve[OrbitPoint]) -> tuple[OrbitPoint, str] | None:
        """Return also where more multipliers cross the unit circle than points were located."""
        if (turn := super().contradiction(traced)) is not None:
            return turn
        # Where it leaves another branch, and where it comes back there, multipliers are critical.
        last = len(traced.points) - (traced.departs and traced.closes)
        known = [item for item in traced.points[traced.departs : last] if is_off_circle(item)]
        for before, after in pairwise(known):
            change, ends = after.unstable - before.unstable, (before.arclength, after.arclength)
            between = (item for item in traced.found if ends[0] <= item.point.arclength <= ends[1])
            if before.piece == after.piece and abs(change) > sum(map(may_cross, between)):
                return after, f"the number of unstable multipliers changes by {change}"
        return None

    def _put_on_edge(self, traced: TracedCurve[OrbitPoint]) -> bool:
        """End a branch with the bifurcation that lies on the end of the span, if one does."""
        try:
            on_edge = _end_on_edge(traced.curve, traced, self.span, self.settings)
        except BREAKDOWNS:
            return False
        if on_edge is None or _family(traced.curve, on_edge[0][-1], ""):
            return False
        traced.points, result = on_edge
        sure = traced.points[-2].arclength
        traced.found = [item for item in traced.found if item.point.arclength <= sure] + result
        return True

    def interrupted(self, traced: TracedCurve[OrbitPoint]) -> End:
        """Return the end of a branch that was interrupted."""
        value = traced.curve.value(traced.points[-1].z)
        reason = f"interrupted at {traced.curve.vary} = {value:.6g}; results up to there are kept"
        return End("interrupted", reason, (value,))


def _is_line(traced: TracedCurve[OrbitPoint]) -> bool:
    """Whether all equilibria of a branch have one value, as on a line of them at a span's end."""
    still = len(traced.points) > 1 and traced.curve.kind == "equilibrium"
    return still and in_family(traced.points)


def _family(orbits: Orbits, last: OrbitPoint, why: str) -> str:
    """Say that an orbit may move in all directions in which its multipliers are one, if it may.

    Slow decays come as near to one, but lose volume; at a fold without damping two multipliers
    are one, but the orbit may move in one direction only.
    """
    critical = last.multipliers[np.abs(last.multipliers - 1) < ALIKE]
    conserved = abs(np.abs(np.prod(critical)) - 1) <= CONSERVED
    if len(critical) < 2 or orbits.kind == "equilibrium" or not conserved:
        return ""
    moves = np.linalg.svd(last.monodromy - np.eye(len(last.monodromy)), compute_uv=False)
    free = int(np.count_nonzero(moves < ALIKE)) >= len(critical)
    return UNDAMPED.format(len(critical), why) if free else ""


def failure_reason(orbits: Orbits, last: OrbitPoint, failure: Failure) -> tuple[str, str]:
    """Return the kind and the sentence of a failure, with how far the model's limits are."""
    kind, reason = _explained(orbits, last, failure)
    largest = float(np.abs(last.multipliers).max(initial=0.0))
    if kind == "failed" and orbits.by.smooth and largest > RESOLVED:
        kind = "unresolved"
        reason = f"a multiplier of {largest:.1e} leaves too few digits for a step ({reason})"
    return kind, reason


def _too_fast(orbits: Orbits, last: OrbitPoint) -> str:
    """Say that a vibration is much faster than an orbit, whose multiplier soon turns, if one is."""
    at = orbits.nodes(last.z)[:1], orbits.by.start[:1], orbits.constants(last.z)
    values = np.linalg.eigvals(orbits.flow.jacobians(*at)[0]) * orbits.period
    lasting = values[values.real > np.log(LASTING)]
    ratio = np.abs(lasting.imag).max(initial=0.0) / (2 * np.pi)
    if not (orbits.kind == "periodic" and orbits.by.smooth and ratio > FAST):
        return ""
    return (
        f"; a mode {ratio:.0f} times as fast as the orbit may be why steps are short: give it more "
        "damping, or leave it out of the model"
    )


def _explained(orbits: Orbits, last: OrbitPoint, failure: Failure) -> tuple[str, str]:
    if failure.kind != "failed":
        return failure.kind, failure.reason
    if not orbits.by.smooth:
        ahead = limit_ahead(orbits, last)
        if ahead is not None:
            return "limit", ahead
        if size_in_scales(orbits, last) > BIFURCATION.runs_away:
            return failure.kind, far_away(orbits, last, "")
        largest = float(np.abs(last.multipliers).max(initial=0.0))
        if largest > BIFURCATION.sensitive:
            why = f"changes of contacts multiply perturbations by {largest:.1e} in a period"
        else:
            why = (
                "a stuck interval that vanishes, or a change of contacts that the orbit cannot be "
                "continued through"
            )
        reason = (
            f"no orbit was found beyond: {why} ({failure.reason}); simulate shows what motions do"
        )
        return failure.kind, reason
    try:
        margins, rooms = limit_margins(orbits, last.z)
        singular = is_singular_near(orbits, last.z)
    except BREAKDOWNS:
        return failure.kind, failure.reason
    for limit, margin, room in zip(orbits.model.limits, margins, rooms, strict=True):
        if margin < (BIFURCATION.close_to_limit - 1) * room:
            reason = limit.reason.format(value=margin + limit.bound)
            return "limit", f"{reason} (no orbit was found any nearer to the limit)"
    # Of an equilibrium far away it is rounding whether the rates beside it overflow.
    singular &= orbits.kind != "equilibrium" or not size_in_scales(orbits, last) > STOP.far
    if not singular and size_in_scales(orbits, last) > BIFURCATION.runs_away:
        return failure.kind, far_away(orbits, last, "")
    met = SINGULAR in failure.reason or _is_singular_beyond(orbits, last)
    if met and not singular and orbits.kind == "equilibrium":
        return failure.kind, far_away(orbits, last, ", where rates overflow")
    if met and not singular:
        return failure.kind, UNSOLVED if isinstance(orbits.by, Collocation) else LOST
    if singular:
        # Whether Newton's method or the step failed first is rounding.
        return failure.kind, f"the orbit reaches states {NO_VALUE}, and no orbit was found beyond"
    limits = ", ".join(
        f"{limit.output} = {margin + limit.bound:.3g} (limit {limit.bound:g})"
        for limit, margin in zip(orbits.model.limits, margins, strict=True)
        if np.isfinite(margin)
    )
    there = f"; there {limits}" if limits else ""
    return "failed", f"{failure.reason}{there}"


def _is_singular_beyond(orbits: Orbits, last: OrbitPoint) -> bool:
    """Whether the equations have no value where orbits beyond the last one would be.

    Beside a quotient 0/0 it is rounding which of the two ends the shortest steps.
    """
    try:
        beyond = [orbits.linearize(last.z + step * last.tangent).defect for step in PIECE.looks]
    except BREAKDOWNS:
        return True
    return not np.isfinite(beyond).all()


def _end_on_edge(
    orbits: Orbits, traced: TracedCurve[OrbitPoint], span: tuple[float, float], settings: Stepping
) -> tuple[list[OrbitPoint], list[Found]] | None:
    """Return how a branch ends if a bifurcation lies on the end of the span.

    With the parameter held Newton's method is singular at a branch point. So a step is taken over
    the end, and the bifurcation is located between.
    """
    points = traced.points
    edge = min(orbits.bounds(span)[0][1:], key=lambda bound: abs(points[-1].z[-1] - bound))

    def away(point: OrbitPoint) -> float:
        return abs(float(point.z[-1]) - edge)

    close = len(list(takewhile(lambda point: away(point) < BIFURCATION.clear, reversed(points))))
    kept = list(points[: len(points) - close])
    if away(points[-1]) > BIFURCATION.near_edge or not kept:
        return None
    for i in range(-1, -1 - min(NEWTON.known, len(kept)), -1):
        if kept[i].curve is not orbits:  # the mesh has been renewed since
            again = orbits.converted(kept[i])
            if again is None:
                return None
            kept[i] = again
    before = kept[-1]
    step = min(
        2 * away(before) / max(abs(before.tangent[-1]), STEP.edge),
        BIFURCATION.steps_over * BIFURCATION.near_edge,
    )
    over: OrbitPoint | None = None
    steps = CurveSteps(orbits, kept, step, (), settings).points()
    for beyond in islice(steps, BIFURCATION.steps_over):
        if isinstance(beyond, Failure):
            return None
        if (beyond.z[-1] > edge) != (before.z[-1] > edge):
            over = beyond
            break
        before = beyond
        kept = [*kept, before]
    if over is None:
        return None
    try:
        result = Bifurcations(orbits, span).between([*kept, over], before, over)
    except LostCurveError:
        return None
    place = next((i for i, item in enumerate(result) if away(item.point) < STEP.edge), None)
    if place is None:
        return None
    z = result[place].point.z.copy()
    z[-1] = edge  # exactly, whatever rounding did
    last = replace(result[place].point, z=z)
    result[place] = replace(result[place], point=last)
    return [*kept, last], result[: place + 1]
