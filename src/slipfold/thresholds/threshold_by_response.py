"""The threshold of one set of parameters from its response: slow, and free of guesses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.branches import Branch, Progress, Settings, SpecialPoint, trace_response
from slipfold.errors import InputError
from slipfold.models.model import Model

__all__ = ["NO_THRESHOLD", "OnePoint", "lasting_reason", "threshold_by_response"]

Array = NDArray[np.float64]

NO_THRESHOLD = "no PD in the span"

FIRST_ALONE = Settings(largest_period=1)


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
    found: list[str] = []

    def watch(progress: Progress) -> None:
        found.extend(progress.special)
        if found:  # what comes later does not matter: stop the branch here
            raise KeyboardInterrupt

    try:
        branch = trace_response(model, vary, span, settings=FIRST_ALONE, observer=watch)[0]
    except InputError as error:
        return _nothing(len(model.states), "no response at the start of the span", str(error))
    if branch.interrupted and (not found or any(point.interrupted for point in branch.special)):
        raise KeyboardInterrupt  # that was the user
    return _judged(branch, vary, span)


def _judged(branch: Branch, vary: str, span: tuple[float, float]) -> OnePoint:
    size = len(branch.model.states)
    first = span[0]
    if branch.parameter[0] != first:
        return _nothing(size, "no response at the start of the span", branch.begun.reason)
    if not branch.stable[0]:
        return _nothing(
            size,
            "unstable at the start of the span",
            f"the response is unstable from the start of the span, {vary} = {first:g}; "
            "begin the span where it is stable",
        )
    if branch.special:
        point = branch.special[0]
        if point.type == "PD":
            return _threshold(branch, point)
        return _nothing(
            size,
            f"{point.type} comes first",
            f"the response loses its stability at {vary} = {point.value:.9g} by another "
            f"bifurcation, {point.name} ({point.type})",
        )
    if branch.stopped.kind == "span" and branch.parameter[-1] == span[1]:
        return _stable_to_the_end(branch, vary)
    reason = f"{branch.stopped.reason} (at {vary} = {branch.stopped.value:.9g}; stable up to there)"
    return _nothing(size, _end_kind(branch), reason)


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
