"""A motion through stick and slip carried again by other steps."""

from __future__ import annotations

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.switched.mode import Mode, shown
from slipfold.flow.switched.switched_flow import SwitchedFlow
from slipfold.flow.switched.switched_motion import Broken, legs

FIRST = 0.0137
"""Share of a period after which it is begun anew, so that all steps but the first fall
elsewhere."""


def elsewhere(
    flow: SwitchedFlow, mode: Mode, state: Array, end: float, constants: Constants, weights: Array
) -> tuple[Array, list[Mode]]:
    """Return what a state comes to from phase zero by other steps, and the modes on its way.

    It is NaN if it does not get there. Shapes: state (n,).
    """
    begin, passed = 0.0, [mode]
    try:
        for until in (FIRST * end, end):
            for leg, after in legs(flow, mode, state, until, constants, weights, begin=begin):
                state, mode = leg.state, shown(after)
                passed += [mode] if mode != passed[-1] else []
            begin = until
    except Broken:
        return np.full(len(state), np.nan), passed
    return state, passed
