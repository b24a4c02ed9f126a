"""A motion that goes on by itself: where it sticks, meets a limit, or steps become very short."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.guarded_flow import Stop, guarded_flow_of
from slipfold.flow.switched.mode import Status
from slipfold.flow.switched.simulate import comes_to_rest, told_in_slip
from slipfold.flow.switched.switched_motion import SwitchedMotion
from slipfold.models.model import Model


class OwnMotion:
    """One motion, a few periods at a time.

    `stuck` says whether a contact stuck or was open in the last one.
    """

    def __init__(self, model: Model, constants: Constants, start: Array) -> None:
        self.model = model
        self.stopped: Stop | None = None
        self.stuck = False
        self._constants = constants
        # Elsewhere contacts may stick at any time.
        self._sticks = not told_in_slip(model, start[None], constants)
        self._weights = guarded_flow_of(model).weights(start, constants)
        self._switched: SwitchedMotion | None = None
        self._before = 0

    def go_on(self, state: Array, periods: int, done: int = 0) -> Array:
        """Carry a state over some periods, after some that are done, as far as it comes.

        Shapes: state (n,); returns (m, n), m <= periods.
        """
        found = [state]
        while len(found) <= periods and self.stopped is None:
            so_far = done + len(found) - 1
            if self._switched is None and not self._sticks:
                found += self._slipping(found[-1], periods + 1 - len(found), so_far)
            else:
                found += self._through_stick(found[-1], so_far)
        return np.array(found[1:]).reshape(-1, len(state))

    def _slipping(self, state: Array, periods: int, done: int) -> list[Array]:
        flow, found = guarded_flow_of(self.model), list[Array]()
        for piece in flow.pieces(state, periods, self._constants, done, self._weights):
            found += list(piece.states)
            if piece.stop is not None and comes_to_rest(piece.stop, self.model):
                last = found[-1] if found else state
                return found + self._through_stick(last, done + len(found))
            self.stopped = piece.stop
        self.stuck = False
        return found

    def _through_stick(self, state: Array, done: int) -> list[Array]:
        """Carry a state over a period in which a contact may stick."""
        if self._switched is None:
            self._switched, self._before = SwitchedMotion(self.model, state), done
        motion = self._switched
        first, seen = motion.modes[-1], len(motion.recorder.modes)
        motion.go_on(1)
        if motion.stopped is not None:
            later = self._before * motion.constants.period
            self.stopped = replace(motion.stopped, time=motion.stopped.time + later)
            return []
        modes = [first, *motion.recorder.modes[seen:]]
        self.stuck = any(status in (Status.STICK, Status.OPEN) for mode in modes for status in mode)
        if not self.stuck and not self._sticks:
            self._switched = None  # the next period may be one of those without events
        return [motion.strobe[-1]]
