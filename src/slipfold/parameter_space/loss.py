"""Where and by what a response first loses its stability."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.response import trace_response
from slipfold.bifurcations.branches.settings import Settings
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.bifurcations.branches.stability import loss_of_stability
from slipfold.models.model import Model
from slipfold.orbits.bifurcation_types import BIFURCATION_TYPES
from slipfold.progress import Progress

NO_RESPONSE, UNSTABLE, STABLE = "no response", "unstable", "stable"

NO_THRESHOLD, NOT_STARTED = "no PD in the span", "no response at the start of the span"


@dataclass(frozen=True, eq=False)
class Loss:
    """The end of the stable part of a branch."""

    threshold: float  # NaN if it does not lose its stability, or was never stable
    outcome: str  # the bifurcation, else what happens instead, in a word
    reason: str  # the same as a sentence; empty for a bifurcation
    point: SpecialPoint | None = None  # the bifurcation, where the branch was followed to it


def followed_to_loss(
    model: Model, vary: str, span: tuple[float, float], through_stick: bool = False
) -> Branch:
    """Follow the response of period 1 until it meets a bifurcation."""
    found: list[str] = []

    def watch(progress: Progress) -> None:
        found.extend(name for name in progress.values["special"] if name in BIFURCATION_TYPES)
        if found:  # what comes later does not matter: stop the branch here
            raise KeyboardInterrupt

    first = Settings(largest_period=1)
    branch = trace_response(
        model, vary, span, settings=first, observer=watch, through_stick=through_stick
    )[0]
    if branch.interrupted and (not found or any(item.interrupted for item in branch.special)):
        raise KeyboardInterrupt  # that was the user
    return branch


def unstable_from(vary: str, first: float) -> Loss:
    """Return the loss of a response that is unstable at first."""
    reason = (
        f"the response is unstable from the start of the span, {vary} = {first:g}; begin the "
        "span where it is stable"
    )
    return Loss(math.nan, UNSTABLE, reason)


def first_loss(branch: Branch, first: float) -> Loss:
    """Return where a branch that was to begin at a value first loses its stability."""
    vary, stable = branch.vary, branch.stable
    if branch.parameter[0] != first:
        return Loss(math.nan, NO_RESPONSE, branch.started.reason)
    if not stable[0]:
        return unstable_from(vary, first)
    point = loss_of_stability(branch)
    if point is not None:
        return Loss(float(point.value), point.type, "", point)
    if not stable.all():
        lost = branch.parameter[np.argmin(stable)]
        reason = f"no bifurcation was found before {vary} = {lost:.9g}"
        return Loss(math.nan, "unresolved", reason)
    stopped = branch.stopped
    kind = STABLE if stopped.kind == "span" else stopped.kind
    return Loss(math.nan, kind, f"{stopped.reason} (stable up to {vary} = {stopped.value:.9g})")


def grid_kind(loss: Loss, branch: Branch, last: float) -> tuple[str, str]:
    """Return why a response has no period doubling, in a few words and as a sentence.

    Both are empty where it loses its stability by one.
    """
    if loss.point is not None:
        if loss.outcome == "PD":
            return "", ""
        return (
            f"{loss.outcome} comes first",
            f"the response loses its stability at {branch.vary} = {loss.threshold:.9g} by another "
            f"bifurcation, {loss.point.name} ({loss.outcome})",
        )
    if loss.outcome == STABLE and branch.parameter[-1] == last:
        return NO_THRESHOLD, lasting_reason(branch.vary, last)
    kinds = {NO_RESPONSE: NOT_STARTED, UNSTABLE: "unstable at the start of the span"}
    return kinds.get(loss.outcome) or _end_kind(branch), loss.reason


def lasting_reason(vary: str, value: float) -> str:
    """Say that a response is stable to the end of the span."""
    return f"the response of period 1 is stable up to the end of the span, {vary} = {value:g}"


def _end_kind(branch: Branch) -> str:
    """Name the limit of the model that ended the branch; else say how it ended."""
    stopped = branch.stopped
    for limit in branch.model.limits if stopped.kind == "limit" else ():
        if stopped.reason.startswith(limit.reason.partition("{")[0]):
            return f"limit: {limit.name}"
    others = {"limit": "limit", "span": "the response turns back"}
    return others.get(stopped.kind, f"response {stopped.kind}")
