"""Whether an autonomous motion with changes has settled, judged from the states at them."""

from __future__ import annotations

import math

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.settling.settlement import ROUNDING, Settlement
from slipfold.flow.switched.history import Change

LONGEST = 64
"""Changes in a cycle at most."""

ROUNDS = 4
"""Rounds that must repeat each other."""


def judge_changes(
    changes: list[Change], scales: Array, tolerance: float, unit: float, time: float
) -> Settlement:
    """Judge from the last changes whether a motion repeats itself.

    Of a cycle of k changes the last rounds must have the same modes in the same order. It is
    settled where states differ by less than the tolerance from round to round, and by as much as
    they will still do, if that shrinks from round to round. `unit` is the duration of a phase.

    Shapes: scales (n,).
    """
    for length in range(1, min(LONGEST, len(changes) // ROUNDS) + 1):
        last = changes[-ROUNDS * length :]
        if any(last[i].mode != last[i + length].mode for i in range(len(last) - length)):
            continue
        gaps = [_distance(last, i, length, scales) for i in range(ROUNDS - 1)]
        drift = gaps[-1]
        rate = drift / gaps[0] if gaps[0] > ROUNDING else None
        if drift > tolerance or (rate is not None and rate >= 1 and drift > ROUNDING):
            continue
        left = drift if rate is None else drift * math.sqrt(rate) / (1 - math.sqrt(rate))
        if left > tolerance:
            continue
        duration = (last[-1].time - last[-1 - length].time) * unit
        message = (
            f"settled on a cycle of {duration:.9g} s ({1 / duration:.6g} Hz) with stick and slip; "
            f"it repeats within {max(drift, 1e-16):.1e}"
        )
        return Settlement(True, 1, drift, rate, message, duration=duration, kind="cycle")
    message = f"not settled after {time:.6g} s: stick and slip do not repeat yet; simulate longer"
    return Settlement(False, None, math.nan, None, message)


def _distance(last: list[Change], turn: int, length: int, scales: Array) -> float:
    """Return how far a round is from the next one."""
    first = last[turn * length : (turn + 1) * length]
    second = last[(turn + 1) * length : (turn + 2) * length]
    return max(
        float(np.abs((after.state - before.state) / scales).max())
        for before, after in zip(first, second, strict=True)
    )
