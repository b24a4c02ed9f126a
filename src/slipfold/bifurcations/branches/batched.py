"""Responses of many cases in a batch: their special points, or all of their branches.

A case is left, to be followed individually, unless all its branches are ordinary: in slip,
connected with the response of period 1, with no other bifurcations than folds, period doublings and
tori, and ending at an end of the span or at a limit at which nothing sticks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Literal

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.batched_points import (
    FollowedOrbits,
    exact_zeros,
    orbits_at_limits,
)
from slipfold.bifurcations.branches.batched_walk import BATCH, BatchedBranch, Walk
from slipfold.bifurcations.branches.bifurcations import is_genuine, span_end
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.make_branch import assemble, describe
from slipfold.bifurcations.branches.settings import Settings
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.bifurcations.branches.start import forced_orbits, measured_over, span_begin
from slipfold.bifurcations.branches.switching import emanating_branches
from slipfold.continuation import curve_set
from slipfold.continuation.curve_set import FollowedCurve
from slipfold.continuation.end import End
from slipfold.continuation.locate import LostCurveError
from slipfold.continuation.traced_curve import Found, TracedCurve
from slipfold.errors import BREAKDOWNS
from slipfold.flow.equilibrium import linear_responses
from slipfold.flow.explicit_steps import LinearizedSteps, linearized_steps_along
from slipfold.flow.flow import flow_of
from slipfold.models.model import Model
from slipfold.orbits.continued import hold_parameter
from slipfold.orbits.first_orbits import FIRST
from slipfold.orbits.kinds import ForcedOrbits
from slipfold.orbits.orbit_batch import ITERATIONS, OrbitBatch
from slipfold.orbits.orbit_curve import OrbitPoint
from slipfold.orbits.shooting import SEGMENTS, Shooting

Report = Callable[[str, float], None]
"""Called with the stage of the computation and the finished fraction of it."""


Wanted = Literal["orbits", "special", "loss"]
"""What a batch is to find: all orbits, the special points, or where stability is lost alone."""


@dataclass(eq=False)
class BatchedCase:
    """A case with its branches in their order, as far as the batch followed it."""

    model: Model
    branches: list[BatchedBranch] = field(default_factory=list)
    failure: str = ""  # why it has to be followed individually
    seconds: float = 0.0  # its part of what the batch took, where that was measured
    described: dict[Found, SpecialPoint] = field(default_factory=dict)  # unless to the loss alone

    def leave(self, reason: str) -> None:
        """Leave the case, to be followed individually; the first reason counts."""
        self.failure = self.failure or reason

    @property
    def special(self) -> list[tuple[SpecialPoint, ...]]:
        """Special points of each branch, with normal forms and uncertainties."""
        return [tuple(map(self.described.__getitem__, item.found)) for item in self.branches]

    def assembled(self, vary: str, first: float) -> tuple[Branch, ...]:
        """Return the branches as data, from the first value of the span."""
        curves, leads = list[FollowedCurve[OrbitPoint]](), dict[Found[OrbitPoint], list[int]]()
        for number, item in enumerate(self.branches, 1):
            start = curve_set.Start(
                item.orbits,
                (item.points[0],),
                departs=item.origin is not None,
                parent=item.parent,
                found=item.origin,
            )
            traced = TracedCurve(item.orbits, item.points, start.departs, item.found, item.stopped)
            curves.append(FollowedCurve(number, start, traced, None))
            if item.origin is not None:
                leads.setdefault(item.origin, []).append(number)
        return assemble(curves, leads, span_begin(vary, first), self.described)


def follow_batch(
    models: Sequence[Model],
    vary: str,
    span: tuple[float, float],
    settings: Settings,
    report: Report = lambda stage, fraction: None,
    *,
    wanted: Wanted = "orbits",
) -> list[BatchedCase]:
    """Follow the responses of models of one kind, with all orbits or with special points alone.

    If the loss is wanted alone, a branch ends where it first loses its stability, and special
    points are not described.
    The results of a case do not depend on the other cases. The shorter periods come first.
    """
    report("equations", 0.0)
    steps = _steps_for(models[0], vary, settings)
    if steps is None:
        return [BatchedCase(model, failure="another kind of model") for model in models]
    models = [model.replace(**{vary: span[0]}) for model in models]
    models = [
        model if model.estimated_scales is not None else measured_over(model, vary, span)
        for model in models
    ]
    cases = [BatchedCase(model) for model in models]
    vectors = np.array([model.vector for model in models])
    scales = np.array([[model.state_scales(), model.step_scales()] for model in models])
    width, tolerance = abs(span[1] - span[0]), settings.newton.tolerance
    orbits = OrbitBatch(models[0], vectors, scales, (vary, width), steps=steps)
    branches = _responses(orbits, cases, float(np.sign(span[1] - span[0])), settings)
    while branches:
        walk = Walk(orbits, branches, span, settings.steps, to_loss=wanted == "loss")
        walk.run(partial(report, f"branches of period {orbits.period}"))
        stage = f"orbits of period {orbits.period}"
        report(stage, 0.0)
        locate_bifurcations(orbits, cases, branches, span, tolerance)
        if wanted == "orbits":
            report(stage, 0.5)
            refine_points(orbits, cases, branches, tolerance)
        branches = doubled_branches(cases, orbits.period, settings)
        orbits = orbits.of_period(2 * orbits.period)
    if wanted != "loss":
        report("normal forms", 0.0)
        followed = [item for case in cases if not case.failure for item in case.branches]
        results = [found for branch in followed for found in branch.found]
        described = dict(zip(results, describe(results), strict=True))
        for case in cases:
            case.described = described
    return cases


def _steps_for(model: Model, vary: str, settings: Settings) -> LinearizedSteps | None:
    """Return the explicit steps for a kind of models; None if these or settings forbid them."""
    if not model.forced or model.resting or np.any(model.angle_periods):
        return None
    steps = settings.steps
    allowed = (
        settings.discretization != "collocation"
        and settings.newton.iterations >= ITERATIONS
        and steps.smallest <= BATCH.smallest
        and steps.largest * BATCH.max_rounds > 4  # several spans
    )
    return linearized_steps_along(vary)(model) if allowed else None


# -- where branches begin --------------------------------------------------------------------------


def _responses(
    orbits: OrbitBatch, cases: Sequence[BatchedCase], forward: float, settings: Settings
) -> list[BatchedBranch]:
    """Find the responses at the first value, from the linear ones."""
    flow, curves = flow_of(orbits.model), dict[int, ForcedOrbits]()
    for number, case in enumerate(cases):
        case.failure = "no linear response"
        with suppress(*BREAKDOWNS):
            curve = forced_orbits(case.model, orbits.vary, orbits.width, settings)
            if isinstance(curve.by, Shooting):
                curves[number], case.failure = curve, ""
    if not curves:
        return []
    which = np.array(list(curves))
    rows = np.tile(hold_parameter(orbits.size) * forward, (len(curves), 1))
    constants, scales = flow.constants(orbits.parameters[which]), orbits.sizes[which]
    starts = np.array([cases[number].model.start for number in curves])
    nodes = linear_responses(flow, constants, scales, SEGMENTS, starts)
    values = np.array([cases[number].model.values[orbits.vary] for number in curves])
    guesses = orbits.join(which, nodes, values)
    result = orbits.correct(which, guesses, rows, BATCH.last_step, FIRST.near)
    branches = list[BatchedBranch]()
    for row, (number, curve) in enumerate(curves.items()):
        if result.found[row]:
            step = result.z[row], result.tangents[row], 0.0
            branches.append(BatchedBranch(number, curve, [step]))
        else:
            cases[number].leave("no response")
    return branches


def doubled_branches(
    cases: Sequence[BatchedCase], period: int, settings: Settings
) -> list[BatchedBranch]:
    """Return the branches of twice a period at their beginnings."""
    branches, largest = list[BatchedBranch](), settings.largest_period
    for number, case in enumerate(cases):
        parents = [item for item in enumerate(case.branches, 1) if item[1].orbits.period == period]
        for parent, branch in [] if case.failure else parents:
            for found in branch.found:
                try:
                    children = emanating_branches(branch.orbits, found, settings, largest)
                except BREAKDOWNS:
                    case.leave("emanating branch")
                    break
                for first in children:
                    step = first.z, first.tangent, 0.0
                    new = BatchedBranch(number, first.curve, [step], parent, found, first)
                    branches.append(new)
    return branches


# -- special points --------------------------------------------------------------------------------


def locate_bifurcations(
    orbits: OrbitBatch,
    cases: Sequence[BatchedCase],
    branches: Sequence[BatchedBranch],
    span: tuple[float, float],
    tolerance: float,
) -> None:
    """Add branches that were followed to their cases, with their bifurcations by the flow."""
    for branch in branches:
        cases[branch.case].branches.append(branch)
        if not branch.ordinary:
            cases[branch.case].leave(branch.end)
    within = [(item, branch) for branch in branches if branch.ordinary for item in branch.brackets]
    zeros = exact_zeros(orbits, [item for item, _ in within], tolerance)
    for (bracket, branch), found in zip(within, zeros, strict=True):
        case, (before, after) = cases[branch.case], bracket.unstable
        if isinstance(found, LostCurveError):
            case.leave("not located")
        elif not min(span) <= branch.orbits.value(found.point.z) <= max(span):
            case.leave("turns outside the span")
        elif is_genuine(found):
            branch.found.append(found)
            if before == 0 < after:
                branch.loss = branch.loss or found
            if before == after:
                case.leave("not accounted for")
        elif before != after:
            case.leave("not accounted for")


# -- all orbits of branches ------------------------------------------------------------------------


def refine_points(
    orbits: OrbitBatch,
    cases: Sequence[BatchedCase],
    branches: Sequence[BatchedBranch],
    tolerance: float,
) -> None:
    """Add all orbits to branches that were followed, and their ends, corrected by the flow."""
    ended = [branch for branch in branches if branch.ordinary]
    if not ended:
        return
    parts = [branch.steps[int(branch.first is not None) :] for branch in ended]
    rows = list[Array]()
    for branch, part in zip(ended, parts, strict=True):
        own = [tangent for _, tangent, _ in part]
        ends = [0] * (branch.first is None) + [-1] * (branch.end == "span")
        for end in ends:
            own[end] = hold_parameter(orbits.size) * np.sign(own[end][-1])
        rows += own
    which = np.repeat([branch.case for branch in ended], [len(part) for part in parts])
    z = np.array([step[0] for part in parts for step in part])
    result, last = orbits.settled(which, z, np.array(rows), tolerance), 0
    followed = list[FollowedOrbits]()
    for branch, part in zip(ended, parts, strict=True):
        own_orbits = result.of(slice(last, last + len(part)))
        followed.append(FollowedOrbits(branch, own_orbits, np.array([step[2] for step in part])))
        last += len(part)
    limits = orbits_at_limits(
        orbits, [item for item in followed if item.branch.end == "limit"], tolerance
    )
    for item in followed:
        complete(item, cases[item.branch.case], limits.get(item.branch), tolerance)


def complete(
    followed: FollowedOrbits, case: BatchedCase, limit: Found | Exception | None, tolerance: float
) -> None:
    """Add the points of a branch and its end."""
    branch, arclengths = followed.branch, followed.arclengths
    orbits, count = branch.orbits, len(arclengths)
    if branch.end == "limit":
        if not (isinstance(limit, Found) and limit.point.residual <= tolerance):
            case.leave("limit not located")
            return
        reached = limit.point.arclength
        if any(item.point.arclength >= reached for item in branch.found):
            case.leave("beyond the limit")
        count = int(np.count_nonzero(arclengths < reached))  # one too many were followed
    inner = followed.orbits.of(slice(count))
    if not (inner.residuals <= tolerance).all():
        case.leave("residual")
    if case.failure:
        return
    branch.points = [] if branch.first is None else [branch.first]
    known = enumerate(zip(arclengths[:count].tolist(), inner.residuals.tolist(), strict=True))
    branch.points += [inner.point(row, orbits, *given) for row, given in known]
    if not isinstance(limit, Found):
        branch.stopped = span_end(orbits, branch.points[-1])
        return
    branch.points.append(limit.point)
    broken = next(item for item in orbits.model.limits if item.name == limit.type)
    reason = broken.reason.format(value=limit.point.tests[limit.type] + broken.bound)
    branch.stopped = End("limit", reason, orbits.place(limit.point.z))
