"""The threshold of one set of parameters from its response: slow, and free of guesses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.branches import Branch, SpecialPoint
from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.thresholds.first_loss import (
    NO_RESPONSE,
    STABLE,
    UNSTABLE,
    first_loss,
    followed_to_loss,
)

NO_THRESHOLD = "no PD in the span"

NOT_BEGUN = "no response at the start of the span"


@dataclass(frozen=True, eq=False)
class OnePoint:
    """What the response of one set of parameters says."""

    # Empty where the response loses its stability by period doubling, else what happens instead, in
    # a few words
    kind: str
    reason: str  # the same as a sentence; empty likewise
    # Where the stable part of the response ends: the threshold, or the end of the span if the kind
    # is `NO_THRESHOLD`; NaN elsewhere
    value: float
    # The parameter along the response, shape (k,), and the states at phase zero, shape (k, n), up
    # to that value. Empty where it is NaN.
    values: Array
    states: Array
    multipliers: NDArray[np.complex128]  # Floquet multipliers there, shape (n,)
    residual: float  # how far the orbit there fails to close, in scaled states


def lasting_reason(vary: str, value: float) -> str:
    """Say that a response is stable to the end of the span."""
    return f"the response of period 1 is stable up to the end of the span, {vary} = {value:g}"


def threshold_by_response(model: Model, vary: str, span: tuple[float, float]) -> OnePoint:
    """Follow the response of period 1 to its first bifurcation."""
    size = len(model.states)
    try:
        branch = followed_to_loss(model, vary, span)
    except InputError as error:
        return _nothing(size, NOT_BEGUN, str(error))
    loss = first_loss(branch, span[0])
    if loss.point is not None and loss.outcome == "PD":
        return _threshold(branch, loss.point)
    if loss.point is not None:
        name = f"{loss.point.name} ({loss.outcome})"
        reason = (
            f"the response loses its stability at {vary} = {loss.threshold:.9g} by another "
            f"bifurcation, {name}"
        )
        return _nothing(size, f"{loss.outcome} comes first", reason)
    if loss.outcome == STABLE and branch.parameter[-1] == span[1]:
        return _stable_to_the_end(branch, vary)
    kinds = {NO_RESPONSE: NOT_BEGUN, UNSTABLE: "unstable at the start of the span"}
    return _nothing(size, kinds.get(loss.outcome) or _end_kind(branch), loss.reason)


def _threshold(branch: Branch, point: SpecialPoint) -> OnePoint:
    before = branch.arclength < point.arclength
    return OnePoint(
        "",
        "",
        point.value,
        np.append(branch.parameter[before], point.value),
        np.vstack([branch.states[before], point.state]),
        point.multipliers,
        point.residual,
    )


def _stable_to_the_end(branch: Branch, vary: str) -> OnePoint:
    value = float(branch.parameter[-1])
    return OnePoint(
        NO_THRESHOLD,
        lasting_reason(vary, value),
        value,
        branch.parameter,
        branch.states,
        branch.multipliers[-1],
        float(branch.residual[-1]),
    )


def _end_kind(branch: Branch) -> str:
    """Name the limit of the model that ended the branch; else say how it ended."""
    if branch.stopped.kind == "limit":
        for limit in branch.model.limits:
            if branch.stopped.reason.startswith(limit.reason.partition("{")[0]):
                return f"limit: {limit.name}"
    return {"limit": "limit", "span": "the response turns back"}.get(
        branch.stopped.kind, f"response {branch.stopped.kind}"
    )


def _nothing(size: int, kind: str, reason: str) -> OnePoint:
    return OnePoint(
        kind,
        reason,
        np.nan,
        np.empty(0),
        np.empty((0, size)),
        np.full(size, np.nan, complex),
        np.nan,
    )
