"""Where and by what a response first loses its stability."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slipfold.branches import Branch, Progress, Settings, SpecialPoint, trace_response
from slipfold.branches.special_point import BIFURCATIONS
from slipfold.branches.stability import loss_of_stability
from slipfold.models.model import Model

FIRST_ALONE = Settings(largest_period=1)

NO_RESPONSE, UNSTABLE, STABLE = "no response", "unstable", "stable"


@dataclass(frozen=True, eq=False)
class Loss:
    """How far along a branch is stable."""

    threshold: float  # NaN if it does not lose its stability, or was never stable
    outcome: str  # the bifurcation, else what happens instead, in a word
    reason: str  # the same as a sentence; empty for a bifurcation
    point: SpecialPoint | None = None  # the bifurcation, where it has been followed to it

    def values(self) -> dict[str, float | int | str | None]:
        """Return it as plain data."""
        threshold = None if math.isnan(self.threshold) else self.threshold
        return {"threshold": threshold, "outcome": self.outcome, "reason": self.reason}


def followed_to_loss(
    model: Model, vary: str, span: tuple[float, float], through_stick: bool = False
) -> Branch:
    """Follow the response of period 1 until it meets a bifurcation."""
    found: list[str] = []

    def watch(progress: Progress) -> None:
        found.extend(name for name in progress.special if name in BIFURCATIONS)
        if found:  # what comes later does not matter: stop the branch here
            raise KeyboardInterrupt

    branch = trace_response(
        model, vary, span, settings=FIRST_ALONE, observer=watch, through_stick=through_stick
    )[0]
    if branch.interrupted and (not found or any(item.interrupted for item in branch.special)):
        raise KeyboardInterrupt  # that was the user
    return branch


def unstable_from(vary: str, first: float) -> Loss:
    """Say that there is no stability to lose."""
    reason = (
        f"the response is unstable from the start of the span, {vary} = {first:g}; begin the "
        "span where it is stable"
    )
    return Loss(math.nan, UNSTABLE, reason)


def first_loss(branch: Branch, first: float) -> Loss:
    """Return where a branch that was to begin at a value first loses its stability."""
    vary, stable = branch.vary, branch.stable
    if branch.parameter[0] != first:
        return Loss(math.nan, NO_RESPONSE, branch.begun.reason)
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
