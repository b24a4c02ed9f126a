"""The response of stiff motion: Newton's method on what implicit steps make of a forcing period."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.newton import Correction, correct
from slipfold.flow.dense_motion import DenseMotion
from slipfold.flow.implicit.takeover import Takeover
from slipfold.flow.simulate import simulate
from slipfold.flow.sizes.typical_sizes import measured
from slipfold.models.model import Model
from slipfold.models.turns import without_turns
from slipfold.newton import Rule, find_root, solve_each
from slipfold.orbits.carry_to import hold_parameter
from slipfold.orbits.discretisations.collocation import Collocation
from slipfold.orbits.forced_orbits import ForcedOrbits
from slipfold.orbits.spectrum.product import product

SETTLING = (2, 20, 80)
"""Further forcing periods after which Newton's method is begun: two are half a second."""

BUDGET = 60_000
"""Implicit steps in which an orbit is found or given up: half a minute."""

CLOSED = Rule(close=1e-9, iterations=12)
"""The motion before a step this short, in scaled states, is an orbit."""


def is_stiff(orbits: ForcedOrbits, value: float) -> bool:
    """Whether motion from rest decays so fast that it takes implicit steps.

    Not where it leaves the model before a period has passed.
    """
    model = orbits.model.replace(**{orbits.vary: value})
    if model.limits and simulate(model, 1).stopped is not None:
        return False
    constants = orbits.flow.constants(model.vector, orbits.flow_scales)
    return orbits.flow.is_stiff(model.start, constants)


def stiff_response(
    orbits: ForcedOrbits, value: float, tell: Callable[[int], None] = lambda periods: None
) -> tuple[ForcedOrbits, Correction] | None:
    """Return a response of period 1 by collocation, None if motion from rest leads to none.

    What is told is after how many forcing periods the search is.

    The mesh has the steps of the motion, which are short where states turn sharply: of a knee that
    lasts a millionth of the period an even one knows nothing.
    """
    model = orbits.model.replace(**{orbits.vary: value})
    constants = orbits.flow.constants(model.vector, orbits.flow_scales)
    motion = _Search(Takeover(orbits.flow, constants), model, tell).closed()
    if motion is None:
        return None
    edges = motion.phases
    nodes = motion.at(edges[:-1])
    sized = measured(model, motion=nodes)  # what shooting was measured by may be far too small
    free = {orbits.vary: orbits.width}
    even = Collocation(sized, free, edges=edges)
    by = even.on(edges, even.scheme(nodes, constants))
    other = ForcedOrbits(sized, free, by=lambda *_: by)
    return other, correct(other, other.pack(nodes, value), hold_parameter(other.size))


class _Search:
    """The search for a motion that ends where it began after a period."""

    def __init__(self, takeover: Takeover, model: Model, tell: Callable[[int], None]) -> None:
        self._takeover, self._model, self._tell = takeover, model, tell
        self._periods = self._steps = 0

    def closed(self) -> DenseMotion | None:
        """Return such a motion, None where motion from rest leads to none within the budget."""
        state = self._model.start
        for periods in SETTLING:
            for _ in range(periods):
                settling = self._period(state)
                if settling is None:
                    return None
                state = _end(settling, self._model)
            found = self._closed_near(state)
            if found is not None:
                return found
        return None

    def _period(self, state: Array) -> DenseMotion | None:
        """Return the motion of a period, None if it does not end or the budget is used up."""
        self._tell(self._periods)
        motion = None if self._steps >= BUDGET else self._takeover.period(state)
        if motion is not None:
            self._periods += 1
            self._steps += len(motion.phases) - 1
        return motion

    def _closed_near(self, state: Array) -> DenseMotion | None:
        """Correct where a motion begins by Newton's method."""
        takeover, model = self._takeover, self._model
        scales, last = takeover.field.scales, None

        def step(scaled: Array) -> Array:
            nonlocal last
            last = self._period(scaled * scales)
            if last is None:
                return np.full_like(scaled, np.nan)
            gap = without_turns(_end(last, model) / scales - scaled, model.whole_turns / scales)
            monodromy = product(takeover.matrices(last, last.phases))
            return solve_each(np.eye(len(gap)) - monodromy[None], gap[None])[0]

        return last if find_root(step, state / scales, CLOSED) is not None else None


def _end(motion: DenseMotion, model: Model) -> Array:
    return without_turns(motion.at(motion.phases[-1:])[0], model.whole_turns)
