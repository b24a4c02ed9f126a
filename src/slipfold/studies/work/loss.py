"""Where and by what a response first loses its stability."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slipfold.branches.branch import Branch
from slipfold.branches.stability import loss_of_stability
from slipfold.models.model import Model
from slipfold.studies.work.work import Quantity, Value

__all__ = ["Loss", "first_loss", "loss_quantities"]


@dataclass(frozen=True)
class Loss:
    """How far along a branch is stable."""

    threshold: float  # NaN if it does not lose its stability, or was never stable
    outcome: str  # the bifurcation, else what happens instead, in a word
    reason: str  # the same as a sentence; empty for a bifurcation

    def values(self) -> dict[str, Value]:
        """Return it under the names of `loss_quantities`."""
        threshold = None if math.isnan(self.threshold) else self.threshold
        return {"threshold": threshold, "outcome": self.outcome, "reason": self.reason}


def loss_quantities(model: Model, vary: str) -> tuple[Quantity, ...]:
    """Return what is said of the first loss of stability."""
    return (
        Quantity("threshold", "real", f"{vary} where the response first loses its stability",
                 model.parameter(vary).unit),
        Quantity("outcome", "text", "bifurcation by which it is lost; else stable, unstable from "
                 "the start, or how a stable response ends"),
        Quantity("reason", "text", "why there is no threshold"),
    )  # fmt: skip


def first_loss(branch: Branch, first: float) -> Loss:
    """Return where a branch that was to begin at a value first loses its stability."""
    vary, stable = branch.vary, branch.stable
    if branch.parameter[0] != first:
        return Loss(math.nan, "no response", branch.begun.reason)
    if not stable[0]:
        reason = f"the response is unstable from the start of the span, {vary} = {first:g}"
        return Loss(math.nan, "unstable", reason)
    point = loss_of_stability(branch)
    if point is not None:
        return Loss(float(point.value), point.type, "")
    if not stable.all():
        lost = branch.parameter[np.argmin(stable)]
        reason = f"no bifurcation was found before {vary} = {lost:.9g}"
        return Loss(math.nan, "unresolved", reason)
    stopped = branch.stopped
    kind = "stable" if stopped.kind == "span" else stopped.kind
    return Loss(math.nan, kind, f"{stopped.reason} (stable up to {vary} = {stopped.value:.9g})")
