"""Lyapunov exponents of a motion: how fast perturbations of it grow on average."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.simulate import comes_to_rest
from slipfold.long_term.birkhoff import average
from slipfold.long_term.growth import Growth, growth_from, growth_through_stick
from slipfold.long_term.rotation import rotation_of
from slipfold.long_term.verdict import Verdict, verdict_of
from slipfold.models.model import Model
from slipfold.models.parameter import DURATION
from slipfold.progress import Observer, Progress

FIRST = 250
"""Periods after which exponents are estimated first; from then on each time it is twice as many."""

MOST, LONGEST = 32_000, 128_000
"""Periods after which a motion ends if nobody says otherwise: if it is known what it is, or each
period is expensive; else. Of four states 128,000 take 9 s."""

CHEAP = 6
"""States of a motion without events up to which a period is cheap."""

SETTLED = 1e-9
"""Distance from a periodic response, in scaled states, at which the motion counts as settled."""


class Estimate(NamedTuple):
    """Exponents as they were after some periods, a period each."""

    periods: int
    exponents: Array  # shape (n,)
    errors: Array  # shape (n,)


@dataclass(frozen=True, eq=False)
class Exponents:
    """What was found; exponents are a period each, in descending order."""

    model: Model
    state: Array  # the last one, shape (n,)
    estimates: tuple[Estimate, ...]
    verdict: Verdict
    interrupted: bool


def find_exponents(
    model: Model,
    start: Array,
    periods: int | None,
    tolerance: float,
    observer: Observer | None = None,
) -> Exponents:
    """Follow a motion until its exponents are known to a tolerance, or for some periods.

    Shapes: start (n,).
    """
    try:
        return follow_exponents(growth_from(model, start), periods, tolerance, observer)
    except _Sticks:
        return follow_exponents(growth_through_stick(model, start), periods, tolerance, observer)


class _Sticks(Exception):
    """The motion goes on through stick."""


def follow_exponents(
    growth: Growth,
    periods: int | None,
    tolerance: float,
    observer: Observer | None,
) -> Exponents:
    """Let a motion go on until its exponents are known; keep what is known if interrupted."""
    cheap = len(growth.state) <= CHEAP and not growth.switches
    most = (LONGEST if cheap else MOST) if periods is None else periods
    ends = _ends(most)
    estimates: list[Estimate] = []
    interrupted = False
    try:
        for end in ends:
            while growth.periods < end:
                growth.go_on(min(FIRST, end - growth.periods))
                _refuse_ended(growth)
                if observer is not None:
                    known = tuple(estimates[-1].exponents.tolist()) if estimates else ()
                    told = "  ".join(f"{exponent:.6g}" for exponent in known) or "not yet"
                    text, values = f"exponents a period: {told}", {"exponents": known}
                    observer(Progress("periods", growth.periods, most, text, values))
            estimates.append(_estimate(growth))
            enough = estimates[-1].errors.max() <= tolerance or end >= MOST
            if periods is None and enough and _verdict(growth, estimates[-1]).known:
                break
    except KeyboardInterrupt:
        if growth.periods < FIRST:
            raise
        interrupted = True
        estimates.append(_estimate(growth))
    verdict = _verdict(growth, estimates[-1])
    if growth.model.forced and verdict.kind in ("torus", "undecided"):
        scales, turns = growth.model.state_scales(), growth.model.whole_turns
        verdict = verdict.with_rotation(rotation_of(growth.strobe, scales, turns))
    return Exponents(growth.model, growth.state, tuple(estimates), verdict, interrupted)


def _verdict(growth: Growth, last: Estimate) -> Verdict:
    model = growth.model
    seconds = None if model.forced else model.values[DURATION.name]
    return verdict_of(last.exponents, last.errors, growth.settlement(SETTLED), seconds)


def _ends(most: int) -> list[int]:
    """Return after how many periods exponents are estimated."""
    ends = [FIRST]
    while 2 * ends[-1] < most:
        ends.append(2 * ends[-1])
    return [*(end for end in ends if end < most), most]


def _refuse_ended(growth: Growth) -> None:
    stopped = growth.stopped
    if stopped is None:
        return
    if comes_to_rest(stopped, growth.model):
        raise _Sticks
    raise InputError(
        f"the motion has no exponents, it ends after {stopped.time:.6g} s: {stopped.reason}; start "
        "elsewhere or change a parameter"
    )


def _estimate(growth: Growth) -> Estimate:
    """Average over the second half: by then the frame has turned into the directions of growth."""
    rates = growth.logarithms
    found = average(rates[len(rates) // 2 :])
    order = np.argsort(-found.values, kind="stable")
    return Estimate(growth.periods, found.values[order], found.errors[order])
