"""Tori as lines: what an output reaches on them, in stretches of one stability each."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator

from slipfold.arrays import Array
from slipfold.lines.knots import runs
from slipfold.lines.of_branches import OTHER, PIECES, STABLE, STUCK, Stretch, measure_of
from slipfold.tori.torus_branch import TorusBranch

GAP = ""
"""Kind of a stretch that is not drawn."""


def torus_stretches(tori: TorusBranch, output: str, measure: str = "max") -> tuple[Stretch, ...]:
    """Draw lines between tori; none for what contacts do, since tori always slip.

    From the orbit that they are born from tori grow as the square root of the distance. Further on
    there may be many in one place and few in another, between which no polynomial swings. Across
    circles that were left out there is no line.
    """
    if len(tori) < 2 or measure == STUCK:
        return ()
    parameter, value = tori.parameter, measure_of(tori.extrema, output, measure)
    steps = [np.diff(item) / (np.ptp(item) or 1.0) for item in (parameter, value)]
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*steps))])
    places = np.arange(PIECES * (len(s) - 1) + 1) / PIECES
    at = np.interp(places, np.arange(len(s)), s)
    along, reached = (_grown(item, s, at) for item in (parameter, value))
    if tori.parent:
        along[: PIECES + 1] = (
            parameter[0] + (parameter[1] - parameter[0]) * places[: PIECES + 1] ** 2
        )
    kinds = np.where(tori.stable[1:], STABLE, OTHER)
    kinds[tori.omitted[:-1] > 0] = GAP
    lines = []
    for kind, first, last in runs(kinds.tolist()):
        if kind == GAP:
            continue
        part = slice(PIECES * first, PIECES * last + 1)
        lines.append(Stretch(kind, at[part], along[part], reached[part]))
    return tuple(lines)


def _grown(values: Array, s: Array, at: Array) -> Array:
    """Return values along a line, straight up to the first torus."""
    if len(s) == 2:
        return np.interp(at, s, values)
    smooth = PchipInterpolator(s[1:], values[1:])
    return np.where(at < s[1], np.interp(at, s, values), smooth(np.maximum(at, s[1])))
