"""Many motions from states of their own, that go on for some periods at a time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.ensembles import strobe_many
from slipfold.flow.flow import flow_of
from slipfold.flow.guarded_flow import Stop
from slipfold.models.model import Model


class Motions:
    """Motions side by side; where contacts come to stick a motion goes on through that.

    Periods are the forcing's, of an autonomous model intervals of its ``duration``.
    """

    def __init__(self, model: Model, starts: Array) -> None:
        self.model = model
        self.states = starts.copy()  # shape (k, n)
        self.stops: dict[int, Stop] = {}  # why motions ended, by their place
        self.stuck = np.zeros(len(starts), bool)  # whether contacts stuck in the last periods
        self._periods = np.zeros(len(starts), int)
        self._period = flow_of(model).constants_of(model).period

    def go_on(self, which: NDArray[np.intp], periods: int) -> Array:
        """Let some motions go on; return their states at the start of each period and the end.

        What comes after the end of a motion is no number. Shapes: returns (k, periods + 1, n).
        """
        points = strobe_many(self.model, self.states[which], None, periods)
        known = np.isfinite(points.states).all(axis=2).sum(axis=1)
        self.states[which] = points.states[np.arange(len(which)), known - 1]
        self.stuck[which] = points.stuck.any(axis=1)
        for place, stop in zip(which, points.stopped, strict=True):
            if stop is not None:
                before = self._periods[place] * self._period
                self.stops[int(place)] = replace(stop, time=before + stop.time)
        self._periods[which] += known - 1
        return points.states
