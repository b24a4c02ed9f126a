"""What a motion comes to, by its Lyapunov exponents, told while they become known."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any

from slipfold.computations.long_term import lyapunov
from slipfold.explorer.messages import ExponentsRequest
from slipfold.explorer.start import start_of
from slipfold.explorer.views.numbers import number
from slipfold.models.model import Model
from slipfold.progress import Progress

TOLERANCE = 1e-6
"""Error of exponents at which a motion ends: more digits than the page shows."""

BETWEEN = 0.1
"""Least time between two notes of progress, in s."""


def tell_exponents(
    model: Model,
    request: ExponentsRequest,
    tell: Callable[[dict[str, Any]], None],
    check: Callable[[], None],
) -> None:
    """Compute the exponents of a motion and tell how far they are known; None is minus infinity."""
    told = perf_counter()

    def watch(progress: Progress) -> None:
        nonlocal told
        check()
        if perf_counter() - told >= BETWEEN:
            told = perf_counter()
            # Of an autonomous model they are an interval each, which tells the reader nothing.
            known = map(number, progress.values["exponents"] if model.forced else ())
            far = {"periods": progress.done, "total": progress.total}
            tell({**far, "exponents": list(known), "done": False})

    start = start_of(model, request)
    found = lyapunov(model, state=start, tolerance=TOLERANCE, observer=watch)
    verdict = found.verdict
    tell(
        {
            "kind_of_motion": verdict.kind,
            "period": verdict.period,
            "message": verdict.message,
            "exponents": [number(value) for value in found.exponents],
            "errors": [number(value) for value in found.errors],
            "per": found.per,
            "done": True,
        }
    )
