"""Motions with parameters of their own that march in step from one forcing period to the next."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.strobes.explicit_steps import MOST, explicit_steps_of
from slipfold.models.model import Model

TOGETHER = 512
"""Motions in a march: enough to hide what a call costs, few enough for the processor's cache."""

CALLS = (2, 3, 4, 5, 6, 8, 10, 12, 16, 24, 32, 48, 64, 96, 128)
"""Calls in a forcing period, each of a few steps."""

FIRST = 4
"""Calls in the first period, if they are of four steps."""

HALVINGS = 9
"""Times that the steps of one motion are halved before that motion is left behind."""

ORDER = 8

TOLERANCE = 1e-9
"""Error that four steps may make by an estimate of lower order, in scales: they make a tenth."""

MANY = 0.2
"""Share of calls repeated for single motions from which on all take shorter steps."""

FEW = 0.02
"""Share of them below which all may take longer ones."""


class March:
    """Motions that march together.

    Steps that are too long for some of them, or in which they might meet a limit, are halved for
    these alone. The number of steps in a period follows from how many that are.
    """

    def __init__(self, model: Model, constants: Constants) -> None:
        self._steps = explicit_steps_of(model)
        self._n = n = len(model.states)
        known = np.atleast_2d(constants.known).T
        self._work = np.zeros((n + 2 + len(known), known.shape[1]))
        self._work[n + 2 :] = known
        self._values = np.empty((n + 1, known.shape[1]))
        self._place = CALLS.index(FIRST * MOST // self._steps.count)

    def period(self, states: Array) -> Array:
        """Carry states over a forcing period; NaN where a motion is left behind.

        Shapes: states (n, m); returns (n, m).
        """
        return self._through(states, CALLS[self._place])[-1]

    def samples(self, states: Array, count: int) -> Array:
        """Return what lies between: states at equal intervals of a period, the first ones first.

        Shapes: states (n, m); returns (count, n, m).
        """
        return self._through(states, count, every=True)[:-1]

    def _through(self, states: Array, calls: int, *, every: bool = False) -> Array:
        """Carry states over a period in so many calls; return the last ones, or every one."""
        n, work, values = self._n, self._work, self._values
        behind = np.zeros(states.shape[1], bool)
        found = np.empty((calls + 1 if every else 1, *states.shape))
        found[0] = states
        work[:n], work[n + 1], repeated, worst = states, 1 / (calls * self._steps.count), 0, 0.0
        for call in range(calls):
            work[n] = call / calls
            self._steps.function(work, outputs=values)
            error = float(values[n].max())
            if not error <= TOLERANCE:
                again = self._too_long(values) & ~behind
                error = float(values[n].max(initial=0.0, where=~again & ~behind))
                repeated += int(np.count_nonzero(again))
                self._halve(again, behind)
                values[:n, behind] = states[:, behind]
            worst = max(worst, error)
            work[:n] = values[:n]
            if every:
                found[call + 1] = values[:n]
                found[call + 1, :, behind] = np.nan
        if not every:
            self._pace(repeated / (calls * states.shape[1]), worst)
            found[0] = work[:n]
            found[0][:, behind] = np.nan
        return found

    def _halve(self, again: NDArray[np.bool_], behind: NDArray[np.bool_]) -> None:
        """Repeat the last steps for some motions at half their length, and these if need be."""
        which = np.flatnonzero(again)
        ends, arrived = self._in_halves(self._work[:, which], HALVINGS)
        self._values[: self._n, which] = ends
        behind[which[~arrived]] = True

    def _in_halves(self, work: Array, left: int) -> tuple[Array, NDArray[np.bool_]]:
        """Return the states after some steps, and of which motions they can be trusted."""
        n = self._n
        arrived = np.full(work.shape[1], left > 0)
        if left == 0:
            return work[:n], arrived
        here = work.copy()
        here[n + 1] /= 2
        for _ in range(2):
            going = np.flatnonzero(arrived)
            part = np.ascontiguousarray(here[:, going])
            values = self._steps.function(part)
            again = np.flatnonzero(self._too_long(values))
            if len(again):
                redone, fine = self._in_halves(part[:, again], left - 1)
                values[:n, again] = redone
                arrived[going[again]] = fine
            here[:n, going] = values[:n]
            here[n] += here[n + 1] * self._steps.count
        return here[:n], arrived

    def _too_long(self, values: Array) -> NDArray[np.bool_]:
        return ~(values[self._n] <= TOLERANCE)

    def _pace(self, repeated: float, worst: float) -> None:
        """Choose the number of steps in the next period."""
        place = self._place
        if repeated > MANY:
            self._place = min(place + 1, len(CALLS) - 1)
        elif repeated < FEW and place > 0:
            longer = CALLS[place] / CALLS[place - 1]
            self._place -= 2 * worst * longer**ORDER < TOLERANCE
